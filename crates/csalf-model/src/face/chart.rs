//! A chart: a map of the part of the surface that a face covers to the plane, without seams, and without poles where
//! that can be had. Orientation is kept.
//!
//! | surface | chart | lengths |
//! |---|---|---|
//! | plane | its own coordinates | exact |
//! | cylinder | (r u, v) | exact |
//! | cone | unrolled around its apex | exact |
//! | cone with its apex inside | distance from the apex, angle u | exact along the lines |
//! | sphere | stereographic, from the middle of the face | in one proportion locally |
//! | torus | (c u, c ψ(v)) with ψ' = r / (R + r cos v) | in one proportion locally |
//! | NURBS | (u, v), each scaled to the mean length | none |
//! | NURBS with a pole inside | distance from the pole in v, angle u | none |

use crate::geometry::{Frame, Surface, SurfacePoint};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// The map.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Plane,
    /// Scale of u and of v.
    Scaled(DVec2),
    /// Unrolled: v of the apex, sine of the angle, u in the middle.
    Unrolled {
        apex: f64,
        sine: f64,
        middle: f64,
    },
    /// Around a pole: its v, sign of v away from it, scale of v, where u begins and its period.
    Polar {
        pole: f64,
        sign: f64,
        scale: f64,
        start: f64,
        period: f64,
    },
    /// Stereographic: the frame's z points to the middle of the face.
    Stereo {
        frame: Frame,
        radius: f64,
    },
    /// Isothermal coordinates of a torus: radii, scale.
    Torus {
        major: f64,
        minor: f64,
        scale: f64,
    },
}

/// A chart of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chart<'a> {
    pub(super) surface: &'a Surface,
    pub(super) kind: Kind,
}

impl<'a> Chart<'a> {
    /// The chart of a face that stays clear of poles, or has them on its boundary; `low` and `high` bound its
    /// parameters.
    pub(super) fn band(surface: &'a Surface, low: DVec2, high: DVec2) -> Self {
        let kind = match surface {
            Surface::Plane(_) => Kind::Plane,
            Surface::Cylinder { radius, .. } => Kind::Scaled(DVec2::new(*radius, 1.0)),
            Surface::Cone { radius, angle, .. } => Kind::Unrolled {
                apex: -radius / angle.sin(),
                sine: angle.sin().abs(),
                middle: 0.5 * (low.x + high.x),
            },
            Surface::Torus { major, minor, .. } if major > minor && *minor > 0.0 => {
                // Lengths are right where the torus is cut by the middle v.
                let middle = 0.5 * (low.y + high.y);
                Kind::Torus { major: *major, minor: *minor, scale: major + minor * middle.cos() }
            }
            _ => Kind::Scaled(mean_lengths(surface, low, high)),
        };
        Self { surface, kind }
    }

    /// The chart of a face around a pole at `pole` (a value of v), the material on the side of `other`.
    pub(super) fn polar(surface: &'a Surface, pole: f64, low: DVec2, high: DVec2) -> Self {
        let period = surface.periods()[0].unwrap_or(TAU);
        let scale = match surface {
            Surface::Nurbs(_) => mean_lengths(surface, low, high).y,
            _ => 1.0,
        };
        let sign = if 0.5 * (low.y + high.y) < pole { -1.0 } else { 1.0 };
        Self { surface, kind: Kind::Polar { pole, sign, scale, start: low.x, period } }
    }

    /// The stereographic chart of a sphere, with `middle` (a direction) in its middle.
    pub(super) fn stereographic(surface: &'a Surface, frame: &Frame, radius: f64, middle: DVec3) -> Self {
        let frame = Frame::new(frame.origin, middle, frame.x);
        Self { surface, kind: Kind::Stereo { frame, radius } }
    }

    /// Where parameters lie in the chart.
    pub(super) fn place(&self, uv: DVec2) -> DVec2 {
        match self.kind {
            Kind::Plane => uv,
            Kind::Scaled(s) => uv * s,
            Kind::Unrolled { apex, sine, middle } => {
                let v = uv.y - apex;
                let q = DVec2::from_angle((uv.x - middle) * sine) * v.abs();
                // u goes along +x and v along +y in the middle, whether v runs away from the apex or towards it.
                if apex_below(self.surface) { DVec2::new(q.y, q.x) } else { DVec2::new(q.y, -q.x) }
            }
            Kind::Polar { pole, sign, scale, start, period } => {
                let angle = (uv.x - start) / period * TAU;
                let q = DVec2::from_angle(angle) * ((uv.y - pole).abs() * scale);
                // Going away from the pole along +v and round along +u turns clockwise: mirrored.
                if sign > 0.0 { DVec2::new(q.y, q.x) } else { q }
            }
            Kind::Stereo { .. } => self.place_point(self.surface.eval(uv).point),
            Kind::Torus { major, minor, scale } => DVec2::new(uv.x, psi(uv.y, major, minor)) * scale,
        }
    }

    /// Where a point of a sphere lies in the chart.
    pub(super) fn place_point(&self, p: DVec3) -> DVec2 {
        match self.kind {
            Kind::Stereo { frame, radius } => {
                let q = frame.local(p);
                q.truncate() * (2.0 * radius / (radius + q.z).max(radius * f64::EPSILON))
            }
            _ => DVec2::ZERO,
        }
    }

    /// The parameters at a place of the chart (of a sphere: not used, see [`Self::eval`]).
    pub(super) fn parameters(&self, q: DVec2) -> DVec2 {
        match self.kind {
            Kind::Plane => q,
            Kind::Scaled(s) => q / s,
            Kind::Unrolled { apex, sine, middle } => {
                let above = apex_below(self.surface);
                let (q, sign) =
                    if above { (DVec2::new(q.y, q.x), 1.0) } else { (DVec2::new(-q.y, q.x), -1.0) };
                DVec2::new(middle + q.to_angle() / sine, apex + sign * q.length())
            }
            Kind::Polar { pole, sign, scale, start, period } => {
                let r = if sign > 0.0 { DVec2::new(q.y, q.x) } else { q };
                DVec2::new(
                    start + r.to_angle().rem_euclid(TAU) / TAU * period,
                    pole + sign * r.length() / scale,
                )
            }
            Kind::Stereo { .. } => {
                let p = self.eval(q).point;
                self.surface.closed_form_parameters(p).unwrap_or(DVec2::ZERO)
            }
            Kind::Torus { major, minor, scale } => {
                DVec2::new(q.x / scale, inverse_psi(q.y / scale, major, minor))
            }
        }
    }

    /// The surface at a place of the chart. The derivatives are by the parameters, or (sphere) not filled in but for
    /// the first ones.
    pub(super) fn eval(&self, q: DVec2) -> SurfacePoint {
        if let Kind::Stereo { frame, radius } = self.kind {
            let w = q / (2.0 * radius);
            let s = w.length_squared();
            let k = 2.0 * radius / (1.0 + s);
            let point = frame.point(w.x * k, w.y * k, radius * (1.0 - s) / (1.0 + s));
            let n = (point - frame.origin).normalize_or_zero();
            let (du, dv) = n.any_orthonormal_pair();
            let bend = -n / radius;
            return SurfacePoint { point, du, dv, duu: bend, duv: DVec3::ZERO, dvv: bend };
        }
        self.surface.eval(self.parameters(q))
    }

    /// True if the chart is fit for meshing in it: lengths are right, or in one proportion locally.
    pub(super) const fn is_good(&self) -> bool {
        match self.kind {
            Kind::Plane | Kind::Unrolled { .. } | Kind::Stereo { .. } | Kind::Torus { .. } => true,
            Kind::Scaled(_) => matches!(self.surface, Surface::Cylinder { .. }),
            Kind::Polar { .. } => false,
        }
    }
}

/// Whether a cone's v grows away from its apex.
fn apex_below(surface: &Surface) -> bool {
    match surface {
        Surface::Cone { angle, .. } => *angle > 0.0,
        _ => true,
    }
}

/// ∫ r dv / (R + r cos v) from 0, with its whole turns.
fn psi(v: f64, major: f64, minor: f64) -> f64 {
    let root = (major * major - minor * minor).sqrt();
    let turns = (v / TAU).round();
    let rest = v - turns * TAU;
    let half = ((major - minor) / (major + minor)).sqrt() * (0.5 * rest).tan();
    2.0 * minor / root * (half.atan() + turns * PI)
}

fn inverse_psi(p: f64, major: f64, minor: f64) -> f64 {
    let root = (major * major - minor * minor).sqrt();
    let a = p * root / (2.0 * minor);
    let turns = (a / PI).round();
    let half = (a - turns * PI).tan() / ((major - minor) / (major + minor)).sqrt();
    2.0 * half.atan() + turns * TAU
}

/// Mean length of du and of dv over a box, at least a share of each other so that neither vanishes.
fn mean_lengths(surface: &Surface, low: DVec2, high: DVec2) -> DVec2 {
    const N: u32 = 8;
    let mut sum = DVec2::ZERO;
    for i in 0..=N {
        for j in 0..=N {
            let s = DVec2::new(f64::from(i), f64::from(j)) / f64::from(N);
            let at = surface.eval(low + (high - low) * s);
            sum += DVec2::new(at.du.length(), at.dv.length());
        }
    }
    let mean = sum / f64::from((N + 1) * (N + 1));
    let usable = |x: f64| if x.is_finite() && x > 0.0 { x } else { 1.0 };
    DVec2::new(usable(mean.x), usable(mean.y))
}
