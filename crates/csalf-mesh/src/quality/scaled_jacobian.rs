//! Scaled Jacobian: the worst sine of the corner angles.

use super::{Card, Corners};
use csalf_geom::Point2;

/// Metric card.
pub const CARD: Card = Card {
    name: "scaled Jacobian",
    dimension: "1",
    acceptable: (0.3, 1.0),
    normal: (-1.0, 1.0),
    full: (-1.0, 1.0),
    unit_square: 1.0,
    source: "Verdict 2007, quad scaled Jacobian",
};

/// min over the corners of J_k / (L_k L_{k-1}), -1 to 1, ideal 1. Signed by the orientation of the plane: a
/// clockwise quad has a negative value (Verdict, which works in space, orients each quad by its own normal).
#[inline]
pub fn value(p: &[Point2; 4]) -> f64 {
    Corners::new(p).min_scaled()
}

/// The same of a triangle, scaled so that the equilateral one has 1 (Verdict's triangle scaled Jacobian).
#[inline]
pub fn of_triangle(p: &[Point2; 3]) -> f64 {
    Corners::new(p).min_scaled() * 2.0 / 3f64.sqrt()
}
