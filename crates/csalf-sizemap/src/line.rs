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

/// Most cells that a line is divided into.
pub const MAX_SAMPLES: usize = 128;
/// Most cells of a first division. A line of many more segments than this is placed by cells of several segments.
const FIRST_SAMPLES: usize = 64;
/// Where the sizes of a sampled line differ by more than this factor, it is sampled twice as finely (handbook 1.8).
const FINE_FROM: f64 = 2.0;
/// Where the sizes at both ends and the middle of a short line agree within this factor, the parabola through 1/h
/// there is integrated, and no more samples are taken. Larger: faster; 1.1 keeps errors of N* below 1e-3.
const SMOOTH_TO: f64 = 1.1;
/// Lines of at most this many segments may take that way; in longer ones a spot may hide between the samples.
const SHORT: f64 = 8.0;

/// The integral of 1/h along a line, sampled: answers how many segments the line wants and where they end.
#[derive(Clone, Debug)]
pub struct LineSizes {
    /// W at the samples, which are equally spaced in the line's parameter; `w[0]` = 0.
    w: [f64; MAX_SAMPLES + 1],
    samples: usize,
}

impl LineSizes {
    /// Samples 1/h on the segment from `a` to `b`. Cost: none for a constant field, 3 size queries for a short line
    /// along which h hardly varies, else 3 and about one per wanted segment (4 to 64), twice to thrice as many where
    /// sizes differ by more than 2.
    pub fn new(a: Point2, b: Point2, field: &dyn SizeField, hint: &mut Hint) -> Self {
        let l = a.distance(b);
        let mut out = Self { w: [0.0; MAX_SAMPLES + 1], samples: 1 };
        if let Some(h) = field.constant() {
            out.w[1] = l / h;
            return out;
        }
        let mut rate = |t: f64| 1.0 / field.h(a.lerp(b, t), hint);
        let [r0, rm, r1] = [0.0, 0.5, 1.0].map(&mut rate);
        let estimate = l * (r0 + 4.0 * rm + r1) / 6.0;
        let spread = r0.max(rm).max(r1) / r0.min(rm).min(r1);
        if spread <= SMOOTH_TO && estimate <= SHORT {
            out.samples = 4;
            for i in 1..=4 {
                let t = 0.25 * i as f64;
                let (slope, bend) = (4.0 * rm - 3.0 * r0 - r1, 2.0 * (r0 - 2.0 * rm + r1));
                out.w[i] = l * t * (r0 + t * (slope / 2.0 + t * bend / 3.0));
            }
            return out;
        }
        let first = ((estimate / 4.0).ceil() * 4.0).clamp(4.0, FIRST_SAMPLES as f64) as usize;
        // Of a line without length or with NaN in it the cast gives 0.
        let first = first.max(4);
        let fine = spread > FINE_FROM;
        let spread = out.integrate(if fine { 2 * first } else { first }, l, &mut rate);
        if !fine && spread > FINE_FROM {
            out.integrate(2 * first, l, &mut rate);
        }
        out
    }

    /// Midpoint rule in `m` cells; returns the largest ratio of two samples.
    fn integrate(&mut self, m: usize, l: f64, rate: &mut impl FnMut(f64) -> f64) -> f64 {
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        for i in 0..m {
            let r = rate((i as f64 + 0.5) / m as f64);
            (least, most) = (least.min(r), most.max(r));
            self.w[i + 1] = self.w[i] + l / m as f64 * r;
        }
        self.samples = m;
        most / least
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

    /// h = h0 + slope * x, and how often it was asked.
    #[derive(Debug)]
    struct Steep(f64, f64, std::sync::atomic::AtomicUsize);
    impl SizeField for Steep {
        fn h(&self, p: Point2, _: &mut Hint) -> f64 {
            self.2.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            self.0 + self.1 * p.x
        }
        fn range(&self) -> (f64, f64) {
            (self.0, f64::MAX)
        }
    }

    /// N* and all nodes of linear fields of ratio 1 to 100 against the closed form.
    #[test]
    fn linear_fields_of_any_ratio() {
        for ratio in [1.0001, 1.05, 1.5, 3.0, 10.0, 100.0] {
            for wanted in [2.5f64, 7.3, 30.0, 90.0] {
                let (l, h0) = (10.0, 10.0 * f64::ln(ratio) / ((ratio - 1.0) * wanted));
                let f = Steep(h0, h0 * (ratio - 1.0) / l, 0.into());
                let s = LineSizes::new(Point2::ZERO, Point2::new(l, 0.0), &f, &mut Hint::default());
                let n = wanted.round() as usize;
                let error = (s.wanted_segments() / wanted).ln().abs();
                assert!(error < if ratio > 10.0 { 0.1 } else { 0.02 }, "N* {ratio} {wanted}: {error}");
                let at = |i: usize| l * (ratio.powf(i as f64 / n as f64) - 1.0) / (ratio - 1.0);
                for i in 1..n {
                    let miss = (l * s.parameter(i, n - 1) - at(i)).abs() / (at(i + 1) - at(i - 1));
                    let most = if ratio > 10.0 { 0.8 } else { 0.08 };
                    assert!(miss < most, "node {i} of {n}, ratio {ratio}, {wanted}: {miss}");
                }
            }
        }
    }

    #[test]
    fn short_smooth_lines_cost_three_queries() {
        let f = Steep(1.0, 0.01, 0.into());
        let s = LineSizes::new(Point2::ZERO, Point2::new(4.0, 0.0), &f, &mut Hint::default());
        assert_eq!(f.2.into_inner(), 3);
        assert!((s.wanted_segments() - 100.0 * 1.04f64.ln()).abs() < 1e-5);
    }

    #[test]
    fn lines_without_length_and_with_nan_do_not_panic() {
        for b in [Point2::ZERO, Point2::NAN, Point2::INFINITY] {
            let s = LineSizes::new(Point2::ZERO, b, &Ramp, &mut Hint::default());
            let _ = (s.wanted_segments(), s.parameter(1, 3));
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
