//! A linear stand-in for the size field around one cavity: a few samples in place of thousands of queries.
//!
//! ```text
//!   h(p) ≈ a + b.(p - c), least squares over samples, kept within the samples' range
//! ```
//!
//! Only forecasts and smoothing ask it; patches are judged by the field itself.

use csalf_geom::Point2;
use csalf_sizemap::{Hint, SizeField};

/// Samples whose covariance has a smaller determinant than this part of its squared trace count as lying on a line.
/// *Arbitrary.*
const ON_A_LINE: f64 = 1e-6;

#[derive(Debug)]
pub(super) struct LinearSize {
    centre: Point2,
    mean: f64,
    slope: Point2,
    range: (f64, f64),
    constant: Option<f64>,
}

impl LinearSize {
    /// Fitted to the field at these points, of which there must be one.
    pub(super) fn new(size: &dyn SizeField, points: &[Point2]) -> Self {
        let n = points.len().max(1) as f64;
        let centre = points.iter().copied().sum::<Point2>() / n;
        let mut hint = Hint::default();
        let h: Vec<f64> = points.iter().map(|&p| size.h(p, &mut hint)).collect();
        let mean = h.iter().sum::<f64>() / n;
        let (mut xx, mut xy, mut yy, mut r) = (0.0, 0.0, 0.0, Point2::ZERO);
        for (&p, &h) in points.iter().zip(&h) {
            let d = p - centre;
            (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
            r += (h - mean) * d;
        }
        let det = xx * yy - xy * xy;
        // All on a line: the mean will do.
        let slope = if det > ON_A_LINE * (xx + yy) * (xx + yy) {
            Point2::new(yy * r.x - xy * r.y, xx * r.y - xy * r.x) / det
        } else {
            Point2::ZERO
        };
        let range = h.iter().fold((f64::INFINITY, 0.0), |(a, b), &h| (f64::min(a, h), f64::max(b, h)));
        let range = if h.is_empty() { size.range() } else { range };
        Self { centre, mean, slope, range, constant: size.constant() }
    }
}

impl SizeField for LinearSize {
    fn h(&self, p: Point2, _: &mut Hint) -> f64 {
        (self.mean + self.slope.dot(p - self.centre)).clamp(self.range.0, self.range.1)
    }
    fn constant(&self) -> Option<f64> {
        self.constant
    }
    fn range(&self) -> (f64, f64) {
        self.range
    }
}
