//! Curves and surfaces of a STEP model.

use csalf_model::geometry::{Curve, Frame, NurbsCurve, NurbsSurface, Polyline, Surface};
use glam::DVec3;
use std::f64::consts::TAU;
use step_io::StepModel;
use step_io::model as m;
use step_io::scene::{CurveKind, SurfaceKind};

/// A place in space.
pub(crate) fn vec3(x: [f64; 3]) -> DVec3 {
    DVec3::from_array(x)
}

fn list3(x: &[f64]) -> DVec3 {
    let at = |k: usize| x.get(k).copied().unwrap_or(0.0);
    DVec3::new(at(0), at(1), at(2))
}

fn direction(model: &StepModel, d: &Option<m::DirectionRef>) -> Option<DVec3> {
    match d {
        Some(m::DirectionRef::Direction(id)) => Some(list3(&model[*id].direction_ratios)),
        _ => None,
    }
}

fn frame_of(model: &StepModel, id: m::Axis2Placement3dId) -> Option<Frame> {
    let p = &model[id];
    let m::CartesianPointRef::CartesianPoint(at) = p.location else { return None };
    let axis = direction(model, &p.axis).unwrap_or(DVec3::Z);
    let reference = direction(model, &p.ref_direction).unwrap_or(DVec3::X);
    Some(Frame::new(list3(&model[at].coordinates), axis, reference))
}

fn frame(model: &StepModel, r: &m::Axis2Placement3dRef) -> Option<Frame> {
    let m::Axis2Placement3dRef::Axis2Placement3d(id) = r;
    frame_of(model, *id)
}

fn frame_of_conic(model: &StepModel, r: &m::Axis2PlacementRef) -> Option<Frame> {
    match r {
        m::Axis2PlacementRef::Axis2Placement3d(id) => frame_of(model, *id),
        m::Axis2PlacementRef::Axis2Placement2d(_) => None,
    }
}

/// The curve of an edge between its vertices and its range, from start to end.
pub(crate) fn edge_curve(
    model: &StepModel,
    edge: &step_io::scene::Edge<'_>,
    ends: [DVec3; 2],
) -> Option<(Curve, [f64; 2])> {
    /// Curves on surfaces lie within each other no deeper than this.
    const DEPTH: usize = 4;
    let mut curve = edge.curve();
    for _ in 0..DEPTH {
        curve = curve.curve_3d().unwrap_or(curve);
    }
    let closed = edge.start().map(|v| v.key()) == edge.end().map(|v| v.key());
    match curve.kind() {
        CurveKind::Line(_) => Curve::segment(ends[0], ends[1]),
        CurveKind::Circle(c) => {
            conic(frame_of_conic(model, &c.position)?, c.radius, c.radius, edge, ends, closed)
        }
        CurveKind::Ellipse(e) => {
            conic(frame_of_conic(model, &e.position)?, e.semi_axis_1, e.semi_axis_2, edge, ends, closed)
        }
        CurveKind::Polyline(_) => {
            let n = edge.to_nurbs()?;
            let line = Polyline::new(n.control_points.iter().map(|p| vec3(*p)).collect())?;
            let range = [0.0, line.length()];
            Some((Curve::Polyline(line), range))
        }
        _ => {
            let n = edge.to_nurbs()?;
            let points: Vec<DVec3> = n.control_points.iter().map(|p| vec3(*p)).collect();
            let curve = NurbsCurve::new(n.degree, n.knots, &points, &n.weights)?;
            let range = curve.knots.range();
            Some((Curve::Nurbs(curve), range))
        }
    }
}

/// An arc from vertex to vertex, in the sense of the edge.
fn conic(
    frame: Frame,
    a: f64,
    b: f64,
    edge: &step_io::scene::Edge<'_>,
    ends: [DVec3; 2],
    closed: bool,
) -> Option<(Curve, [f64; 2])> {
    if !(a > 0.0 && b > 0.0 && a.is_finite() && b.is_finite()) {
        return None;
    }
    let curve = Curve::Ellipse { frame, a, b };
    let [t0, t1] = ends.map(|p| curve.closed_form_parameter(p).unwrap_or(0.0));
    // Vertices nearer than this share of the radius are one: a full turn.
    const ONE: f64 = 1e-9;
    let whole = closed || ends[0].distance(ends[1]) <= ONE * a.max(b);
    let turn = if edge.same_sense() { (t1 - t0).rem_euclid(TAU) } else { -(t0 - t1).rem_euclid(TAU) };
    let sense = if edge.same_sense() { TAU } else { -TAU };
    Some((curve, [t0, t0 + if whole || turn == 0.0 { sense } else { turn }]))
}

/// The surface of a face, and whether its normal is that of the file's surface.
pub(crate) fn face_surface(
    model: &StepModel,
    face: &step_io::scene::Face<'_>,
    radians: f64,
) -> Option<(Surface, bool)> {
    let good = |r: f64| r > 0.0 && r.is_finite();
    let surface = match face.surface().kind() {
        SurfaceKind::Plane(p) => Some(Surface::Plane(frame(model, &p.position)?)),
        SurfaceKind::Cylindrical(c) if good(c.radius) => {
            Some(Surface::Cylinder { frame: frame(model, &c.position)?, radius: c.radius })
        }
        SurfaceKind::Conical(c) if c.radius >= 0.0 => {
            let angle = c.semi_angle * radians;
            // A cone flatter or steeper than this is a plane or a cylinder with rounding.
            const FLAT: f64 = 1e-6;
            let usable = angle.sin().abs() > FLAT && angle.cos() > FLAT;
            let cone = Surface::Cone { frame: frame(model, &c.position)?, radius: c.radius, angle };
            usable.then_some(cone)
        }
        SurfaceKind::Spherical(s) if good(s.radius) => {
            Some(Surface::Sphere { frame: frame(model, &s.position)?, radius: s.radius })
        }
        SurfaceKind::Toroidal(t) if good(t.minor_radius) && t.major_radius > t.minor_radius => {
            let frame = frame(model, &t.position)?;
            Some(Surface::Torus { frame, major: t.major_radius, minor: t.minor_radius })
        }
        _ => None,
    };
    match surface {
        Some(s) => Some((s, true)),
        None => {
            let surface = match face.to_nurbs() {
                Some(n) => nurbs(n)?,
                None => offset(&face.surface())?,
            };
            Some(Surface::Nurbs(surface).in_order())
        }
    }
}

fn nurbs(n: step_io::scene::NurbsSurface) -> Option<NurbsSurface> {
    let points: Vec<DVec3> = n.control_points.iter().flatten().map(|p| vec3(*p)).collect();
    let weights: Vec<f64> = n.weights.iter().flatten().copied().collect();
    NurbsSurface::new([n.degree_u, n.degree_v], [n.knots_u, n.knots_v], &points, &weights)
}

/// An offset of a free-form surface, fitted; those of planes and quadrics are read as what they are.
fn offset(surface: &step_io::scene::Surface<'_>) -> Option<NurbsSurface> {
    /// How far the fit may be off, in extents of the surface: files carry six to eight digits.
    const FIT: f64 = 1e-7;
    /// Offsets of offsets of ...
    const DEPTH: usize = 4;
    let mut basis = *surface;
    let mut distance = 0.0;
    for _ in 0..DEPTH {
        let SurfaceKind::Offset(o) = basis.kind() else { break };
        distance += o.distance;
        basis = basis.basis_surface()?;
    }
    let of = nurbs(basis.to_nurbs()?)?;
    let at = |p: &glam::DVec4| p.truncate() / p.w;
    let (lo, hi) = of
        .points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(at(p)), hi.max(at(p))));
    of.offset(distance, FIT * (lo.distance(hi) + distance.abs()))
}
