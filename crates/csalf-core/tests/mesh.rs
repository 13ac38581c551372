//! The pipeline on small domains made by code.

use csalf_core::{Job, MeshError, Meshed, Method, Options, mesh};
use csalf_geom::{Domain, Point2};
use csalf_mesh::QuadTopology;
use csalf_mesh::validate::{Expectation, validate};
use csalf_pave::{LayerLaw, LayerSpec};
use csalf_sizemap::SizeSpec;

fn ring(c: (f64, f64), r: f64, n: usize) -> Vec<Point2> {
    (0..n)
        .map(|i| std::f64::consts::TAU * i as f64 / n as f64)
        .map(|t| Point2::new(c.0 + r * t.cos(), c.1 + r * t.sin()))
        .collect()
}

fn rectangle(w: f64, h: f64, nx: usize, ny: usize) -> Vec<Point2> {
    let (dx, dy) = (w / nx as f64, h / ny as f64);
    let mut p = Vec::new();
    p.extend((0..nx).map(|i| Point2::new(i as f64 * dx, 0.0)));
    p.extend((0..ny).map(|i| Point2::new(w, i as f64 * dy)));
    p.extend((0..nx).map(|i| Point2::new(w - i as f64 * dx, h)));
    p.extend((0..ny).map(|i| Point2::new(0.0, h - i as f64 * dy)));
    p
}

fn run(job: &Job, options: &Options) -> Meshed {
    let m = mesh(job, options).expect("the domain is valid");
    let set = |name: &str| m.sets.edges.iter().find(|s| s.0 == name).map(|s| s.1.clone()).unwrap_or_default();
    let boundary: Vec<_> = job.domain.loops.iter().flat_map(|l| set(&l.name)).collect();
    let scars: Vec<_> = job.domain.scars.iter().flat_map(|s| set(&s.name)).collect();
    let nodes: Vec<Point2> = job.domain.loops.iter().flat_map(|l| l.nodes.iter().copied()).collect();
    let points: Vec<_> = m.sets.nodes.iter().filter(|s| s.0.starts_with("point")).map(|s| s.1[0]).collect();
    let expected =
        Expectation { nodes: &nodes, boundary: &boundary, scars: &scars, points: &points, area: 0.0 };
    assert_eq!(validate(&m.mesh, &expected), [], "the mesh is valid");
    m
}

fn job(domain: Domain, h: f64) -> Job {
    Job { domain, size: SizeSpec::Uniform { h }, ..Job::default() }
}

fn plate() -> Domain {
    Domain::new(rectangle(10.0, 8.0, 20, 16)).with_hole(ring((5.0, 4.0), 1.5, 24))
}

#[test]
fn a_square_is_a_grid() {
    let m = run(&job(Domain::new(rectangle(1.0, 1.0, 12, 12)), 1.0 / 12.0), &Options::default());
    assert_eq!(m.mesh.n_quads(), 144);
    assert_eq!(m.mesh.n_vertices(), 169);
}

#[test]
fn all_methods_mesh_a_plate_with_everything() {
    let domain = plate()
        .with_scar(vec![Point2::new(7.5, 2.0), Point2::new(8.0, 2.3), Point2::new(8.5, 2.5)])
        .with_point(Point2::new(2.0, 2.0))
        .with_point(Point2::new(2.0, 6.1));
    for method in [Method::Csalf, Method::Paper, Method::Tqm] {
        let m = run(&job(domain.clone(), 0.5), &Options { method, ..Options::default() });
        assert!(m.mesh.triangles.is_empty());
        assert!(m.report.members.iter().any(|&(_, n)| n > 0), "{method:?} used a member");
    }
}

#[test]
fn threads_do_not_change_the_mesh() {
    let job = job(plate(), 0.2);
    let one = run(&job, &Options { threads: 1, ..Options::default() });
    for threads in [2, 4] {
        let many = run(&job, &Options { threads, ..Options::default() });
        assert_eq!(one.mesh, many.mesh, "{threads} threads");
    }
}

#[test]
fn asked_layers_are_made_and_keep_their_thickness() {
    let spec = LayerSpec { count: 3, law: LayerLaw::Constant, first: Some(0.25) };
    let job = Job { layers: vec![("hole*".into(), spec)], ..job(plate(), 0.5) };
    let m = run(&job, &Options::default());
    let hole = m.report.loops.iter().find(|l| l.name == "hole0").expect("reported");
    assert_eq!((hole.asked, hole.made), (3, 3), "{hole:?}");
    let second = &m.sets.quads.iter().find(|s| s.0 == "hole0_layer2").expect("named").1;
    assert_eq!(second.len(), 24);
    for &q in second {
        for p in m.mesh.corners(q) {
            let r = p.distance(Point2::new(5.0, 4.0)) - 1.5;
            let off = (r - 0.25).abs().min((r - 0.5).abs());
            assert!(off < 0.02 * 0.25, "a node of layer 2 is {r} from the hole");
        }
    }
}

#[test]
fn a_scar_that_cuts_the_domain_is_followed() {
    let cut = (0..=16).map(|i| Point2::new(4.0, i as f64 * 0.5)).collect();
    let m = run(&job(Domain::new(rectangle(10.0, 8.0, 20, 16)).with_scar(cut), 0.5), &Options::default());
    assert_eq!(m.mesh.n_quads(), 320);
}

#[test]
fn an_odd_loop_needs_one_triangle_or_is_refused() {
    let job = job(Domain::new(ring((0.0, 0.0), 2.0, 25)), 0.5);
    let Err(MeshError::Invalid(defects)) = mesh(&job, &Options::default()) else { panic!("odd") };
    assert!(!defects.is_empty());
    let m = mesh(&job, &Options { allow_triangles: true, ..Options::default() }).expect("allowed");
    assert_eq!(m.mesh.triangles.len(), 1);
    assert_eq!(QuadTopology::new(m.mesh.n_vertices(), &m.mesh.quads).n_bad_edges, 0);
}

/// Ends the run when a stage begins.
struct Until {
    stage: &'static str,
    seen: std::sync::Mutex<Vec<&'static str>>,
}

impl csalf_core::Watch for Until {
    fn stage(&self, name: &'static str) {
        self.seen.lock().unwrap().push(name);
    }
    fn cancelled(&self) -> bool {
        self.seen.lock().unwrap().contains(&self.stage)
    }
}

#[test]
fn a_run_can_be_followed_and_ended() {
    let job = Job {
        domain: Domain::new(rectangle(4.0, 3.0, 4, 3)),
        size: SizeSpec::Uniform { h: 1.0 },
        ..Job::default()
    };
    let all = ["check", "size", "fill", "collect", "clean", "certify"];
    for (i, stage) in all.into_iter().chain(["never"]).enumerate() {
        let watch = Until { stage, seen: Default::default() };
        let result = csalf_core::mesh_watched(&job, &Options::default(), &watch);
        assert_eq!(*watch.seen.lock().unwrap(), all[..(i + 1).min(6)]);
        match result {
            // In the last stage nobody asks any more.
            Ok(_) => assert!(i >= 5),
            Err(e) => assert!(matches!(e, MeshError::Cancelled), "{e}"),
        }
    }
}
