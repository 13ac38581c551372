//! Whole parts, made by code, to conforming meshes.

use csalf_geom::{QuadId, VertexId};
use csalf_model::brep::{FaceShape, Model};
use csalf_model::geometry::{Frame, Inverter, Surface};
use csalf_model::shapes::{
    Piece, circle, closed_surface, cone, extrude, half_sphere, panel, rectangle, sheet,
};
use csalf_model::{LayerSpec, ModelMesh, ModelOptions, Shapes, SizeRules, check_and_snap, mesh_model};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

fn options(size: f64) -> ModelOptions {
    ModelOptions { size: Some(SizeRules::of(size)), ..ModelOptions::default() }
}

/// Volume inside a closed mesh, by the divergence theorem on the triangles of each quad round its centre.
fn volume(m: &ModelMesh) -> f64 {
    (0..m.mesh.quads.len())
        .map(|q| {
            let p = m.mesh.corners(QuadId(q as u32));
            let c = (p[0] + p[1] + p[2] + p[3]) * 0.25;
            (0..4).map(|k| c.dot(p[k].cross(p[(k + 1) % 4])) / 6.0).sum::<f64>()
        })
        .sum()
}

/// Every node on the surface of its face, every corner convex seen along the face's normal.
fn check(model: &Model, m: &ModelMesh, least_sj: f64) {
    assert!(m.failures.is_empty(), "{:?}", m.failures);
    assert_eq!(m.n_branching_sides, 0);
    let diagonal = model.diagonal();
    for (q, f) in m.face_of_quad.iter().enumerate() {
        let FaceShape::Surface(surface, forward) = &model.faces[*f as usize].shape else { continue };
        let inverter = Inverter::new(surface);
        let p = m.mesh.corners(QuadId(q as u32));
        let centre = (p[0] + p[1] + p[2] + p[3]) * 0.25;
        let (uv, _) = inverter.invert(centre, None, 0.0);
        let n = surface.eval(uv).normal() * if *forward { 1.0 } else { -1.0 };
        for k in 0..4 {
            let (_, d) = inverter.invert(p[k], None, 0.0);
            assert!(d <= 1e-6 * diagonal, "a node of {} is {d} off", model.faces[*f as usize].name);
            let (a, b) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
            let sj = a.cross(b).dot(n) / (a.length() * b.length());
            assert!(sj >= least_sj, "{}: {sj} at {}", model.faces[*f as usize].name, p[k]);
        }
    }
}

#[test]
fn a_box_is_watertight() {
    let mut part = extrude(&[rectangle(4.0, 3.0)], 2.0);
    let report = check_and_snap(&mut part);
    assert!(report.messages.is_empty(), "{:?}", report.messages);
    let m = mesh_model(&part, &options(0.5));
    check(&part, &m, 0.99);
    assert_eq!(m.n_free_sides, 0);
    assert!((volume(&m) - 24.0).abs() < 1e-9, "{}", volume(&m));
    assert_eq!(m.mesh.quads.len(), 2 * (8 * 6 + 8 * 4 + 6 * 4));
}

#[test]
fn a_plate_with_holes_has_rings_and_inside_bores() {
    let hole = |x: f64, y: f64, r: f64| vec![circle(DVec2::new(x, y), r).reversed()];
    let part = extrude(&[rectangle(40.0, 20.0), hole(10.0, 10.0, 4.0), hole(30.0, 10.0, 2.0)], 3.0);
    let mut o = options(1.5);
    o.layers = vec![("hole<5".into(), LayerSpec { count: 2, ..LayerSpec::default() })];
    let m = mesh_model(&part, &o);
    check(&part, &m, 0.2);
    assert_eq!(m.n_free_sides, 0);
    let exact = 3.0 * (800.0 - PI * (16.0 + 4.0));
    assert!((volume(&m) / exact - 1.0).abs() < 0.01, "{} {exact}", volume(&m));
    // The small hole, at the bottom and at the top.
    assert_eq!(m.layers.len(), 2, "{:?}", m.layers);
    assert!(m.layers.iter().all(|l| l.made == 2), "{:?}", m.layers);
}

#[test]
fn a_cylinder_a_half_sphere_and_a_cone_close() {
    let disk = extrude(&[vec![circle(DVec2::ZERO, 2.0)]], 5.0);
    for (part, exact, least) in [
        (disk, PI * 4.0 * 5.0, 0.2),
        (half_sphere(2.0), PI * 16.0 / 3.0, 0.2),
        (cone(2.0, 3.0), PI * 4.0, 0.1),
    ] {
        let m = mesh_model(&part, &options(0.5));
        check(&part, &m, least);
        assert_eq!(m.n_free_sides, 0, "{}", part.name);
        assert!((volume(&m) / exact - 1.0).abs() < 0.04, "{}: {} {exact}", part.name, volume(&m));
    }
}

#[test]
fn closed_surfaces_without_edges() {
    let frame = Frame::new(DVec3::new(1.0, 2.0, 3.0), DVec3::ONE, DVec3::X);
    let sphere = closed_surface(Surface::Sphere { frame, radius: 2.0 });
    let torus = closed_surface(Surface::Torus { frame, major: 3.0, minor: 1.0 });
    for (part, exact) in [(sphere, PI * 32.0 / 3.0), (torus, 2.0 * PI * PI * 3.0)] {
        let m = mesh_model(&part, &options(0.3));
        check(&part, &m, 0.7);
        assert_eq!(m.n_free_sides, 0);
        assert!((volume(&m) / exact - 1.0).abs() < 0.02, "{} {exact}", volume(&m));
    }
}

/// Sides of a bored plate: on the rims and walls of the bore their middles are as far from its axis as the vertices, and
/// on planes nothing is said of them. Of a torus and a free-form bump all middles and centres lie on the surface.
#[test]
fn middles_of_sides_lie_on_curves_and_surfaces() {
    let hole = vec![circle(DVec2::new(10.0, 10.0), 4.0).reversed()];
    let part = extrude(&[rectangle(20.0, 20.0), hole], 3.0);
    let m = mesh_model(&part, &options(1.5));
    let radius = |p: DVec3| p.truncate().distance(DVec2::splat(10.0));
    let middles = Shapes::new(&part).middles(&m);
    assert!(middles.windows(2).all(|w| w[0].0 < w[1].0), "each side once, in order");
    let at = |v: VertexId| m.mesh.points[v.index()];
    let mut of_bore: Vec<[VertexId; 2]> = m
        .mesh
        .quads
        .iter()
        .flat_map(|q| (0..4).map(|k| [q[k].min(q[(k + 1) & 3]), q[k].max(q[(k + 1) & 3])]))
        .filter(|s| s.iter().all(|&v| (radius(at(v)) - 4.0).abs() < 1e-9))
        .collect();
    of_bore.sort_unstable();
    of_bore.dedup();
    assert_eq!(middles.iter().map(|x| x.0).collect::<Vec<_>>(), of_bore);
    for ([a, b], p) in &middles {
        let chord = at(*a).distance(at(*b));
        assert!((radius(*p) - 4.0).abs() < 1e-9 && p.distance(at(*a).midpoint(at(*b))) < 0.2 * chord, "{p}");
    }
    assert!(middles.iter().any(|([a, b], p)| p.distance(at(*a).midpoint(at(*b))) > 0.01));

    let frame = Frame::new(DVec3::new(1.0, 2.0, 3.0), DVec3::ONE, DVec3::X);
    let torus = Surface::Torus { frame, major: 3.0, minor: 1.0 };
    let part = closed_surface(torus.clone());
    let m = mesh_model(&part, &options(0.6));
    let shapes = Shapes::new(&part);
    let middles = shapes.middles(&m);
    assert_eq!(middles.len(), 2 * m.mesh.quads.len(), "all sides of a closed mesh");
    let inverter = Inverter::new(&torus);
    let off = |p: DVec3| inverter.invert(p, None, 0.0).1;
    let chord = |[a, b]: [VertexId; 2]| m.mesh.points[a.index()].midpoint(m.mesh.points[b.index()]);
    assert!(middles.iter().all(|(_, p)| off(*p) < 1e-12));
    assert!(middles.iter().filter(|(s, _)| off(chord(*s)) > 1e-3).count() > m.mesh.quads.len());
    for q in 0..m.mesh.quads.len() {
        let p = m.mesh.corners(QuadId(q as u32)).iter().sum::<DVec3>() * 0.25;
        assert!(off(shapes.centre(&m, q, p)) < 1e-12 && off(p) > 1e-4);
    }
}

#[test]
fn a_hat_section_is_one_sheet() {
    let p = DVec2::new;
    let r = 2.0;
    let chain = [
        Piece::Line(p(0.0, 0.0), p(10.0, 0.0)),
        Piece::Arc(p(10.0, r), r, -FRAC_PI_2, 0.0),
        Piece::Line(p(12.0, r), p(12.0, 12.0)),
        Piece::Arc(p(14.0, 12.0), r, PI, FRAC_PI_2),
        Piece::Line(p(14.0, 14.0), p(30.0, 14.0)),
    ];
    let part = sheet(&chain, 40.0);
    let m = mesh_model(&part, &options(2.0));
    check(&part, &m, 0.5);
    // The rim: twice the chain and two ends.
    assert!(m.n_free_sides > 0);
    let on_rim: usize = m
        .sets
        .edges
        .iter()
        .filter(|(n, _)| !["up1", "up2", "up3", "up4"].contains(&n.as_str()))
        .map(|e| e.1.len())
        .sum();
    assert_eq!(m.n_free_sides, on_rim);
}

#[test]
fn a_panel_is_one_sheet() {
    let mut part = panel(9, 3);
    let report = check_and_snap(&mut part);
    assert!(report.messages.is_empty(), "{:?}", report.messages);
    assert_eq!(part.faces.len(), 27);
    let m = mesh_model(&part, &options(1.0));
    check(&part, &m, 0.4);
    let free: usize = part
        .edge_uses()
        .iter()
        .zip(&part.edges)
        .filter(|(u, _)| u.len() == 1)
        .filter_map(|(_, e)| m.sets.edges.iter().find(|s| s.0 == e.name))
        .map(|s| s.1.len())
        .sum();
    assert_eq!(m.n_free_sides, free);
    assert_eq!(csalf_model::brep::loop_features(&part).len(), 9);
}

#[test]
fn the_mesh_is_the_same_bits_whatever_the_threads() {
    let part = extrude(&[rectangle(40.0, 20.0), vec![circle(DVec2::new(20.0, 10.0), 4.0).reversed()]], 3.0);
    let run = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("a pool");
        pool.install(|| mesh_model(&part, &options(1.5)).mesh)
    };
    assert!(run(1) == run(2));
}

#[test]
fn weld_spots_become_nodes_of_their_face() {
    let part = extrude(&[rectangle(40.0, 20.0), vec![circle(DVec2::new(20.0, 10.0), 4.0).reversed()]], 3.0);
    let mut o = options(2.0);
    o.points =
        vec![("spot1".into(), DVec3::new(7.3, 6.1, 3.05)), ("spot2".into(), DVec3::new(33.0, 12.0, -0.01))];
    let m = mesh_model(&part, &o);
    check(&part, &m, 0.1);
    let at = |name: &str| {
        let (_, nodes) = m.sets.nodes.iter().find(|(n, _)| n == name).expect("the set");
        m.mesh.points[nodes[0].index()]
    };
    assert_eq!((at("spot1"), at("spot2")), (DVec3::new(7.3, 6.1, 3.0), DVec3::new(33.0, 12.0, 0.0)));
    assert_eq!(m.n_free_sides, 0);
}
