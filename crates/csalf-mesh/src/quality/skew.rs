//! Skew: how far the principal axes are from a right angle.

use super::Card;
use csalf_geom::Point2;

/// Metric card.
pub const CARD: Card = Card {
    name: "skew",
    dimension: "1",
    acceptable: (0.0, 0.5),
    normal: (0.0, 1.0),
    full: (0.0, 1.0),
    unit_square: 0.0,
    source: "Verdict 2007, quad skew",
};

/// |cos| of the angle between the principal axes (the lines between midpoints of opposite sides), 0 to 1,
/// ideal 0; 0 if an axis has no length (as in Verdict).
#[inline]
pub fn value(p: &[Point2; 4]) -> f64 {
    let x1 = (p[1] - p[0]) + (p[2] - p[3]);
    let x2 = (p[2] - p[1]) + (p[3] - p[0]);
    let l = x1.length() * x2.length();
    if l > 0.0 { (x1.dot(x2) / l).abs() } else { 0.0 }
}
