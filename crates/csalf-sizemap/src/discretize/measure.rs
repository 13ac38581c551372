//! Lengths in units of h along curves: W(t) = ∫ |c'| dt / h, by adaptive Gauss quadrature, and its inverse.

use super::{CurvatureLimit, DiscretizeOptions, MAX_SEGMENTS};
use crate::{Hint, SizeField};
use csalf_geom::curve::{Curve, CurvePoint};
use csalf_geom::{Edge, Point2};

/// Abscissas and weights of Gauss's rule with three points on [0, 1].
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
/// Relative change of the integral at which a cell is not halved any more. Larger: spacing off by more; smaller: more
/// queries at the bends of piecewise linear fields. *Arbitrary*, far below the rounding of a count.
const CONVERGED: f64 = 1e-6;
/// Most times a cell is halved; for jumps of the field.
const MAX_DEPTH: u32 = 16;
/// Most cells that a span is cut into at first, so that small spots of a field are seen.
const MAX_FIRST_CELLS: f64 = 256.0;

/// A smooth part of one curve, from parameter t0 to t1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub(super) edge: usize,
    pub(super) t0: f64,
    pub(super) t1: f64,
}

/// A part of a span in which 1/h is close to a polynomial, with W at its ends.
#[derive(Clone, Copy, Debug)]
struct Cell {
    span: Span,
    w0: f64,
    w1: f64,
}

/// W along one piece.
#[derive(Debug)]
pub(super) struct Measure {
    cells: Vec<Cell>,
    /// Sum of all turns of its curves other than polylines, radians.
    pub(super) turning: f64,
}

/// Wanted length at a point of a curve.
fn wanted_length(
    q: &CurvePoint,
    field: &dyn SizeField,
    limit: Option<CurvatureLimit>,
    hint: &mut Hint,
) -> f64 {
    let h = field.h(q.point, hint);
    limit.map_or(h, |l| {
        let r = q.radius();
        let by_turn = if r.is_finite() { 2.0 * r * (0.5 * l.angle).sin() } else { f64::INFINITY };
        h.min(by_turn.min((8.0 * l.chord * r).sqrt()).max(l.floor))
    })
}

/// ∫ |c'| dt / h over a part of a span, by Gauss's rule.
fn integral(
    curve: &Curve,
    t0: f64,
    t1: f64,
    field: &dyn SizeField,
    options: &DiscretizeOptions,
    hint: &mut Hint,
) -> f64 {
    let rate = |&(x, w): &(f64, f64)| {
        let q = curve.eval(t0 + x * (t1 - t0));
        w * q.d1.length() / wanted_length(&q, field, options.curvature, hint)
    };
    (t1 - t0) * GAUSS.iter().map(rate).sum::<f64>()
}

impl Measure {
    /// Measures a piece. The error is a place where the field is not positive or asks for far too many nodes.
    pub(super) fn new(
        edges: &[Edge],
        spans: &[Span],
        field: &dyn SizeField,
        options: &DiscretizeOptions,
    ) -> Result<Self, Point2> {
        let mut out = Self { cells: Vec::new(), turning: 0.0 };
        let mut hint = Hint::default();
        let finest = options.curvature.map_or(field.range().0, |l| field.range().0.min(l.floor));
        for span in spans {
            let curve = &edges[span.edge].curve;
            let at = |f: f64| span.t0 + f * (span.t1 - span.t0);
            let points: [Point2; 9] = std::array::from_fn(|i| curve.eval(at(i as f64 / 8.0)).point);
            let length: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
            let straight = matches!(curve, Curve::Polyline(_));
            let fewest = if straight { 1.0 } else { 8.0 };
            let cells = if field.constant().is_some() { 1.0 } else { length / (4.0 * finest) };
            let m = cells.ceil().clamp(fewest, MAX_FIRST_CELLS) as usize;
            let from = out.cells.len();
            for i in 0..m {
                let (t0, t1) = (at(i as f64 / m as f64), at((i + 1) as f64 / m as f64));
                let whole = integral(curve, t0, t1, field, options, &mut hint);
                let cell = Span { edge: span.edge, t0, t1: if i + 1 == m { span.t1 } else { t1 } };
                out.add(curve, cell, whole, MAX_DEPTH, field, options, &mut hint)?;
            }
            if !straight {
                let ways = out.cells[from..].iter().map(|c| curve.eval(0.5 * (c.span.t0 + c.span.t1)).d1);
                let first = curve.direction(span.t0, span.t1);
                let last = -curve.direction(span.t1, span.t0);
                let mut before = first;
                for d in ways.filter(|d| *d != Point2::ZERO).chain([last]) {
                    out.turning += before.perp_dot(d).atan2(before.dot(d)).abs();
                    before = d;
                }
            }
        }
        let total = out.wanted();
        if total > 0.0 && total < MAX_SEGMENTS {
            return Ok(out);
        }
        Err(spans.first().map_or(Point2::ZERO, |s| edges[s.edge].curve.eval(s.t0).point))
    }

    /// Adds a cell, halved as long as that changes its integral.
    #[allow(clippy::too_many_arguments, reason = "a recursion that passes its context on")]
    fn add(
        &mut self,
        curve: &Curve,
        span: Span,
        whole: f64,
        depth: u32,
        field: &dyn SizeField,
        options: &DiscretizeOptions,
        hint: &mut Hint,
    ) -> Result<(), Point2> {
        let middle = 0.5 * (span.t0 + span.t1);
        let left = integral(curve, span.t0, middle, field, options, hint);
        let right = integral(curve, middle, span.t1, field, options, hint);
        let both = left + right;
        if !(both.is_finite() && both >= 0.0) {
            return Err(curve.eval(middle).point);
        }
        if depth == 0 || (both - whole).abs() <= CONVERGED * both.max(CONVERGED) {
            let w0 = self.wanted();
            self.cells.push(Cell { span, w0, w1: w0 + both });
            return Ok(());
        }
        let (a, b) = (Span { t1: middle, ..span }, Span { t0: middle, ..span });
        self.add(curve, a, left, depth - 1, field, options, hint)?;
        self.add(curve, b, right, depth - 1, field, options, hint)
    }

    /// N*: how many segments of the wanted length fit on the piece.
    pub(super) fn wanted(&self) -> f64 {
        self.cells.last().map_or(0.0, |c| c.w1)
    }

    /// Appends the first node of the piece and the n - 1 inner ones, at equal steps of W.
    pub(super) fn place(
        &self,
        edges: &[Edge],
        n: usize,
        field: &dyn SizeField,
        options: &DiscretizeOptions,
        hint: &mut Hint,
        out: &mut Vec<Point2>,
    ) {
        let Some(first) = self.cells.first() else { return };
        out.push(edges[first.span.edge].curve.eval(first.span.t0).point);
        for i in 1..n {
            let target = self.wanted() * i as f64 / n as f64;
            let k = self.cells.partition_point(|c| c.w1 < target).min(self.cells.len() - 1);
            let Cell { span, w0, w1 } = self.cells[k];
            let curve = &edges[span.edge].curve;
            // Newton on W(t) = target within the cell, from the linear guess, kept in brackets.
            let (mut lo, mut hi) = (span.t0, span.t1);
            let share = if w1 > w0 { (target - w0) / (w1 - w0) } else { 0.5 };
            let mut t = lo + share * (hi - lo);
            for _ in 0..20 {
                let excess = w0 + integral(curve, span.t0, t, field, options, hint) - target;
                if excess > 0.0 {
                    hi = t;
                } else {
                    lo = t;
                }
                let q = curve.eval(t);
                let rate = q.d1.length() / wanted_length(&q, field, options.curvature, hint);
                let step = t - excess / rate;
                let next = if step >= lo && step <= hi { step } else { 0.5 * (lo + hi) };
                let moved = (next - t).abs();
                t = next;
                // The last digits do not matter: the point is on the curve whatever t is.
                if moved <= 4.0 * f64::EPSILON * span.t1.abs().max(span.t0.abs()) || excess == 0.0 {
                    break;
                }
            }
            out.push(curve.eval(t).point);
        }
    }
}

/// Parameter of the point of `curve` nearest to `p`, as far as 8 samples per span tell it apart.
pub(super) fn nearest(curve: &Curve, p: Point2) -> f64 {
    let (t0, t1) = curve.range();
    let mut ends = curve.breaks();
    ends.insert(0, t0);
    ends.push(t1);
    let mut best = (f64::INFINITY, t0, t0, t1);
    for w in ends.windows(2) {
        const SAMPLES: u32 = 8;
        let step = (w[1] - w[0]) / f64::from(SAMPLES);
        for i in 0..=SAMPLES {
            let t = w[0] + step * f64::from(i);
            let d = curve.eval(t).point.distance(p);
            if d < best.0 {
                best = (d, t, (t - step).max(w[0]), (t + step).min(w[1]));
            }
        }
    }
    // Newton on (c - p) · c' = 0 in the bracket around the best sample.
    let (_, mut t, lo, hi) = best;
    for _ in 0..20 {
        let q = curve.eval(t);
        let r = q.point - p;
        let slope = q.d1.length_squared() + r.dot(q.d2);
        if slope > 0.0 {
            t = (t - r.dot(q.d1) / slope).clamp(lo, hi);
        }
    }
    t
}
