//! Smallest and largest interior corner angle.

use super::Card;
use csalf_geom::{Point2, angle::turn};

/// Metric card of the smallest angle.
pub const MIN_CARD: Card = Card {
    name: "minimum angle",
    dimension: "degrees",
    acceptable: (45.0, 90.0),
    normal: (0.0, 90.0),
    full: (0.0, 360.0),
    unit_square: 90.0,
    source: "Verdict 2007, quad minimum angle",
};

/// Metric card of the largest angle.
pub const MAX_CARD: Card = Card {
    name: "maximum angle",
    dimension: "degrees",
    acceptable: (90.0, 135.0),
    normal: (90.0, 360.0),
    full: (0.0, 360.0),
    unit_square: 90.0,
    source: "Verdict 2007, quad maximum angle",
};

/// Smallest and largest interior angle of a counter-clockwise element, in degrees, [0, 360). A concave corner
/// counts over 180.
#[inline]
pub fn min_max<const K: usize>(p: &[Point2; K]) -> (f64, f64) {
    let mut out = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..K {
        let a = turn(p[(k + 1) % K] - p[k], p[(k + K - 1) % K] - p[k]).to_degrees();
        out = (out.0.min(a), out.1.max(a));
    }
    out
}
