use super::*;
use crate::geometry::{Frame, Motion};
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
    let merged = sew(&mut part, 1e-6).n_edges;
    assert_eq!(merged, whole.edges.len());
    assert!(is_closed(&part));
}

/// Every edge in use has two faces that run along it in opposite ways.
fn is_closed(model: &Model) -> bool {
    model.edge_uses().iter().all(|u| u.is_empty() || (u.len() == 2 && u[0].1.forward != u[1].1.forward))
}

/// The model with edge `i` in two parts, of which the first is this share.
fn in_two(mut model: Model, i: usize, share: f64) -> Model {
    let whole = model.edges[i].clone();
    let middle = whole.parameter(share);
    let v = model.add_vertex(whole.at(share).point);
    model.edges[i] = Edge { range: [whole.range[0], middle], ends: [whole.ends[0], v], ..whole.clone() };
    let second = model.add_edge(Edge { range: [middle, whole.range[1]], ends: [v, whole.ends[1]], ..whole });
    for l in model.faces.iter_mut().flat_map(|f| &mut f.loops) {
        if let Some(k) = l.uses.iter().position(|u| u.edge == i) {
            let forward = l.uses[k].forward;
            l.uses.insert(k + usize::from(forward), EdgeUse { edge: second, forward });
        }
    }
    model
}

#[test]
fn edges_are_cut_where_those_of_neighbours_end() {
    let whole = plate();
    let part = torn(&whole);
    // Each edge in turn, straight ones and full circles.
    for i in 0..part.edges.len() {
        let mut part = in_two(part.clone(), i, 0.5);
        let sewn = sew(&mut part, 1e-6);
        assert_eq!((sewn.n_cuts, sewn.n_edges), (1, whole.edges.len() + 1), "edge {i}");
        assert!(is_closed(&part), "edge {i}");
        let mesh = crate::mesh_model(&part, &crate::ModelOptions::default());
        assert!(mesh.failures.is_empty(), "edge {i}: {:?}", mesh.failures);
        assert_eq!(mesh.n_free_sides, 0, "edge {i}");
    }
}

#[test]
fn points_of_the_tolerance_leave_their_loops() {
    // A side a tenth of the tolerance long.
    let whole = plate();
    let mut m = in_two(whole.clone(), 0, 1e-7 / whole.edges[0].length());
    let n: usize = m.faces.iter().flat_map(|f| &f.loops).map(|l| l.uses.len()).sum();
    sew(&mut m, 1e-6);
    assert_eq!(m.faces.iter().flat_map(|f| &f.loops).map(|l| l.uses.len()).sum::<usize>(), n - 2);
    assert!(is_closed(&m));
}

#[test]
fn slivers_are_left_out_and_their_neighbours_meet() {
    // Three rectangles in a row, the one in the middle 1e-4 wide.
    let mut m = Model::default();
    let x = [0.0, 1.0, 1.0001, 2.0];
    let at = |m: &mut Model, k: usize, y: f64| m.add_vertex(DVec3::new(x[k], y, 0.0));
    for k in 0..3 {
        let corners =
            [at(&mut m, k, 0.0), at(&mut m, k + 1, 0.0), at(&mut m, k + 1, 1.0), at(&mut m, k, 1.0)];
        let uses = (0..4)
            .map(|i| EdgeUse {
                edge: m.add_line(corners[i], corners[(i + 1) % 4]).expect("two points"),
                forward: true,
            })
            .collect();
        let shape = FaceShape::Surface(Surface::Plane(Frame::WORLD), true);
        m.add_face(Face {
            name: String::new(),
            shape,
            loops: vec![Loop { uses, vertex: None }],
            color: None,
        });
    }
    m.bodies.push(Body { name: "row".into(), faces: vec![0, 1, 2], solid: false });
    let mut fine = m.clone();
    assert!(sew(&mut fine, 1e-6).slivers.is_empty());
    assert_eq!((fine.faces.len(), fine.free_edges().count()), (3, 8));
    let sewn = sew(&mut m, 1e-3);
    assert_eq!(sewn.slivers, ["face2"]);
    assert_eq!((m.faces.len(), m.free_edges().count()), (2, 6));
    assert_eq!(m.bodies[0].faces, [0, 1]);
}

#[test]
fn a_whole_sphere_is_no_sliver() {
    // Its seam is two edges with vertices of their own, as in IGES.
    let mut m = Model::default();
    let frame = Frame { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Z, z: -DVec3::Y };
    let uses = [true, false].map(|forward| {
        let ends = [m.add_vertex(-DVec3::Z), m.add_vertex(DVec3::Z)];
        let curve = Curve::circle(frame, 1.0);
        let range = [-FRAC_PI_2, FRAC_PI_2];
        EdgeUse {
            edge: m.add_edge(Edge { name: String::new(), curve, range, ends, tolerance: 0.0 }),
            forward,
        }
    });
    let shape = FaceShape::Surface(Surface::Sphere { frame: Frame::WORLD, radius: 1.0 }, true);
    let l = Loop { uses: uses.to_vec(), vertex: None };
    m.add_face(Face { name: String::new(), shape, loops: vec![l], color: None });
    let sewn = sew(&mut m, 1e-6);
    assert_eq!((sewn.n_edges, sewn.slivers.len(), m.faces.len()), (1, 0, 1));
    let mesh = crate::mesh_model(&m, &crate::ModelOptions::default());
    assert!(mesh.failures.is_empty() && mesh.n_free_sides == 0, "{:?}", mesh.failures);
}

#[test]
fn what_a_wider_tolerance_closes_is_sewn_by_it() {
    let whole = plate();
    let mut part = torn(&whole);
    let off = 3e-6 * whole.diagonal();
    let motion = Motion { to: Frame { origin: DVec3::splat(off), ..Frame::WORLD } };
    for u in part.faces[0].loops.iter().flat_map(|l| &l.uses) {
        let e = &mut part.edges[u.edge];
        e.curve = e.curve.moved(&motion);
        for (k, v) in e.ends.into_iter().enumerate() {
            part.vertices[v].point = e.at(k as f64).point;
        }
    }
    let mut sheet = part.clone();
    let sewn = sew_closed(&mut part);
    assert!(is_closed(&part) && sewn.tolerance > off, "{sewn:?}");
    // With another face missing nothing closes it.
    sheet.faces.pop();
    let sewn = sew_closed(&mut sheet);
    assert!(sewn.tolerance < off && sheet.free_edges().count() > 4, "{sewn:?}");
}

/// The model with faces turned round.
fn turned(mut model: Model, which: impl Fn(usize) -> bool) -> Model {
    for (_, face) in model.faces.iter_mut().enumerate().filter(|(f, _)| which(*f)) {
        let FaceShape::Surface(_, forward) = &mut face.shape else { panic!("a surface") };
        *forward = !*forward;
        for l in &mut face.loops {
            l.uses.reverse();
            l.uses.iter_mut().for_each(|u| u.forward = !u.forward);
        }
    }
    model
}

#[test]
fn faces_are_turned_to_agree() {
    let whole = plate();
    let n = whole.faces.len();
    for which in [0b1_u32, 0b10, 0b101, 0b11_1110, (1 << n) - 2] {
        let mut part = turned(torn(&whole), |f| which >> f & 1 == 1);
        sew(&mut part, 1e-6);
        // As it was drawn, outside out, however many are the other way round.
        assert_eq!(turn_alike(&mut part), which.count_ones() as usize, "{which:b}");
        assert!(is_closed(&part), "{which:b}");
        let shapes = |m: &Model| m.faces.iter().map(|f| f.shape.clone()).collect::<Vec<_>>();
        assert_eq!(shapes(&part), shapes(&whole), "{which:b}");
        assert_eq!(turn_alike(&mut part), 0);
    }
    // Of an open one the fewer are turned.
    let mut open = turned(whole, |f| f > 1);
    open.faces.pop();
    assert_eq!(turn_alike(&mut open), 2);
}

#[test]
fn models_of_facets_are_left_alone() {
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let mut m =
        crate::facets::model_of_triangles(&points, &triangles, &crate::facets::FacetOptions::default());
    let before = m.clone();
    assert_eq!(sew(&mut m, 10.0), Sewn { tolerance: 10.0, ..Sewn::default() });
    assert_eq!((m.faces.len(), m == before), (4, true));
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
    assert_eq!(sew(&mut m, 1e-6), Sewn { tolerance: 1e-6, ..Sewn::default() });
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
