//! The cubic spline through given points, open (natural ends) or closed (periodic).
//!
//! Parameters are chord lengths. The unknown tangents m_i follow from equal second derivatives on both sides of
//! every inner point, with h_i the chord after point i and s_i the slope along it:
//!
//! ```text
//!   m_{i-1} / h_{i-1} + 2 m_i (1 / h_{i-1} + 1 / h_i) + m_{i+1} / h_i = 3 (s_{i-1} / h_{i-1} + s_i / h_i)
//! ```
//!
//! and from second derivatives of zero at the ends: 2 m_0 + m_1 = 3 s_0. A tridiagonal system; the two corners of
//! the periodic one are removed by the formula of Sherman and Morrison. Cost O(n).

use super::{CurvePoint, nurbs::CurveError};
use crate::Point2;

/// A twice continuously differentiable cubic through points.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// Chord length at each point.
    knots: Vec<f64>,
    /// The points; of a closed one, the first again at the end.
    points: Vec<Point2>,
    /// First derivative at each point.
    tangents: Vec<Point2>,
    closed: bool,
}

impl Spline {
    /// The spline through `points`. Closed: from the last point back to the first, which is not repeated.
    ///
    /// # Errors
    /// Fewer than two (closed: three) points, two successive equal ones, a number that is not finite.
    pub fn new(points: &[Point2], closed: bool) -> Result<Self, CurveError> {
        let needed = if closed { 3 } else { 2 };
        if points.len() < needed {
            return Err(CurveError::TooFewPoints { needed, found: points.len() });
        }
        if points.iter().any(|p| !p.is_finite()) {
            return Err(CurveError::NotFinite);
        }
        let mut p = points.to_vec();
        if closed {
            p.push(points[0]);
        }
        if let Some(i) = (1..p.len()).find(|&i| p[i] == p[i - 1]) {
            return Err(CurveError::RepeatedPoint { index: i });
        }
        let mut knots = vec![0.0];
        for w in p.windows(2) {
            knots.push(knots[knots.len() - 1] + w[0].distance(w[1]));
        }
        let tangents = if closed { periodic(&p, &knots) } else { natural(&p, &knots) };
        Ok(Self { knots, points: p, tangents, closed })
    }

    /// First and last parameter.
    pub fn range(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    /// The points that the spline was made of.
    pub fn points(&self) -> &[Point2] {
        &self.points[..self.points.len() - usize::from(self.closed)]
    }

    /// True if it leads from the last point back to the first.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Parameters of the points.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Point and derivatives at `t` in the range, by the cubic Hermite polynomials.
    pub fn eval(&self, t: f64) -> CurvePoint {
        let n = self.knots.len();
        let i = self.knots[1..n - 1].partition_point(|u| *u <= t);
        let h = self.knots[i + 1] - self.knots[i];
        let u = (t - self.knots[i]) / h;
        let (p, q) = (self.points[i], self.points[i + 1]);
        let (m, k) = (self.tangents[i] * h, self.tangents[i + 1] * h);
        if u >= 1.0 {
            return CurvePoint { point: q, d1: k / h, d2: ((p - q) * 6.0 + m * 2.0 + k * 4.0) / (h * h) };
        }
        // p + u m + u² (3 (q - p) - 2 m - k) + u³ (2 (p - q) + m + k), exact at the points.
        let (c2, c3) = ((q - p) * 3.0 - m * 2.0 - k, (p - q) * 2.0 + m + k);
        CurvePoint {
            point: p + (m + (c2 + c3 * u) * u) * u,
            d1: (m + (c2 * 2.0 + c3 * (3.0 * u)) * u) / h,
            d2: (c2 * 2.0 + c3 * (6.0 * u)) / (h * h),
        }
    }
}

/// Solves a system with diagonal `d`, sub- and superdiagonal `lower[i]` (row i, column i - 1) and `upper[i]`, in
/// place. It is diagonally dominant, so no pivots are needed.
fn tridiagonal(lower: &[f64], d: &[f64], upper: &[f64], b: &mut [Point2]) {
    let n = b.len();
    let mut c = vec![0.0; n];
    c[0] = upper[0] / d[0];
    b[0] /= d[0];
    for i in 1..n {
        let pivot = d[i] - lower[i] * c[i - 1];
        c[i] = upper[i] / pivot;
        b[i] = (b[i] - b[i - 1] * lower[i]) / pivot;
    }
    for i in (0..n - 1).rev() {
        let next = b[i + 1];
        b[i] -= next * c[i];
    }
}

fn natural(p: &[Point2], t: &[f64]) -> Vec<Point2> {
    let n = p.len();
    let h = |i: usize| t[i + 1] - t[i];
    let slope = |i: usize| (p[i + 1] - p[i]) / h(i);
    let (mut lower, mut d, mut upper) = (vec![1.0; n], vec![2.0; n], vec![1.0; n]);
    let mut b = vec![Point2::ZERO; n];
    b[0] = slope(0) * 3.0;
    b[n - 1] = slope(n - 2) * 3.0;
    for i in 1..n - 1 {
        let (before, after) = (1.0 / h(i - 1), 1.0 / h(i));
        (lower[i], d[i], upper[i]) = (before, 2.0 * (before + after), after);
        b[i] = (slope(i - 1) * before + slope(i) * after) * 3.0;
    }
    tridiagonal(&lower, &d, &upper, &mut b);
    b
}

fn periodic(p: &[Point2], t: &[f64]) -> Vec<Point2> {
    let n = p.len() - 1;
    let h = |i: usize| t[i + 1] - t[i];
    let slope = |i: usize| (p[i + 1] - p[i]) / h(i);
    let (mut lower, mut d, mut upper) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut b = vec![Point2::ZERO; n];
    for i in 0..n {
        let k = (i + n - 1) % n;
        let (before, after) = (1.0 / h(k), 1.0 / h(i));
        (lower[i], d[i], upper[i]) = (before, 2.0 * (before + after), after);
        b[i] = (slope(k) * before + slope(i) * after) * 3.0;
    }
    // A = T + u vᵀ with u = (g, 0, .., 0, corner), v = (1, 0, .., 0, corner / g); corner is both A[0][n-1] and A[n-1][0].
    let corner = lower[0];
    let g = -d[0];
    d[0] -= g;
    d[n - 1] -= corner * corner / g;
    let mut u = vec![Point2::ZERO; n];
    u[0].x = g;
    u[n - 1].x = corner;
    tridiagonal(&lower, &d, &upper, &mut b);
    tridiagonal(&lower, &d, &upper, &mut u);
    let v = |z: &[Point2]| z[0] + z[n - 1] * (corner / g);
    let f = v(&b) / (1.0 + v(&u).x);
    let mut m: Vec<_> = b.iter().zip(&u).map(|(b, u)| *b - f * u.x).collect();
    m.push(m[0]);
    m
}
