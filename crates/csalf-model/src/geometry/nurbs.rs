//! Rational B-splines: values and derivatives up to the second, by de Boor's basis functions.
//!
//! ```text
//!   C(t)    = Σ N_i(t) w_i P_i / Σ N_i(t) w_i          Piegl and Tiller, The NURBS Book, A2.3, A4.2, A4.4
//!   S(u, v) = Σ Σ N_i(u) M_j(v) w_ij P_ij / Σ Σ ...
//! ```
//!
//! 1. find the knot span; 2. the basis functions and their derivatives; 3. sums in homogeneous coordinates;
//! 4. the quotient rule.

use super::{CurvePoint, SurfacePoint};
use glam::{DVec2, DVec3, DVec4};

/// Largest degree that is read: every CAD system stays below.
pub const MAX_DEGREE: usize = 25;

/// Basis functions of most surfaces and curves: up to degree 7 they are computed in arrays of this length, which cost a
/// third of those that any degree needs.
const FEW: usize = 8;
/// Basis functions of the largest degree.
const MANY: usize = MAX_DEGREE + 1;

/// A knot vector of one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Knots {
    degree: usize,
    knots: Vec<f64>,
}

impl Knots {
    /// Knots for `n` control points; `None` if the numbers do not fit together, a knot is not finite or the knots
    /// descend.
    pub fn new(degree: usize, knots: Vec<f64>, n: usize) -> Option<Self> {
        let counts = (1..=MAX_DEGREE).contains(&degree) && n > degree && knots.len() == n + degree + 1;
        let ascend = knots.iter().all(|k| k.is_finite()) && knots.windows(2).all(|w| w[0] <= w[1]);
        (counts && ascend && knots[degree] < knots[n]).then_some(Self { degree, knots })
    }

    /// Number of control points.
    pub fn n(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// The range of the parameter.
    pub fn range(&self) -> [f64; 2] {
        [self.knots[self.degree], self.knots[self.n()]]
    }

    /// The distinct knots within the range, ascending.
    pub fn breaks(&self) -> Vec<f64> {
        let mut b = self.knots[self.degree..=self.n()].to_vec();
        b.dedup();
        b
    }

    /// The span that holds `t`: the last i with knot i <= t, within the range.
    fn span(&self, t: f64) -> usize {
        let n = self.n();
        let inner = &self.knots[self.degree + 1..n];
        let mut i = self.degree + inner.partition_point(|&k| k <= t);
        // The range's end belongs to the last span that is not empty.
        while i > self.degree && self.knots[i] >= self.knots[i + 1] {
            i -= 1;
        }
        i
    }

    /// The basis functions that are not zero at `t` (within the range): which, and their values.
    pub(super) fn values(&self, t: f64) -> impl Iterator<Item = (usize, f64)> + '_ {
        let span = self.span(t);
        let [values, ..] = self.basis::<MANY>(span, t);
        (0..=self.degree).map(move |j| (span + j - self.degree, values[j]))
    }

    /// Basis functions of the span at `t` and their first two derivatives: `[order][0..=degree]`. N is larger than the
    /// degree.
    fn basis<const N: usize>(&self, span: usize, t: f64) -> [[f64; N]; 3] {
        let p = self.degree;
        let mut low = [[0.0; N]; 3];
        // Values of degree p, p-1, p-2 (as many as there are), each from the one below (Cox and de Boor).
        let mut n = [0.0; N];
        n[0] = 1.0;
        for d in 0..=p {
            if d > 0 {
                n = self.raise(&n, span, d, t);
            }
            if d == p {
                low[0] = n;
            } else if d + 1 == p {
                low[1] = n;
            } else if d + 2 == p {
                low[2] = n;
            }
        }
        let values = low[0];
        let first = self.differentiate(&low[1], span, p);
        let second = if p >= 2 {
            let d = self.differentiate(&low[2], span, p - 1);
            self.differentiate(&d, span, p)
        } else {
            [0.0; N]
        };
        [values, first, second]
    }

    /// Basis of degree `d` from that of degree `d - 1`; entry j belongs to control point `span - d + j`.
    fn raise<const N: usize>(&self, n: &[f64; N], span: usize, d: usize, t: f64) -> [f64; N] {
        let mut out = [0.0; N];
        for (j, &value) in n.iter().enumerate().take(d) {
            let (a, b) = (self.knots[span + 1 + j - d], self.knots[span + 1 + j]);
            let share = if b > a { value / (b - a) } else { 0.0 };
            out[j] += (b - t) * share;
            out[j + 1] += (t - a) * share;
        }
        out
    }

    /// Derivative of the basis of degree `d`, given the basis (or its derivative) of degree `d - 1`.
    fn differentiate<const N: usize>(&self, n: &[f64; N], span: usize, d: usize) -> [f64; N] {
        let mut out = [0.0; N];
        for (j, &value) in n.iter().enumerate().take(d) {
            let (a, b) = (self.knots[span + 1 + j - d], self.knots[span + 1 + j]);
            let share = if b > a { d as f64 * value / (b - a) } else { 0.0 };
            out[j] -= share;
            out[j + 1] += share;
        }
        out
    }
}

/// Quotient rule: the point and derivatives of `a / w` from homogeneous sums.
fn project(p: DVec4, d1: DVec4, d2: DVec4) -> CurvePoint {
    let point = p.truncate() / p.w;
    let first = (d1.truncate() - point * d1.w) / p.w;
    let second = (d2.truncate() - first * (2.0 * d1.w) - point * d2.w) / p.w;
    CurvePoint { point, d1: first, d2: second }
}

/// A rational B-spline curve.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsCurve {
    /// Knots.
    pub knots: Knots,
    /// Control points times their weights, and the weights.
    pub points: Vec<DVec4>,
}

impl NurbsCurve {
    /// A curve; `None` if counts do not match, or a number is not finite, or a weight is not positive.
    pub fn new(degree: usize, knots: Vec<f64>, points: &[DVec3], weights: &[f64]) -> Option<Self> {
        let knots = Knots::new(degree, knots, points.len())?;
        let fine = weights.len() == points.len()
            && points.iter().all(|p| p.is_finite())
            && weights.iter().all(|w| w.is_finite() && *w > 0.0);
        let points = points.iter().zip(weights).map(|(p, &w)| (*p * w).extend(w)).collect();
        fine.then_some(Self { knots, points })
    }

    /// Point and derivatives at `t`, which is clamped to the range.
    pub fn eval(&self, t: f64) -> CurvePoint {
        let [t0, t1] = self.knots.range();
        let t = t.clamp(t0, t1);
        if self.knots.degree < FEW { self.eval_with::<FEW>(t) } else { self.eval_with::<MANY>(t) }
    }

    fn eval_with<const N: usize>(&self, t: f64) -> CurvePoint {
        let span = self.knots.span(t);
        let basis = self.knots.basis::<N>(span, t);
        let mut sums = [DVec4::ZERO; 3];
        for j in 0..=self.knots.degree {
            let p = self.points[span + j - self.knots.degree];
            for (sum, b) in sums.iter_mut().zip(&basis) {
                *sum += p * b[j];
            }
        }
        project(sums[0], sums[1], sums[2])
    }

    /// The curve with every control point moved.
    pub fn mapped(&self, f: impl Fn(DVec3) -> DVec3) -> Self {
        let points = self.points.iter().map(|p| (f(p.truncate() / p.w) * p.w).extend(p.w)).collect();
        Self { knots: self.knots.clone(), points }
    }
}

/// A rational B-spline surface.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsSurface {
    /// Knots along u and along v.
    pub knots: [Knots; 2],
    /// Control points times their weights, and the weights; `points[i * n_v + j]`.
    pub points: Vec<DVec4>,
    /// The parameter's period where the surface closes smoothly or not, u and v.
    pub periods: [Option<f64>; 2],
}

impl NurbsSurface {
    /// A surface of `n_u * n_v` control points, v running fastest; `None` as for curves.
    pub fn new(degrees: [usize; 2], knots: [Vec<f64>; 2], points: &[DVec3], weights: &[f64]) -> Option<Self> {
        let [ku, kv] = knots;
        let n_u = ku.len().checked_sub(degrees[0] + 1)?;
        let n_v = kv.len().checked_sub(degrees[1] + 1)?;
        let fine = n_u.checked_mul(n_v)? == points.len()
            && weights.len() == points.len()
            && points.iter().all(|p| p.is_finite())
            && weights.iter().all(|w| w.is_finite() && *w > 0.0);
        if !fine {
            return None;
        }
        let knots = [Knots::new(degrees[0], ku, n_u)?, Knots::new(degrees[1], kv, n_v)?];
        let (lo, hi) = points.iter().fold((points[0], points[0]), |(a, b), p| (a.min(*p), b.max(*p)));
        // Two rims closer than this share of the surface's size are one rim; files carry six to eight digits.
        const CLOSED: f64 = 1e-6;
        let near = |a: usize, b: usize| points[a].distance(points[b]) <= CLOSED * lo.distance(hi);
        let closed_u = (0..n_v).all(|j| near(j, (n_u - 1) * n_v + j));
        let closed_v = (0..n_u).all(|i| near(i * n_v, i * n_v + n_v - 1));
        // A direction that is one point throughout is no closed direction.
        let wide_u = (0..n_v).any(|j| (1..n_u).any(|i| !near(j, i * n_v + j)));
        let wide_v = (0..n_u).any(|i| (1..n_v).any(|j| !near(i * n_v, i * n_v + j)));
        let length = |k: &Knots| k.range()[1] - k.range()[0];
        let periods = [
            (closed_u && wide_u).then(|| length(&knots[0])),
            (closed_v && wide_v).then(|| length(&knots[1])),
        ];
        let points = points.iter().zip(weights).map(|(p, &w)| (*p * w).extend(w)).collect();
        Some(Self { knots, points, periods })
    }

    /// The parameters within the range: wrapped in closed directions, clamped in open ones.
    pub fn wrap(&self, uv: DVec2) -> DVec2 {
        let one = |t: f64, k: usize| {
            let [t0, t1] = self.knots[k].range();
            match self.periods[k] {
                Some(period) if t < t0 || t > t1 => (t0 + (t - t0).rem_euclid(period)).clamp(t0, t1),
                _ => t.clamp(t0, t1),
            }
        };
        DVec2::new(one(uv.x, 0), one(uv.y, 1))
    }

    /// Point and derivatives at `uv`, wrapped or clamped to the range. Cost O(degree²).
    pub fn eval(&self, uv: DVec2) -> SurfacePoint {
        let uv = self.wrap(uv);
        let [ku, kv] = &self.knots;
        if ku.degree.max(kv.degree) < FEW { self.eval_with::<FEW>(uv) } else { self.eval_with::<MANY>(uv) }
    }

    fn eval_with<const N: usize>(&self, uv: DVec2) -> SurfacePoint {
        let [ku, kv] = &self.knots;
        let (su, sv) = (ku.span(uv.x), kv.span(uv.y));
        let (bu, bv) = (ku.basis::<N>(su, uv.x), kv.basis::<N>(sv, uv.y));
        let n_v = kv.n();
        // [order in u][order in v]
        let mut s = [[DVec4::ZERO; 3]; 3];
        let order = ku.degree + 1;
        for i in 0..order {
            let row = (su + i - ku.degree) * n_v + sv - kv.degree;
            let mut along = [DVec4::ZERO; 3];
            for (j, p) in self.points[row..=row + kv.degree].iter().enumerate() {
                for (sum, b) in along.iter_mut().zip(&bv) {
                    *sum += *p * b[j];
                }
            }
            for (row, b) in s.iter_mut().zip(&bu) {
                for (sum, a) in row.iter_mut().zip(along) {
                    *sum += a * b[i];
                }
            }
        }
        let u = project(s[0][0], s[1][0], s[2][0]);
        let v = project(s[0][0], s[0][1], s[0][2]);
        let w = s[0][0].w;
        let duv = (s[1][1].truncate() - u.d1 * s[0][1].w - v.d1 * s[1][0].w - u.point * s[1][1].w) / w;
        SurfacePoint { point: u.point, du: u.d1, dv: v.d1, duu: u.d2, duv, dvv: v.d2 }
    }

    /// Whether the rims at the low and at the high end of v are single points.
    pub fn poles(&self) -> [bool; 2] {
        let (n_u, n_v) = (self.knots[0].n(), self.knots[1].n());
        let at = |i: usize, j: usize| {
            let p = self.points[i * n_v + j];
            p.truncate() / p.w
        };
        let size = (0..n_u * n_v).map(|k| at(0, 0).distance(at(k / n_v, k % n_v))).fold(0.0, f64::max);
        // A rim shorter than this share of the surface is a point; files carry six to eight digits.
        const POINT: f64 = 1e-6;
        [0, n_v - 1].map(|j| (1..n_u).all(|i| at(i, j).distance(at(0, j)) <= POINT * size))
    }

    /// The same surface with u and v exchanged; its normal is turned over.
    pub fn transposed(&self) -> Self {
        let (n_u, n_v) = (self.knots[0].n(), self.knots[1].n());
        let points = (0..n_u * n_v).map(|k| self.points[(k % n_u) * n_v + k / n_u]).collect();
        let [ku, kv] = self.knots.clone();
        Self { knots: [kv, ku], points, periods: [self.periods[1], self.periods[0]] }
    }

    /// The surface with every control point moved.
    pub fn mapped(&self, f: impl Fn(DVec3) -> DVec3) -> Self {
        let points = self.points.iter().map(|p| (f(p.truncate() / p.w) * p.w).extend(p.w)).collect();
        Self { knots: self.knots.clone(), points, periods: self.periods }
    }
}
