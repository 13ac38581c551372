//! Shape: nearness of the worst corner to that of a square, blind to size and rotation.

use super::{Card, Corners};
use csalf_geom::Point2;

/// Metric card.
pub const CARD: Card = Card {
    name: "shape",
    dimension: "1",
    acceptable: (0.3, 1.0),
    normal: (0.0, 1.0),
    full: (0.0, 1.0),
    unit_square: 1.0,
    source: "Verdict 2007, quad shape",
};

/// 2 min over the corners of J_k / (L_k² + L_{k-1}²), 0 to 1, ideal 1; 0 of a quad that is not strictly
/// convex.
#[inline]
pub fn value(p: &[Point2; 4]) -> f64 {
    of_corners(&Corners::new(p))
}

/// [`value`] from corner data.
#[inline]
pub fn of_corners(c: &Corners<4>) -> f64 {
    let mut worst = f64::INFINITY;
    for k in 0..4 {
        let (a, b) = (c.length[k], c.length[(k + 3) % 4]);
        let d = a * a + b * b;
        worst = worst.min(if d > 0.0 { 2.0 * c.jacobian[k] / d } else { 0.0 });
    }
    worst.max(0.0)
}
