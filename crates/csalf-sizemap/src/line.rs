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

/// Where they differ by more than this factor, cells are halved until the sizes in each are nearly linear: in equal
/// cells the first segment beside a fine spot would come out many times too long.
const HALVE_FROM: f64 = 6.0;
/// Cells are halved while that changes W by more than this, in segments. Larger: faster, nodes less exact.
const HALVE_ERROR: f64 = 0.05;
/// Rates nearer to each other than this share are averaged: the logarithm would lose digits, the mean is off by a
/// twelfth of the share's square.
const NO_LOGARITHM: f64 = 1e-4;
/// Smallest cell: 2⁻²⁴ of the line.
const HALVINGS: u32 = 24;

/// The integral of 1/h along a line, sampled: answers how many segments the line wants and where they end.
#[derive(Clone, Debug)]
pub struct LineSizes {
    /// W at the ends of the cells; `w[0]` = 0.
    w: [f64; MAX_SAMPLES + 1],
    /// The line's parameter there, if the cells are not of equal length.
    t: Option<Box<[f64; MAX_SAMPLES + 1]>>,
    samples: usize,
}

impl LineSizes {
    /// Samples 1/h on the segment from `a` to `b`. Cost: none for a constant field, 3 size queries for a short line
    /// along which h hardly varies, else 3 and about one per wanted segment (4 to 64), twice to thrice as many where
    /// sizes differ by more than 2, at most 128 more where they differ by more than 6.
    pub fn new(a: Point2, b: Point2, field: &dyn SizeField, hint: &mut Hint) -> Self {
        let l = a.distance(b);
        let mut out = Self { w: [0.0; MAX_SAMPLES + 1], t: None, samples: 1 };
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
        let ends = spread;
        let spread = out.integrate(if fine { 2 * first } else { first }, l, &mut rate);
        if spread.max(ends) > HALVE_FROM {
            out.halve(l, &mut rate);
        } else if !fine && spread > FINE_FROM {
            out.integrate(2 * first, l, &mut rate);
        }
        out
    }

    /// As [`Self::integrate`], in cells that are halved until h is nearly linear in each. At least 8 cells, from left
    /// to right; when there are as many as fit, the rest stay as they are.
    fn halve(&mut self, l: f64, rate: &mut impl FnMut(f64) -> f64) {
        // ∫ ds/h where h is linear between its ends, per unit of length.
        let mean = |r0: f64, r1: f64| {
            let k = r0 / r1;
            if (k - 1.0).abs() < NO_LOGARITHM { 0.5 * (r0 + r1) } else { r0 * k.ln() / (k - 1.0) }
        };
        let mut ends = Box::new([0.0; MAX_SAMPLES + 1]);
        let mut m = 0;
        // Right ends of the cells that wait, the next one last: parameter, rate there, halvings left.
        let mut waiting: Vec<(f64, f64, u32)> =
            (1..=8).rev().map(|i| (0.125 * f64::from(i), rate(0.125 * f64::from(i)), HALVINGS - 3)).collect();
        let (mut t0, mut r0) = (0.0, rate(0.0));
        while let Some((t1, r1, left)) = waiting.pop() {
            let whole = l * (t1 - t0) * mean(r0, r1);
            if left > 0 && m + waiting.len() + 2 <= MAX_SAMPLES {
                let tm = 0.5 * (t0 + t1);
                let rm = rate(tm);
                let halves = 0.5 * l * (t1 - t0) * (mean(r0, rm) + mean(rm, r1));
                // Nodes lie evenly in a cell: off by W ln(r1 / r0) / 8 segments in its middle.
                let uneven = whole.max(halves) * (r1 / r0).ln().abs() > 12.0 * HALVE_ERROR;
                if uneven || (whole - halves).abs() > HALVE_ERROR {
                    waiting.push((t1, r1, left - 1));
                    waiting.push((tm, rm, left - 1));
                    continue;
                }
            }
            self.w[m + 1] = self.w[m] + whole;
            ends[m + 1] = t1;
            m += 1;
            (t0, r0) = (t1, r1);
        }
        self.t = Some(ends);
        self.samples = m;
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
        match &self.t {
            Some(t) => t[k] + f * (t[k + 1] - t[k]),
            None => (k as f64 + f) / m as f64,
        }
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

    /// From the tip of an aerofoil into its far field: sizes grow ten thousandfold. Equal cells placed the first
    /// node fifteen times too far away.
    #[test]
    fn a_fine_spot_at_one_end() {
        let (l, h0, slope) = (15.0, 8e-4, 0.5);
        for far_end in [false, true] {
            let f = Steep(
                if far_end { h0 + slope * l } else { h0 },
                if far_end { -slope } else { slope },
                0.into(),
            );
            let s = LineSizes::new(Point2::ZERO, Point2::new(l, 0.0), &f, &mut Hint::default());
            let wanted = (slope * l / h0).ln_1p() / slope;
            assert!((s.wanted_segments() - wanted).abs() < 0.3, "{} against {wanted}", s.wanted_segments());
            let n = wanted.round() as usize;
            for i in 1..n {
                let at = |i: usize| h0 / slope * ((slope * wanted * i as f64 / n as f64).exp() - 1.0);
                let x =
                    if far_end { l * (1.0 - s.parameter(n - i, n - 1)) } else { l * s.parameter(i, n - 1) };
                let miss = (x - at(i)).abs() / (at(i + 1) - at(i));
                assert!(miss < 0.15, "node {i} of {n}: {x} against {}", at(i));
            }
            assert!(f.2.into_inner() < 400);
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
