//! B-splines, rational (NURBS) or not.
//!
//! Evaluated by de Boor's algorithm in homogeneous coordinates; the derivatives are B-splines of lower degree.
//! Source: C. de Boor, *On calculating with B-splines*, J. Approx. Theory 6 (1972) 50-62.

use super::CurvePoint;
use crate::Point2;

/// Largest degree accepted; CAD files stay below 10.
const MAX_DEGREE: usize = 25;

/// Why a curve could not be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// Too few points for the kind of curve.
    #[error("a curve of this kind needs at least {needed} points, it has {found}")]
    TooFewPoints {
        /// How many it needs.
        needed: usize,
        /// How many it has.
        found: usize,
    },
    /// The degree is not between 1 and 25.
    #[error("the degree of a B-spline must be 1 to 25")]
    Degree,
    /// The knots are not as many as points + degree + 1, not increasing, or all equal.
    #[error("a B-spline needs points + degree + 1 knots that do not decrease")]
    Knots,
    /// The weights are not as many as the points or not all > 0.
    #[error("a rational B-spline needs one positive weight per point")]
    Weights,
    /// Two successive points are equal.
    #[error("point {index} repeats the one before it")]
    RepeatedPoint {
        /// The later one.
        index: usize,
    },
    /// A number is NaN or infinite.
    #[error("a coordinate, knot or weight is not finite")]
    NotFinite,
}

/// A point in homogeneous coordinates (x w, y w, w).
type Homogeneous = glam::DVec3;

/// A B-spline curve of a degree, on a knot vector, with control points and weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Nurbs {
    degree: usize,
    knots: Vec<f64>,
    /// Homogeneous control points of the curve and of its first two derivatives.
    controls: [Vec<Homogeneous>; 3],
}

impl Nurbs {
    /// A curve from its control points; `weights` empty for a polynomial one. Clamped and unclamped knots are
    /// accepted; the curve runs from knot `degree` to knot `n`.
    ///
    /// # Errors
    /// What does not fit, see [`CurveError`].
    pub fn new(degree: usize, knots: &[f64], points: &[Point2], weights: &[f64]) -> Result<Self, CurveError> {
        let n = points.len();
        if degree == 0 || degree > MAX_DEGREE {
            return Err(CurveError::Degree);
        }
        if n <= degree {
            return Err(CurveError::TooFewPoints { needed: degree + 1, found: n });
        }
        if knots.iter().chain(weights).any(|k| !k.is_finite()) || points.iter().any(|p| !p.is_finite()) {
            return Err(CurveError::NotFinite);
        }
        if knots.len() != n + degree + 1 || !knots.is_sorted() || knots[degree] >= knots[n] {
            return Err(CurveError::Knots);
        }
        if !weights.is_empty() && (weights.len() != n || weights.iter().any(|w| *w <= 0.0)) {
            return Err(CurveError::Weights);
        }
        let weight = |i: usize| weights.get(i).copied().unwrap_or(1.0);
        let c0: Vec<_> = (0..n).map(|i| (points[i] * weight(i)).extend(weight(i))).collect();
        let c1 = derived(degree, knots, &c0);
        let c2 = derived(degree - 1, &knots[1..knots.len() - 1], &c1);
        Ok(Self { degree, knots: knots.to_vec(), controls: [c0, c1, c2] })
    }

    /// First and last parameter.
    pub fn range(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.controls[0].len()])
    }

    /// The degree, 1 or more.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Control points and their weights; with weights of 1 exactly those that the curve was made of, otherwise to
    /// the last digit.
    pub fn controls(&self) -> impl Iterator<Item = (Point2, f64)> {
        self.controls[0].iter().map(|h| (h.truncate() / h.z, h.z))
    }

    /// The knots.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Point and derivatives at `t` in the range.
    pub fn eval(&self, t: f64) -> CurvePoint {
        let n = self.controls[0].len();
        // The knot span [u_k, u_k+1) of t; the last one is closed.
        let k = self.knots[self.degree + 1..n].partition_point(|u| *u <= t) + self.degree;
        let h: [Homogeneous; 3] = std::array::from_fn(|order| {
            if order > self.degree {
                return Homogeneous::ZERO;
            }
            let knots = &self.knots[order..self.knots.len() - order];
            de_boor(self.degree - order, knots, &self.controls[order], k - order, t)
        });
        // Quotient rule: (p w)' = p' w + p w'.
        let point = h[0].truncate() / h[0].z;
        let d1 = (h[1].truncate() - point * h[1].z) / h[0].z;
        let d2 = (h[2].truncate() - d1 * (2.0 * h[1].z) - point * h[2].z) / h[0].z;
        CurvePoint { point, d1, d2 }
    }
}

/// Control points of the derivative: p (c_{i+1} - c_i) / (u_{i+p+1} - u_{i+1}); 0 over an empty span.
fn derived(p: usize, knots: &[f64], c: &[Homogeneous]) -> Vec<Homogeneous> {
    if p == 0 {
        return Vec::new();
    }
    let step = |i: usize| {
        let span = knots[i + p + 1] - knots[i + 1];
        if span > 0.0 { (c[i + 1] - c[i]) * (p as f64 / span) } else { Homogeneous::ZERO }
    };
    (0..c.len() - 1).map(step).collect()
}

/// Value at `t` in the span k of the B-spline of degree `p`.
fn de_boor(p: usize, knots: &[f64], c: &[Homogeneous], k: usize, t: f64) -> Homogeneous {
    let mut d = [Homogeneous::ZERO; MAX_DEGREE + 1];
    d[..=p].copy_from_slice(&c[k - p..=k]);
    for r in 1..=p {
        for j in (r..=p).rev() {
            let (lo, hi) = (knots[j + k - p], knots[j + 1 + k - r]);
            let a = if hi > lo { (t - lo) / (hi - lo) } else { 0.0 };
            d[j] = d[j - 1] * (1.0 - a) + d[j] * a;
        }
    }
    d[p]
}
