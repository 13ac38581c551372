use super::*;
use crate::geometry::Frame;
use crate::shapes::{Piece, circle, extrude, rectangle};
use glam::DVec2;
use std::f64::consts::{FRAC_PI_2, PI};

/// The model with edges and vertices of its own for each face, as IGES files have them.
fn torn(model: &Model) -> Model {
    let mut out = model.clone();
    (out.edges, out.vertices) = (Vec::new(), Vec::new());
    for face in &mut out.faces {
        for u in face.loops.iter_mut().flat_map(|l| &mut l.uses) {
            let mut e = model.edges[u.edge].clone();
            e.ends = e.ends.map(|v| {
                out.vertices.push(model.vertices[v]);
                out.vertices.len() - 1
            });
            out.edges.push(e);
            u.edge = out.edges.len() - 1;
        }
    }
    out
}

fn plate() -> Model {
    extrude(&[rectangle(4.0, 3.0), vec![circle(DVec2::new(2.0, 1.5), 0.5).reversed()]], 1.0)
}

#[test]
fn torn_edges_are_sewn() {
    let whole = plate();
    let mut part = torn(&whole);
    assert_eq!(part.edges.len(), 2 * whole.edges.len());
    let merged = sew(&mut part, 1e-6);
    assert_eq!(merged, whole.edges.len());
    let uses = part.edge_uses();
    assert!(uses.iter().all(|u| u.is_empty() || (u.len() == 2 && u[0].1.forward != u[1].1.forward)));
}

#[test]
fn different_courses_are_not_sewn() {
    // Two half circles between the same two points, and the chord.
    let mut m = Model::default();
    let (a, b) = (m.add_vertex(DVec3::X), m.add_vertex(-DVec3::X));
    let arc = |range| Edge {
        name: String::new(),
        curve: Curve::circle(Frame::WORLD, 1.0),
        range,
        ends: [a, b],
        tolerance: 0.0,
    };
    let edges = [m.add_edge(arc([0.0, PI])), m.add_edge(arc([0.0, -PI]))];
    let chord = m.add_line(a, b).expect("two points");
    let loops = [(edges[0], chord), (edges[1], chord)].map(|(e, f)| Loop {
        uses: vec![EdgeUse { edge: e, forward: true }, EdgeUse { edge: f, forward: false }],
        vertex: None,
    });
    for l in loops {
        let shape = FaceShape::Surface(Surface::Plane(Frame::WORLD), true);
        m.add_face(Face { name: String::new(), shape, loops: vec![l], color: None });
    }
    assert_eq!(sew(&mut m, 1e-6), 0);
}

#[test]
fn checks_find_gaps_and_order_loops() {
    let mut m = plate();
    assert!(check_and_snap(&mut m).messages.is_empty());
    m.faces[0].loops[0].uses.swap(1, 2);
    let report = check_and_snap(&mut m);
    assert_eq!(report.messages.len(), 1, "{:?}", report.messages);
    m.vertices[0].point.x += 0.01;
    let report = check_and_snap(&mut m);
    assert!(report.end_gap > 0.009 && !report.messages.is_empty());
    // Nonsense is no panic.
    m.edges[0].range = [f64::NAN, 1.0];
    m.edges[1].ends = [999, 0];
    let n = m.faces.len();
    check_and_snap(&mut m);
    assert_eq!(m.faces.len(), n);
}

#[test]
fn circles_and_slots_are_holes() {
    let p = DVec2::new;
    let slot = vec![
        Piece::Arc(p(6.0, 2.0), 0.5, FRAC_PI_2, -FRAC_PI_2),
        Piece::Line(p(6.0, 1.5), p(4.0, 1.5)),
        Piece::Arc(p(4.0, 2.0), 0.5, 3.0 * FRAC_PI_2, FRAC_PI_2),
        Piece::Line(p(4.0, 2.5), p(6.0, 2.5)),
    ];
    let square: Vec<Piece> = rectangle(1.0, 1.0)
        .iter()
        .rev()
        .map(|q| match q.reversed() {
            Piece::Line(a, b) => Piece::Line(a + p(8.0, 1.0), b + p(8.0, 1.0)),
            arc => arc,
        })
        .collect();
    let m = extrude(&[rectangle(10.0, 4.0), vec![circle(p(2.0, 2.0), 1.0).reversed()], slot, square], 1.0);
    let found = loop_features(&m);
    assert_eq!(found.len(), 4, "{found:?}");
    assert_eq!(found[0].shape, HoleShape::Circle { diameter: 2.0 });
    let HoleShape::Slot { width, length } = found[1].shape else { panic!("{:?}", found[1]) };
    assert!((width - 1.0).abs() < 1e-12 && (length - 3.0).abs() < 1e-12);
    assert!(found[1].center.distance(DVec3::new(5.0, 2.0, 0.0)) < 1e-12);
}
