//! Jacobian ratio: how much the area element varies over the quad.

use super::{Card, Corners};
use csalf_geom::Point2;

/// Metric card.
pub const CARD: Card = Card {
    name: "Jacobian ratio",
    dimension: "1",
    acceptable: (0.5, 1.0),
    normal: (0.0, 1.0),
    full: (f64::NEG_INFINITY, 1.0),
    unit_square: 1.0,
    source: "paper eq. 21, inverted (handbook 1.12): corner Jacobians, not Gauss points",
};

/// Jmin / Jmax over the corners, ideal 1; 0 or less of a quad that is not strictly convex, -inf if no corner
/// Jacobian is positive. Blind to skew and aspect: 1 for every parallelogram.
#[inline]
pub fn value(p: &[Point2; 4]) -> f64 {
    of_corners(&Corners::new(p))
}

/// [`value`] from corner data.
#[inline]
pub fn of_corners(c: &Corners<4>) -> f64 {
    let lo = c.jacobian.iter().copied().fold(f64::INFINITY, f64::min);
    let hi = c.jacobian.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if hi > 0.0 { lo / hi } else { f64::NEG_INFINITY }
}
