//! Surfaces in closed form, and NURBS: point, derivatives, normal, curvature, closed directions, poles.
//!
//! ```text
//!   plane     o + u x + v y                                  cylinder  o + r e(u) + v z
//!   cone      o + (r + v sin a) e(u) + v cos a z             sphere    o + r cos v e(u) + r sin v z
//!   torus     o + (R + r cos v) e(u) + r sin v z             e(u) = cos u x + sin u y
//! ```
//!
//! The normal is du × dv: outward for all of them. The cone's v is the length along its line (STEP's is along its
//! axis), so that a cone unrolls without stretching.

use super::{Frame, Motion, NurbsSurface};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// A point of a surface and its derivatives by the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where.
    pub point: DVec3,
    /// First derivative by u.
    pub du: DVec3,
    /// First derivative by v.
    pub dv: DVec3,
    /// Second derivative, u and u.
    pub duu: DVec3,
    /// Second derivative, u and v.
    pub duv: DVec3,
    /// Second derivative, v and v.
    pub dvv: DVec3,
}

impl SurfacePoint {
    /// Unit normal, du × dv; zero at a pole.
    pub fn normal(&self) -> DVec3 {
        self.du.cross(self.dv).try_normalize().unwrap_or(DVec3::ZERO)
    }

    /// Largest normal curvature in 1/length, from the fundamental forms; zero where it is not defined.
    pub fn max_curvature(&self) -> f64 {
        let n = self.normal();
        let (e, f, g) = (self.du.length_squared(), self.du.dot(self.dv), self.dv.length_squared());
        let (l, m, k) = (self.duu.dot(n), self.duv.dot(n), self.dvv.dot(n));
        let det = e * g - f * f;
        let mean = (e * k - 2.0 * f * m + g * l) / (2.0 * det);
        let gauss = (l * k - m * m) / det;
        let root = (mean * mean - gauss).max(0.0).sqrt();
        let most = mean.abs() + root;
        if most.is_finite() { most } else { 0.0 }
    }

    /// Normal curvature along u and along v, in 1/length.
    pub fn curvatures(&self) -> [f64; 2] {
        let n = self.normal();
        let one = |d1: DVec3, d2: DVec3| {
            let k = d2.dot(n).abs() / d1.length_squared();
            if k.is_finite() { k } else { 0.0 }
        };
        [one(self.du, self.duu), one(self.dv, self.dvv)]
    }
}

/// A surface in space.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// The frame's x, y plane.
    Plane(Frame),
    /// Around the frame's z axis.
    Cylinder {
        /// Axis and zero angle.
        frame: Frame,
        /// Radius.
        radius: f64,
    },
    /// Around the frame's z axis, widening along it (for a positive angle).
    Cone {
        /// Axis and zero angle.
        frame: Frame,
        /// Radius where v = 0.
        radius: f64,
        /// Half angle at the apex, radians, in (-π/2, π/2) and not zero.
        angle: f64,
    },
    /// Around the frame's origin.
    Sphere {
        /// Centre, poles and zero angle.
        frame: Frame,
        /// Radius.
        radius: f64,
    },
    /// Around the frame's z axis.
    Torus {
        /// Axis and zero angle.
        frame: Frame,
        /// Radius of the centre circle.
        major: f64,
        /// Radius of the tube.
        minor: f64,
    },
    /// A rational B-spline.
    Nurbs(NurbsSurface),
}

impl Surface {
    /// What it is, in one word.
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Plane(_) => "plane",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Sphere { .. } => "sphere",
            Self::Torus { .. } => "torus",
            Self::Nurbs(_) => "nurbs",
        }
    }

    /// Periods of u and v, where the surface closes.
    pub const fn periods(&self) -> [Option<f64>; 2] {
        match self {
            Self::Plane(_) => [None, None],
            Self::Cylinder { .. } | Self::Cone { .. } | Self::Sphere { .. } => [Some(TAU), None],
            Self::Torus { .. } => [Some(TAU), Some(TAU)],
            Self::Nurbs(n) => n.periods,
        }
    }

    /// Values of v at which the whole line of u is one point (below, above); NURBS: found from the control points.
    pub fn poles(&self) -> [Option<f64>; 2] {
        match self {
            Self::Sphere { .. } => [Some(-FRAC_PI_2), Some(FRAC_PI_2)],
            Self::Cone { radius, angle, .. } => {
                let apex = -radius / angle.sin();
                if *angle > 0.0 { [Some(apex), None] } else { [None, Some(apex)] }
            }
            Self::Nurbs(n) => {
                let ([low, high], [v0, v1]) = (n.poles(), n.knots[1].range());
                [low.then_some(v0), high.then_some(v1)]
            }
            _ => [None, None],
        }
    }

    /// The surface with its closed direction along u and its poles at the ends of v, as the closed forms have them: a
    /// NURBS that has them the other way is transposed. The flag says whether the normal stays.
    pub fn in_order(self) -> (Self, bool) {
        let Self::Nurbs(n) = self else { return (self, true) };
        let turned = n.transposed();
        let (here, there) = (n.poles().contains(&true), turned.poles().contains(&true));
        let closed_v_only = n.periods[0].is_none() && n.periods[1].is_some();
        if !here && (there || closed_v_only) { (Self::Nurbs(turned), false) } else { (Self::Nurbs(n), true) }
    }

    /// Point and derivatives at `uv`.
    pub fn eval(&self, uv: DVec2) -> SurfacePoint {
        let (u, v) = (uv.x, uv.y);
        match self {
            Self::Plane(f) => SurfacePoint {
                point: f.point(u, v, 0.0),
                du: f.x,
                dv: f.y,
                duu: DVec3::ZERO,
                duv: DVec3::ZERO,
                dvv: DVec3::ZERO,
            },
            Self::Cylinder { frame, radius } => revolved(frame, u, [*radius, 0.0, 0.0], [v, 1.0, 0.0]),
            Self::Cone { frame, radius, angle } => {
                let (s, c) = angle.sin_cos();
                revolved(frame, u, [radius + v * s, s, 0.0], [v * c, c, 0.0])
            }
            Self::Sphere { frame, radius } => {
                let (s, c) = v.sin_cos();
                revolved(
                    frame,
                    u,
                    [radius * c, -radius * s, -radius * c],
                    [radius * s, radius * c, -radius * s],
                )
            }
            Self::Torus { frame, major, minor } => {
                let (s, c) = v.sin_cos();
                revolved(
                    frame,
                    u,
                    [major + minor * c, -minor * s, -minor * c],
                    [minor * s, minor * c, -minor * s],
                )
            }
            Self::Nurbs(n) => n.eval(uv),
        }
    }

    /// The parameters of the point nearest to `p`, in closed form; angles in (-π, π]. `None` for NURBS.
    ///
    /// At a pole, u is whatever the arc tangent makes of zero; the caller takes it from a neighbour.
    pub fn closed_form_parameters(&self, p: DVec3) -> Option<DVec2> {
        Some(match self {
            Self::Nurbs(_) => return None,
            Self::Plane(frame) => frame.local(p).truncate(),
            Self::Cylinder { frame, .. } => {
                let q = frame.local(p);
                DVec2::new(q.y.atan2(q.x), q.z)
            }
            Self::Cone { frame, radius, angle } => {
                let q = frame.local(p);
                let (s, c) = angle.sin_cos();
                let apex = -radius / s;
                // Beyond the apex, angles would jump by half a turn: such points belong to the apex.
                let v = (q.truncate().length() - radius) * s + q.z * c;
                let v = if *angle > 0.0 { v.max(apex) } else { v.min(apex) };
                DVec2::new(q.y.atan2(q.x), v)
            }
            Self::Sphere { frame, .. } => {
                let q = frame.local(p);
                DVec2::new(q.y.atan2(q.x), q.z.atan2(q.truncate().length()))
            }
            Self::Torus { frame, major, .. } => {
                let q = frame.local(p);
                DVec2::new(q.y.atan2(q.x), q.z.atan2(q.truncate().length() - major))
            }
        })
    }

    /// The surface moved.
    pub fn moved(&self, by: &Motion) -> Self {
        match self {
            Self::Plane(f) => Self::Plane(f.moved(by)),
            Self::Cylinder { frame, radius } => Self::Cylinder { frame: frame.moved(by), radius: *radius },
            Self::Cone { frame, radius, angle } => {
                Self::Cone { frame: frame.moved(by), radius: *radius, angle: *angle }
            }
            Self::Sphere { frame, radius } => Self::Sphere { frame: frame.moved(by), radius: *radius },
            Self::Torus { frame, major, minor } => {
                Self::Torus { frame: frame.moved(by), major: *major, minor: *minor }
            }
            Self::Nurbs(n) => Self::Nurbs(n.mapped(|p| by.point(p))),
        }
    }
}

/// A surface of revolution at angle `u`: radius and height of its profile with their first two derivatives.
fn revolved(frame: &Frame, u: f64, r: [f64; 3], z: [f64; 3]) -> SurfacePoint {
    let (e, d) = frame.circle(u);
    SurfacePoint {
        point: frame.origin + e * r[0] + frame.z * z[0],
        du: d * r[0],
        dv: e * r[1] + frame.z * z[1],
        duu: -e * r[0],
        duv: d * r[1],
        dvv: e * r[2] + frame.z * z[2],
    }
}
