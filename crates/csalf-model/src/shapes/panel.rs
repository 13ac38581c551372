//! A corrugated panel: as many faces as one likes, all edges inside shared by two.
//!
//! ```text
//!        ╭────────╮              ╭──        in section: flats, quarter turns and webs, eight pieces per period;
//!        │  ( )   │   ( )        │          along z in bays; holes in the flats of every bay
//!     ───╯        ╰──────────────╯
//! ```

use super::{Piece, circle, straight};
use crate::brep::{Body, Edge, EdgeIndex, EdgeUse, Face, FaceShape, Loop, Model, VertexIndex};
use crate::geometry::{Curve, Frame, Surface};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Width of the flats, height of the webs, radius of the turns, length of a bay, radius of the holes.
const FLAT: f64 = 10.0;
const WEB: f64 = 6.0;
const TURN: f64 = 2.0;
const BAY: f64 = 10.0;
const HOLE: f64 = 2.5;

/// A panel of `pieces` by `bays` faces, named `faceI_J`; two in eight have a hole. About 10 by 10 in size each; the middle
/// of the panel is not the origin.
pub fn panel(pieces: usize, bays: usize) -> Model {
    let mut m = Model { name: "panel".into(), ..Model::default() };
    let section = section(pieces);
    let lift = |p: DVec2, z: f64| p.extend(z);
    let z = |j: usize| BAY * j as f64;
    let mut posts: Vec<Vec<VertexIndex>> = Vec::new();
    for i in 0..=pieces {
        let p = if i < pieces { section[i].ends()[0] } else { section[pieces - 1].ends()[1] };
        posts.push((0..=bays).map(|j| m.add_vertex(lift(p, z(j)))).collect());
    }
    let name = |what: &str, i: usize, j: usize| format!("{what}{i}_{j}");
    let mut across: Vec<Vec<EdgeIndex>> = Vec::new();
    for (i, piece) in section.iter().enumerate() {
        let edge = |j: usize, m: &mut Model| {
            let ends = [posts[i][j], posts[i + 1][j]];
            let (curve, range) = match *piece {
                Piece::Line(..) => straight(m, ends[0], ends[1]),
                Piece::Arc(c, r, a, b) => {
                    (Curve::circle(Frame::new(lift(c, z(j)), DVec3::Z, DVec3::X), r), [a, b])
                }
            };
            m.add_edge(Edge { name: name("across", i, j), curve, range, ends, tolerance: 0.0 })
        };
        across.push((0..=bays).map(|j| edge(j, &mut m)).collect());
    }
    let mut along: Vec<Vec<EdgeIndex>> = Vec::new();
    for (i, post) in posts.iter().enumerate() {
        let edge = |j: usize, m: &mut Model| {
            let ends = [post[j], post[j + 1]];
            let (curve, range) = straight(m, ends[0], ends[1]);
            m.add_edge(Edge { name: name("along", i, j), curve, range, ends, tolerance: 0.0 })
        };
        along.push((0..bays).map(|j| edge(j, &mut m)).collect());
    }
    let mut faces = Vec::new();
    for (i, piece) in section.iter().enumerate() {
        for j in 0..bays {
            let on = |edge: EdgeIndex, forward: bool| EdgeUse { edge, forward };
            let uses = vec![
                on(across[i][j], true),
                on(along[i + 1][j], true),
                on(across[i][j + 1], false),
                on(along[i][j], false),
            ];
            let mut loops = vec![Loop { uses, vertex: None }];
            let surface = match *piece {
                Piece::Line(a, b) => {
                    let d = b - a;
                    let normal = DVec3::new(d.y, -d.x, 0.0);
                    // The flats, not the webs.
                    if d.y == 0.0 {
                        let middle = lift((a + b) * 0.5, z(j) + 0.5 * BAY);
                        loops.push(hole(&mut m, middle, normal, d.extend(0.0), &name("hole", i, j)));
                    }
                    FaceShape::Surface(Surface::Plane(Frame::new(lift(a, 0.0), normal, d.extend(0.0))), true)
                }
                Piece::Arc(c, r, a, b) => {
                    let frame = Frame::new(lift(c, 0.0), DVec3::Z, DVec3::X);
                    FaceShape::Surface(Surface::Cylinder { frame, radius: r }, a < b)
                }
            };
            faces.push(m.add_face(Face { name: name("face", i, j), shape: surface, loops, color: None }));
        }
    }
    m.bodies.push(Body { name: "panel".into(), faces, solid: false });
    m
}

/// A circle that runs clockwise seen against the normal.
fn hole(m: &mut Model, middle: DVec3, normal: DVec3, x: DVec3, name: &str) -> Loop {
    let frame = Frame::new(middle, normal, x);
    let Piece::Arc(_, r, a, b) = circle(DVec2::ZERO, HOLE) else { return Loop::default() };
    let v = m.add_vertex(frame.point(r, 0.0, 0.0));
    let curve = Curve::circle(frame, r);
    let edge = m.add_edge(Edge { name: name.to_owned(), curve, range: [a, b], ends: [v, v], tolerance: 0.0 });
    Loop { uses: vec![EdgeUse { edge, forward: false }], vertex: None }
}

/// The pieces of the section.
fn section(n: usize) -> Vec<Piece> {
    let mut at = DVec2::ZERO;
    let mut out = Vec::with_capacity(n);
    let (x, y) = (DVec2::X, DVec2::Y);
    for k in 0..n {
        let piece = match k % 8 {
            0 | 4 => Piece::Line(at, at + x * FLAT),
            1 => Piece::Arc(at + y * TURN, TURN, -FRAC_PI_2, 0.0),
            2 => Piece::Line(at, at + y * WEB),
            3 => Piece::Arc(at + x * TURN, TURN, PI, FRAC_PI_2),
            5 => Piece::Arc(at - y * TURN, TURN, FRAC_PI_2, 0.0),
            6 => Piece::Line(at, at - y * WEB),
            _ => Piece::Arc(at + x * TURN, TURN, PI, 3.0 * FRAC_PI_2),
        };
        at = piece.ends()[1];
        out.push(piece);
    }
    out
}
