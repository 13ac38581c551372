//! Node counts and node positions on a straight line, by integration of 1/h.
//!
//! ```text
//!   W(s) = ∫ 0..s ds'/h          N* = W(l)            s_i = W⁻¹( i N* / (n+1) ),  i = 1..n
//! ```
//!
//! Source: handbook 1.8 and 1.9, in place of the paper's missing eqs. 10-13 and its eqs. 14-17 (whose signs are
//! wrong, and which leave the rounding remainder in the last segment; equidistribution spreads it evenly).

use crate::{Hint, SizeField};
use csalf_geom::Point2;

/// Most samples taken on one line.
pub const MAX_SAMPLES: usize = 64;

/// The integral of 1/h along a line, sampled: answers how many segments the line wants and where they end.
#[derive(Clone, Debug)]
pub struct LineSizes {
    /// W at the samples, which are equally spaced in the line's parameter; `w[0]` = 0.
    w: [f64; MAX_SAMPLES + 1],
    samples: usize,
}

impl LineSizes {
    /// Samples 1/h on the segment from `a` to `b`. Takes 4 to 64 samples: about one per wanted segment.
    /// Cost: that many size queries; none for a constant field.
    pub fn new(a: Point2, b: Point2, field: &dyn SizeField, hint: &mut Hint) -> Self {
        let l = a.distance(b);
        let mut out = Self { w: [0.0; MAX_SAMPLES + 1], samples: 1 };
        if let Some(h) = field.constant() {
            out.w[1] = l / h;
            return out;
        }
        let mut rate = |t: f64| 1.0 / field.h(a.lerp(b, t), hint);
        let estimate = l * (rate(0.0) + 4.0 * rate(0.5) + rate(1.0)) / 6.0;
        let m = ((estimate / 4.0).ceil() * 4.0).clamp(4.0, MAX_SAMPLES as f64) as usize;
        // Midpoint rule per cell: each cell's 1/h at its middle.
        let ds = l / m as f64;
        for i in 0..m {
            let p = a.lerp(b, (i as f64 + 0.5) / m as f64);
            out.w[i + 1] = out.w[i] + ds / field.h(p, hint);
        }
        out.samples = m;
        out
    }

    /// N*: how many segments of the wanted length fit on the line (a real number).
    pub fn wanted_segments(&self) -> f64 {
        self.w[self.samples]
    }

    /// The parameter t in (0, 1) of the `i`-th of `n` inner nodes, `i` from 1: all segments measure the same in
    /// units of h.
    pub fn parameter(&self, i: usize, n: usize) -> f64 {
        let m = self.samples;
        let target = self.w[m] * i as f64 / (n + 1) as f64;
        let k = self.w[1..=m].partition_point(|&w| w < target).min(m - 1);
        let (w0, w1) = (self.w[k], self.w[k + 1]);
        let f = if w1 > w0 { (target - w0) / (w1 - w0) } else { 0.5 };
        (k as f64 + f) / m as f64
    }
}

/// Relative error of placing `segments` where `wanted` (N*) fit: |ln(segments / N*)| / ln 2, clipped to 1.
/// 0 is a perfect fit, 1 a factor of two. (Handbook 1.8, the symmetric form of the paper's ε.)
pub fn count_error(segments: usize, wanted: f64) -> f64 {
    ((segments as f64 / wanted).ln().abs() / std::f64::consts::LN_2).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Uniform;

    #[derive(Debug)]
    struct Ramp;
    impl SizeField for Ramp {
        fn h(&self, p: Point2, _: &mut Hint) -> f64 {
            1.0 + 0.1 * p.x
        }
        fn range(&self) -> (f64, f64) {
            (1.0, 2.0)
        }
    }

    /// Handbook A.8: l = 10, h = 1 + 0.1 s, seven segments.
    #[test]
    fn equidistribution_follows_the_field() {
        let s = LineSizes::new(Point2::ZERO, Point2::new(10.0, 0.0), &Ramp, &mut Hint::default());
        assert!((s.wanted_segments() - 10.0 * 2f64.ln()).abs() < 0.01);
        for (i, want) in [1.041, 2.190, 3.459, 4.860, 6.407, 8.114].into_iter().enumerate() {
            let x = 10.0 * s.parameter(i + 1, 6);
            assert!((x - want).abs() < 0.03, "node {i}: {x} against {want}");
        }
    }

    #[test]
    fn a_constant_field_spaces_evenly() {
        let s = LineSizes::new(Point2::ZERO, Point2::new(3.0, 4.0), &Uniform(0.5), &mut Hint::default());
        assert_eq!(s.wanted_segments(), 10.0);
        assert_eq!(s.parameter(1, 3), 0.25);
        assert_eq!(count_error(10, 10.0), 0.0);
        assert_eq!(count_error(5, 10.0), 1.0);
    }
}
