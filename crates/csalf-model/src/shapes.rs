//! Models made by code: what tests, benches and examples mesh without a file.
//!
//! ```text
//!   extrude   loops of lines and arcs, two caps and a wall per curve      box, plate with holes, cylinder, tube
//!   sheet     an open chain of lines and arcs, no caps                    hat section, bent flange
//!   panel     a corrugated sheet of as many faces as asked for, with holes
//! ```

mod panel;

pub use panel::panel;

use crate::brep::{Body, Edge, EdgeIndex, EdgeUse, Face, FaceShape, Loop, Model, VertexIndex};
use crate::geometry::{Curve, Frame, Surface};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A piece of a flat outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A straight line.
    Line(DVec2, DVec2),
    /// An arc: centre, radius, angles at start and end in radians; clockwise if the second is smaller.
    Arc(DVec2, f64, f64, f64),
}

impl Piece {
    fn ends(&self) -> [DVec2; 2] {
        match *self {
            Self::Line(a, b) => [a, b],
            Self::Arc(c, r, a, b) => [a, b].map(|t| c + DVec2::from_angle(t) * r),
        }
    }

    fn is_closed(&self) -> bool {
        /// A whole turn up to rounding, radians.
        const WHOLE: f64 = 1e-9;
        matches!(*self, Self::Arc(_, _, a, b) if ((a - b).abs() - TAU).abs() < WHOLE)
    }

    /// The same, the other way round.
    pub fn reversed(&self) -> Self {
        match *self {
            Self::Line(a, b) => Self::Line(b, a),
            Self::Arc(c, r, a, b) => Self::Arc(c, r, b, a),
        }
    }
}

/// The outline of a rectangle from the origin, counter-clockwise.
pub fn rectangle(width: f64, height: f64) -> Vec<Piece> {
    let p = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)].map(|(x, y)| DVec2::new(x, y));
    (0..4).map(|k| Piece::Line(p[k], p[(k + 1) % 4])).collect()
}

/// A full circle, counter-clockwise; as a hole, [`Piece::reversed`].
pub fn circle(center: DVec2, radius: f64) -> Piece {
    Piece::Arc(center, radius, 0.0, TAU)
}

/// A solid: outlines (material on their left) moved up by `height`. Faces are named `bottom`, `top`, `wallK_J` (loop K,
/// piece J); the edges `bottomK_J`, `topK_J`, `upK_J`.
pub fn extrude(outlines: &[Vec<Piece>], height: f64) -> Model {
    let mut m = Model { name: "extrusion".into(), ..Model::default() };
    let (mut bottom_loops, mut top_loops, mut walls) = (Vec::new(), Vec::new(), Vec::new());
    for (k, outline) in outlines.iter().enumerate() {
        let strip = strip(&mut m, outline, height, true, &format!("{k}_"));
        let forward = |e: &EdgeIndex| EdgeUse { edge: *e, forward: true };
        let backward = |e: &EdgeIndex| EdgeUse { edge: *e, forward: false };
        top_loops.push(Loop { uses: strip.high.iter().map(forward).collect(), vertex: None });
        bottom_loops.push(Loop { uses: strip.low.iter().rev().map(backward).collect(), vertex: None });
        walls.extend(strip.faces);
    }
    let plane = |z: f64| Surface::Plane(Frame::new(DVec3::Z * z, DVec3::Z, DVec3::X));
    let cap = |name: &str, z: f64, up: bool, loops: Vec<Loop>| Face {
        name: name.into(),
        shape: FaceShape::Surface(plane(z), up),
        loops,
        color: None,
    };
    let bottom = m.add_face(cap("bottom", 0.0, false, bottom_loops));
    let top = m.add_face(cap("top", height, true, top_loops));
    let faces = walls.into_iter().chain([bottom, top]).collect();
    m.bodies.push(Body { name: "body".into(), faces, solid: true });
    m
}

/// A sheet: an open chain of pieces moved up by `height`.
pub fn sheet(chain: &[Piece], height: f64) -> Model {
    let mut m = Model { name: "sheet".into(), ..Model::default() };
    let strip = strip(&mut m, chain, height, false, "");
    m.bodies.push(Body { name: "sheet".into(), faces: strip.faces, solid: false });
    m
}

struct Strip {
    low: Vec<EdgeIndex>,
    high: Vec<EdgeIndex>,
    faces: Vec<usize>,
}

/// The walls above a chain of pieces; outside is on the right of the pieces.
fn strip(m: &mut Model, pieces: &[Piece], height: f64, closed: bool, tag: &str) -> Strip {
    let lift = |p: DVec2, z: f64| p.extend(z);
    let n = pieces.len();
    let ring = closed && n == 1 && pieces[0].is_closed();
    let n_posts = if closed { n } else { n + 1 };
    let mut posts: Vec<[VertexIndex; 2]> = Vec::new();
    for k in 0..n_posts {
        let p = if k < n { pieces[k].ends()[0] } else { pieces[n - 1].ends()[1] };
        posts.push([0.0, height].map(|z| m.add_vertex(lift(p, z))));
    }
    let mut ups: Vec<EdgeIndex> = Vec::new();
    for (k, &[a, b]) in posts.iter().enumerate().filter(|_| !ring) {
        let (curve, range) = straight(m, a, b);
        ups.push(m.add_edge(Edge {
            name: format!("up{tag}{k}"),
            curve,
            range,
            ends: [a, b],
            tolerance: 0.0,
        }));
    }
    let mut out = Strip { low: Vec::new(), high: Vec::new(), faces: Vec::new() };
    for (k, piece) in pieces.iter().enumerate() {
        let next = (k + 1) % n_posts;
        let edge_at = |m: &mut Model, level: usize, name: &str| {
            let z = if level == 0 { 0.0 } else { height };
            let ends = [posts[k][level], posts[next][level]];
            let (curve, range) = match *piece {
                Piece::Line(..) => straight(m, ends[0], ends[1]),
                Piece::Arc(c, r, a, b) => {
                    (Curve::circle(Frame::new(lift(c, z), DVec3::Z, DVec3::X), r), [a, b])
                }
            };
            m.add_edge(Edge { name: format!("{name}{tag}{k}"), curve, range, ends, tolerance: 0.0 })
        };
        let (low, high) = (edge_at(m, 0, "bottom"), edge_at(m, 1, "top"));
        let (surface, forward) = match *piece {
            Piece::Line(a, b) => {
                let d = b - a;
                (Surface::Plane(Frame::new(lift(a, 0.0), DVec3::new(d.y, -d.x, 0.0), d.extend(0.0))), true)
            }
            Piece::Arc(c, r, a, b) => {
                (Surface::Cylinder { frame: Frame::new(lift(c, 0.0), DVec3::Z, DVec3::X), radius: r }, a < b)
            }
        };
        let on = |edge: EdgeIndex, forward: bool| EdgeUse { edge, forward };
        let loops = if ring {
            // Two circles, no seam.
            vec![
                Loop { uses: vec![on(low, true)], vertex: None },
                Loop { uses: vec![on(high, false)], vertex: None },
            ]
        } else {
            let uses = vec![on(low, true), on(ups[next], true), on(high, false), on(ups[k], false)];
            vec![Loop { uses, vertex: None }]
        };
        let shape = FaceShape::Surface(surface, forward);
        out.faces.push(m.add_face(Face { name: format!("wall{tag}{k}"), shape, loops, color: None }));
        out.low.push(low);
        out.high.push(high);
    }
    out
}

/// The line between two vertices; a dot of a line if they are one.
fn straight(m: &Model, a: VertexIndex, b: VertexIndex) -> (Curve, [f64; 2]) {
    let (p, q) = (m.vertices[a].point, m.vertices[b].point);
    Curve::segment(p, q).unwrap_or((Curve::Line { origin: p, direction: DVec3::X }, [0.0, 0.0]))
}

/// A whole sphere or torus: one face without edges.
pub fn closed_surface(surface: Surface) -> Model {
    let mut m = Model { name: surface.kind().into(), ..Model::default() };
    let shape = FaceShape::Surface(surface, true);
    let f = m.add_face(Face { name: "skin".into(), shape, loops: Vec::new(), color: None });
    m.bodies.push(Body { name: "body".into(), faces: vec![f], solid: true });
    m
}

/// A solid of revolution's end: half a sphere (`dome`) on a disk.
pub fn half_sphere(radius: f64) -> Model {
    capped("half sphere", radius, Surface::Sphere { frame: Frame::WORLD, radius })
}

/// A cone with its apex, on a disk of this radius.
pub fn cone(radius: f64, height: f64) -> Model {
    // Widening downwards: the axis points down, so that v = 0 is at the disk.
    let frame = Frame::new(DVec3::ZERO, -DVec3::Z, DVec3::X);
    capped("cone", radius, Surface::Cone { frame, radius, angle: (radius / height).atan() })
}

/// A face above the circle of this radius in the plane z = 0, and the disk below.
fn capped(name: &str, radius: f64, surface: Surface) -> Model {
    let mut m = Model { name: name.into(), ..Model::default() };
    let v = m.add_vertex(DVec3::X * radius);
    let rim = m.add_edge(Edge {
        name: "rim".into(),
        curve: Curve::circle(Frame::WORLD, radius),
        range: [0.0, TAU],
        ends: [v, v],
        tolerance: 0.0,
    });
    let on = |forward: bool| vec![Loop { uses: vec![EdgeUse { edge: rim, forward }], vertex: None }];
    let skin = FaceShape::Surface(surface, true);
    let disk = FaceShape::Surface(Surface::Plane(Frame::WORLD), false);
    let a = m.add_face(Face { name: "skin".into(), shape: skin, loops: on(true), color: None });
    let b = m.add_face(Face { name: "disk".into(), shape: disk, loops: on(false), color: None });
    m.bodies.push(Body { name: "body".into(), faces: vec![a, b], solid: true });
    m
}
