//! Aspect ratio: longest side against area.

use super::{Card, Corners};
use csalf_geom::Point2;

/// Metric card.
pub const CARD: Card = Card {
    name: "aspect ratio",
    dimension: "1",
    acceptable: (1.0, 1.3),
    normal: (1.0, f64::MAX),
    full: (1.0, f64::MAX),
    unit_square: 1.0,
    source: "Verdict 2007, quad aspect ratio",
};

/// Lmax (L0 + L1 + L2 + L3) / (4 area), 1 to infinity, ideal 1; infinite if the area is not positive.
#[inline]
pub fn value(p: &[Point2; 4]) -> f64 {
    of_corners(&Corners::new(p))
}

/// [`value`] from corner data; of a triangle Lmax (sum of L) / (4 sqrt(3) area), 1 of the equilateral one.
#[inline]
pub fn of_corners<const K: usize>(c: &Corners<K>) -> f64 {
    let longest = c.length.iter().copied().fold(0.0, f64::max);
    let sum: f64 = c.length.iter().sum();
    let scale = if K == 3 { 4.0 * 3f64.sqrt() } else { 4.0 };
    if c.area > 0.0 { longest * sum / (scale * c.area) } else { f64::INFINITY }
}
