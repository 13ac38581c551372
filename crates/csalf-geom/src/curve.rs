//! Curves of raw geometry: where a curve runs, how fast, how bent; nothing of meshes.
//!
//! All are parametric: [`Curve::eval`] gives the point and two derivatives at a parameter of [`Curve::range`].
//! Source of the ellipse and Bezier forms: their definitions; of B-splines see [`nurbs`], of splines [`spline`].

pub mod nurbs;
pub mod spline;

use crate::Point2;
use crate::angle::rotated;
use nurbs::{CurveError, Nurbs};
use spline::Spline;
use std::f64::consts::TAU;

/// Point, first and second derivative by the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Where the curve is.
    pub point: Point2,
    /// First derivative.
    pub d1: Point2,
    /// Second derivative.
    pub d2: Point2,
}

impl CurvePoint {
    /// Radius of curvature, > 0; infinite where the curve is straight (or stands still).
    pub fn radius(&self) -> f64 {
        let speed = self.d1.length();
        let r = speed * speed * speed / self.d1.perp_dot(self.d2).abs();
        if r.is_nan() { f64::INFINITY } else { r }
    }
}

/// A curve of finite length.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// Straight segments through the points, at least two; parameter i at point i.
    Polyline(Vec<Point2>),
    /// An arc of an ellipse; parameter 0 to 1.
    Arc {
        /// Centre.
        center: Point2,
        /// Semi-axes, > 0.
        radii: Point2,
        /// Angle of the first semi-axis, radians.
        rotation: f64,
        /// Eccentric angle of the start, radians.
        start: f64,
        /// Angle swept, radians, positive counter-clockwise, at most a full turn.
        sweep: f64,
    },
    /// A quadratic Bezier curve; parameter 0 to 1.
    Quadratic([Point2; 3]),
    /// A cubic Bezier curve; parameter 0 to 1.
    Cubic([Point2; 4]),
    /// A B-spline, rational or not; parameter by its knots.
    Nurbs(Nurbs),
    /// A cubic spline through points; parameter by its knots.
    Spline(Spline),
}

impl Curve {
    /// The segment from `a` to `b`.
    pub fn line(a: Point2, b: Point2) -> Self {
        Self::Polyline(vec![a, b])
    }

    /// An arc of a circle from angle `start` through `sweep` radians (positive counter-clockwise).
    pub fn arc(center: Point2, radius: f64, start: f64, sweep: f64) -> Self {
        Self::Arc { center, radii: Point2::splat(radius), rotation: 0.0, start, sweep }
    }

    /// A full circle, counter-clockwise from its rightmost point.
    pub fn circle(center: Point2, radius: f64) -> Self {
        Self::arc(center, radius, 0.0, TAU)
    }

    /// The arc from `a` to `b` with a bulge: the tangent of a quarter of the swept angle, positive
    /// counter-clockwise (as in DXF polylines). A bulge of 0 is the segment.
    pub fn bulge(a: Point2, b: Point2, bulge: f64) -> Self {
        if bulge == 0.0 || a == b {
            return Self::line(a, b);
        }
        let sweep = 4.0 * bulge.atan();
        // Apothem from the middle of the chord to the centre, to the left.
        let center = a.midpoint(b) + (b - a).perp() * ((1.0 - bulge * bulge) / (4.0 * bulge));
        let r = a - center;
        Self::arc(center, r.length(), r.y.atan2(r.x), sweep)
    }

    /// The cubic spline through `points`; see [`Spline::new`].
    ///
    /// # Errors
    /// Fewer than two (closed: three) points, or two successive equal ones.
    pub fn through(points: &[Point2], closed: bool) -> Result<Self, CurveError> {
        Spline::new(points, closed).map(Self::Spline)
    }

    /// First and last parameter; the first is smaller.
    pub fn range(&self) -> (f64, f64) {
        match self {
            Self::Polyline(p) => (0.0, p.len().saturating_sub(1) as f64),
            Self::Arc { .. } | Self::Quadratic(_) | Self::Cubic(_) => (0.0, 1.0),
            Self::Nurbs(n) => n.range(),
            Self::Spline(s) => s.range(),
        }
    }

    /// Parameters inside the range where the curve may be less smooth: nodes and knots, increasing.
    pub fn breaks(&self) -> Vec<f64> {
        let (t0, t1) = self.range();
        let mut t: Vec<f64> = match self {
            Self::Polyline(p) => (1..p.len().saturating_sub(1)).map(|i| i as f64).collect(),
            Self::Nurbs(n) => n.knots().to_vec(),
            Self::Spline(s) => s.knots().to_vec(),
            _ => Vec::new(),
        };
        t.retain(|t| *t > t0 && *t < t1);
        t.dedup();
        t
    }

    /// Point and derivatives at `t`, clamped to the range. At a break the derivatives are those after it. An empty
    /// polyline is at the origin.
    pub fn eval(&self, t: f64) -> CurvePoint {
        let (t0, t1) = self.range();
        let t = t.clamp(t0, t1);
        match self {
            Self::Polyline(p) if p.len() < 2 => {
                let point = p.first().copied().unwrap_or_default();
                CurvePoint { point, d1: Point2::ZERO, d2: Point2::ZERO }
            }
            Self::Polyline(p) => {
                let i = (t as usize).min(p.len() - 2);
                let f = t - i as f64;
                let point = if f >= 1.0 { p[i + 1] } else { p[i].lerp(p[i + 1], f) };
                CurvePoint { point, d1: p[i + 1] - p[i], d2: Point2::ZERO }
            }
            Self::Arc { center, radii, rotation, start, sweep } => {
                let (s, c) = (start + t * sweep).sin_cos();
                let r = rotated(*radii * Point2::new(c, s), *rotation);
                let d1 = rotated(*radii * Point2::new(-s, c), *rotation) * *sweep;
                CurvePoint { point: *center + r, d1, d2: -r * (sweep * sweep) }
            }
            Self::Quadratic([a, b, c]) => {
                let s = 1.0 - t;
                CurvePoint {
                    point: *a * (s * s) + *b * (2.0 * s * t) + *c * (t * t),
                    d1: ((*b - *a) * s + (*c - *b) * t) * 2.0,
                    d2: (*a - *b * 2.0 + *c) * 2.0,
                }
            }
            Self::Cubic([a, b, c, d]) => {
                let s = 1.0 - t;
                CurvePoint {
                    point: *a * (s * s * s)
                        + *b * (3.0 * s * s * t)
                        + *c * (3.0 * s * t * t)
                        + *d * (t * t * t),
                    d1: ((*b - *a) * (s * s) + (*c - *b) * (2.0 * s * t) + (*d - *c) * (t * t)) * 3.0,
                    d2: ((*a - *b * 2.0 + *c) * s + (*b - *c * 2.0 + *d) * t) * 6.0,
                }
            }
            Self::Nurbs(n) => n.eval(t),
            Self::Spline(s) => s.eval(t),
        }
    }

    /// First point.
    pub fn start(&self) -> Point2 {
        self.eval(self.range().0).point
    }

    /// Last point.
    pub fn end(&self) -> Point2 {
        self.eval(self.range().1).point
    }

    /// Unit vector from the point at `t` to one nearby on the way to parameter `toward`: the direction of the curve,
    /// to about 1e-3 radians, also at breaks and where the derivative vanishes. Zero if the curve stands still.
    pub fn direction(&self, t: f64, toward: f64) -> Point2 {
        /// Share of the way that the chord covers: larger, less exact on strong curvature; smaller, fewer digits.
        const CHORD: f64 = 1e-4;
        (self.eval(t + CHORD * (toward - t)).point - self.eval(t).point).normalize_or_zero()
    }

    /// True if all numbers are finite and the curve has at least two points.
    pub fn is_finite(&self) -> bool {
        let all = |p: &[Point2]| p.iter().all(|p| p.is_finite());
        match self {
            Self::Polyline(p) => p.len() >= 2 && all(p),
            Self::Arc { center, radii, rotation, start, sweep } => {
                all(&[*center, *radii]) && rotation.is_finite() && start.is_finite() && sweep.is_finite()
            }
            Self::Quadratic(p) => all(p),
            Self::Cubic(p) => all(p),
            // Checked when they were made.
            Self::Nurbs(_) | Self::Spline(_) => true,
        }
    }
}

fn from_kurbo(p: kurbo::Point) -> Point2 {
    Point2::new(p.x, p.y)
}

impl From<kurbo::PathSeg> for Curve {
    fn from(s: kurbo::PathSeg) -> Self {
        match s {
            kurbo::PathSeg::Line(l) => Self::line(from_kurbo(l.p0), from_kurbo(l.p1)),
            kurbo::PathSeg::Quad(q) => Self::Quadratic([q.p0, q.p1, q.p2].map(from_kurbo)),
            kurbo::PathSeg::Cubic(c) => Self::Cubic([c.p0, c.p1, c.p2, c.p3].map(from_kurbo)),
        }
    }
}

impl From<kurbo::Arc> for Curve {
    fn from(a: kurbo::Arc) -> Self {
        Self::Arc {
            center: from_kurbo(a.center),
            radii: Point2::new(a.radii.x, a.radii.y),
            rotation: a.x_rotation,
            start: a.start_angle,
            sweep: a.sweep_angle,
        }
    }
}

#[cfg(test)]
mod tests;
