//! Curves in space, in closed form where there is one.

use super::{Frame, Motion, NurbsCurve};
use glam::DVec3;
use std::f64::consts::TAU;

/// A point of a curve and its derivatives by the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Where.
    pub point: DVec3,
    /// First derivative.
    pub d1: DVec3,
    /// Second derivative.
    pub d2: DVec3,
}

impl CurvePoint {
    /// Curvature in 1/length; zero where the curve stands still.
    pub fn curvature(&self) -> f64 {
        let speed = self.d1.length();
        let k = self.d1.cross(self.d2).length() / (speed * speed * speed);
        if k.is_finite() { k } else { 0.0 }
    }
}

/// A chain of straight segments; the parameter is the length along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    points: Vec<DVec3>,
    lengths: Vec<f64>,
}

impl Polyline {
    /// A polyline through at least two points, of a length that is not zero.
    pub fn new(points: Vec<DVec3>) -> Option<Self> {
        if points.len() < 2 || points.iter().any(|p| !p.is_finite()) {
            return None;
        }
        let mut lengths = Vec::with_capacity(points.len());
        let mut sum = 0.0;
        lengths.push(0.0);
        for w in points.windows(2) {
            sum += w[0].distance(w[1]);
            lengths.push(sum);
        }
        (sum > 0.0 && sum.is_finite()).then_some(Self { points, lengths })
    }

    /// Length.
    pub fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// The points.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Length along the chain to each point.
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    fn eval(&self, t: f64) -> CurvePoint {
        let t = t.clamp(0.0, self.length());
        let last = self.points.len() - 2;
        let i = self.lengths.partition_point(|&l| l <= t).saturating_sub(1).min(last);
        let (a, b) = (self.points[i], self.points[i + 1]);
        let length = self.lengths[i + 1] - self.lengths[i];
        let s = if length > 0.0 { ((t - self.lengths[i]) / length).clamp(0.0, 1.0) } else { 0.0 };
        let d1 = (b - a).try_normalize().unwrap_or(DVec3::ZERO);
        CurvePoint { point: a + (b - a) * s, d1, d2: DVec3::ZERO }
    }
}

/// A curve in space.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// A straight line; the parameter is the length from the origin along a unit direction.
    Line {
        /// Where the parameter is zero.
        origin: DVec3,
        /// Unit direction.
        direction: DVec3,
    },
    /// A circle in the frame's x, y plane, or an ellipse; the parameter is the (eccentric) angle in radians.
    Ellipse {
        /// Centre and axes.
        frame: Frame,
        /// Half axis along x.
        a: f64,
        /// Half axis along y.
        b: f64,
    },
    /// A rational B-spline.
    Nurbs(NurbsCurve),
    /// A chain of straight segments: edges of faceted models.
    Polyline(Polyline),
}

impl Curve {
    /// A circle.
    pub const fn circle(frame: Frame, radius: f64) -> Self {
        Self::Ellipse { frame, a: radius, b: radius }
    }

    /// The line from `a` to `b` and its range; `None` if they are one point.
    pub fn segment(a: DVec3, b: DVec3) -> Option<(Self, [f64; 2])> {
        let direction = (b - a).try_normalize()?;
        Some((Self::Line { origin: a, direction }, [0.0, a.distance(b)]))
    }

    /// The parameter's period, if the curve closes.
    pub fn period(&self) -> Option<f64> {
        match self {
            Self::Ellipse { .. } => Some(TAU),
            _ => None,
        }
    }

    /// Point and derivatives at `t`.
    pub fn eval(&self, t: f64) -> CurvePoint {
        match self {
            Self::Line { origin, direction } => {
                CurvePoint { point: *origin + *direction * t, d1: *direction, d2: DVec3::ZERO }
            }
            Self::Ellipse { frame, a, b } => {
                let (s, c) = t.sin_cos();
                let (x, y) = (frame.x * *a, frame.y * *b);
                CurvePoint { point: frame.origin + x * c + y * s, d1: y * c - x * s, d2: -(x * c + y * s) }
            }
            Self::Nurbs(n) => n.eval(t),
            Self::Polyline(p) => p.eval(t),
        }
    }

    /// The parameter of the point nearest to `p` on a line, circle or (nearly) ellipse; `None` of the other kinds.
    pub fn closed_form_parameter(&self, p: DVec3) -> Option<f64> {
        match self {
            Self::Line { origin, direction } => Some((p - *origin).dot(*direction)),
            Self::Ellipse { frame, a, b } => {
                let q = frame.local(p);
                Some((q.y * a).atan2(q.x * b))
            }
            Self::Nurbs(_) | Self::Polyline(_) => None,
        }
    }

    /// The parameter within `range` whose point is nearest to `p`: samples, then golden section around the best.
    /// Cost about 150 evaluations.
    pub fn nearest(&self, p: DVec3, range: [f64; 2]) -> f64 {
        const SAMPLES: u32 = 64;
        let at = |s: f64| range[0] + (range[1] - range[0]) * s;
        let distance = |s: f64| self.eval(at(s)).point.distance_squared(p);
        let step = 1.0 / f64::from(SAMPLES);
        let best = (0..=SAMPLES)
            .map(|k| f64::from(k) * step)
            .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
            .unwrap_or(0.0);
        let (mut lo, mut hi) = ((best - step).max(0.0), (best + step).min(1.0));
        let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
        for _ in 0..48 {
            let (a, b) = (hi - (hi - lo) * ratio, lo + (hi - lo) * ratio);
            if distance(a) <= distance(b) {
                hi = b;
            } else {
                lo = a;
            }
        }
        let mid = 0.5 * (lo + hi);
        let s = [mid, best, lo, hi].into_iter().min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        at(s.unwrap_or(mid))
    }

    /// The curve moved.
    pub fn moved(&self, by: &Motion) -> Self {
        match self {
            Self::Line { origin, direction } => {
                Self::Line { origin: by.point(*origin), direction: by.vector(*direction) }
            }
            Self::Ellipse { frame, a, b } => Self::Ellipse { frame: frame.moved(by), a: *a, b: *b },
            Self::Nurbs(n) => Self::Nurbs(n.mapped(|p| by.point(p))),
            Self::Polyline(p) => Self::Polyline(Polyline {
                points: p.points.iter().map(|p| by.point(*p)).collect(),
                lengths: p.lengths.clone(),
            }),
        }
    }
}
