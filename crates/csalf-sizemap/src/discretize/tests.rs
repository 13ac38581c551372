use super::*;
use crate::{Source, Sources, Uniform};
use csalf_geom::{Arrangement, CheckOptions, Curve, LoopKind};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn p(x: f64, y: f64) -> Point2 {
    Point2::new(x, y)
}

fn square(side: f64) -> Vec<Curve> {
    vec![Curve::Polyline(vec![p(0., 0.), p(side, 0.), p(side, side), p(0., side), p(0., 0.)])]
}

fn run(g: &Geometry, h: f64) -> Domain {
    discretize(g, &Uniform(h), &DiscretizeOptions::default()).unwrap_or_else(|e| panic!("{e:?}"))
}

fn total(d: &Domain) -> usize {
    d.loops.iter().map(|l| l.nodes.len()).sum()
}

/// Segment lengths of a closed loop.
fn lengths(nodes: &[Point2]) -> Vec<f64> {
    (0..nodes.len()).map(|i| nodes[i].distance(nodes[(i + 1) % nodes.len()])).collect()
}

#[test]
fn a_circle_is_even_and_never_too_coarse() {
    let d = run(&Geometry::new(vec![Curve::circle(p(3., 4.), 2.0)]), 0.5);
    let nodes = &d.loops[0].nodes;
    assert_eq!(nodes.len(), 26, "2 π 2 / 0.5 = 25.13, made even");
    let l = lengths(nodes);
    assert!(l.iter().all(|x| (x - l[0]).abs() < 1e-12));
    assert!(nodes.iter().all(|q| (q.distance(p(3., 4.)) - 2.0).abs() < 1e-12));
    assert_eq!(d.check(), []);
    assert_eq!(total(&run(&Geometry::new(vec![Curve::circle(p(3., 4.), 2.0)]), 100.0)), 8);
}

#[test]
fn a_square_keeps_its_corners() {
    let d = run(&Geometry::new(square(1.0)), 0.3);
    assert_eq!(total(&d), 12);
    for c in [p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)] {
        assert!(d.loops[0].nodes.contains(&c));
    }
    // Coarser than the square: one segment per side is left.
    assert_eq!(total(&run(&Geometry::new(square(1.0)), 7.0)), 4);
}

#[test]
fn smooth_joints_need_no_node_but_may_wish_one() {
    // A stadium: two lines and two half circles, no kink anywhere.
    let curves = vec![
        Curve::line(p(0., -1.), p(3., -1.)),
        Curve::arc(p(3., 0.), 1.0, -PI / 2.0, PI),
        Curve::line(p(3., 1.), p(0., 1.)),
        Curve::arc(p(0., 0.), 1.0, PI / 2.0, PI),
    ];
    let d = run(&Geometry::new(curves.clone()), 0.7);
    assert_eq!(total(&d), 18, "12.283 / 0.7 = 17.5");
    assert!(!d.loops[0].nodes.iter().any(|q| q.distance(p(3., -1.)) < 1e-9));
    let mut g = Geometry::new(curves);
    g.loops[0].edges[1].corner = true;
    g.loops[0].edges[3].count = Some(9);
    let d = run(&g, 0.7);
    assert!(d.loops[0].nodes.contains(&g.loops[0].edges[1].curve.start()));
    assert_eq!(d.loops[0].nodes[0], p(0., -1.), "the first kept node: the end of the prescribed count");
    let on_left = d.loops[0].nodes.iter().filter(|q| q.x < -1e-9).count();
    assert_eq!(on_left, 8, "nine segments on the left half circle");
    assert_eq!(total(&d) % 2, 0);
}

#[test]
fn half_discs_do_not_collapse() {
    let g = Geometry::new(vec![Curve::arc(p(0., 0.), 1.0, 0.0, PI), Curve::line(p(-1., 0.), p(1., 0.))]);
    let d = run(&g, 50.0);
    assert!(total(&d) >= 6 && total(&d).is_multiple_of(2), "{}", total(&d));
    assert_eq!(d.check(), []);
    // A teardrop of one curve with one kink.
    let drop = Curve::Cubic([p(0., 0.), p(3., 3.), p(-3., 3.), p(0., 0.)]);
    let d = run(&Geometry::new(vec![drop]), 50.0);
    assert!(total(&d) >= 4 && d.loops[0].nodes[0] == p(0., 0.));
    assert_eq!(d.check(), []);
}

#[test]
fn the_cheapest_count_is_changed() {
    // Sides of 5 and 20.4 segments: 5 + 20 + 5 + 20 is even; with a hole of 9 it is not. Best is 20 -> 21 of 20.4.
    let outer = Curve::Polyline(vec![p(0., 0.), p(20.4, 0.), p(20.4, 5.), p(0., 5.), p(0., 0.)]);
    let hole = Curve::circle(p(10., 2.5), 9.0 / TAU);
    let d = run(&Geometry::new(vec![outer]).with_hole(vec![hole]), 1.0);
    assert_eq!((d.loops[0].nodes.len(), d.loops[1].nodes.len()), (51, 9));
    assert_eq!(d.loops[1].kind, LoopKind::Hole);
    assert_eq!(d.check(), []);
}

#[test]
fn prescribed_counts_are_kept_or_refused() {
    let mut g = Geometry::new(vec![
        Curve::line(p(0., 0.), p(1., 0.)),
        Curve::line(p(1., 0.), p(1., 1.)),
        Curve::line(p(1., 1.), p(0., 0.)),
    ]);
    for (e, n) in g.loops[0].edges.iter_mut().zip([3, 4, 6]) {
        e.count = Some(n);
    }
    let found = discretize(&g, &Uniform(0.1), &DiscretizeOptions::default());
    assert_eq!(found, Err(vec![GeometryDefect::OddCounts { n_segments: 13 }]));
    let free = DiscretizeOptions { even: false, ..DiscretizeOptions::default() };
    assert_eq!(discretize(&g, &Uniform(0.1), &free).map(|d| total(&d)), Ok(13));
    g.loops[0].edges[1].count = None;
    assert_eq!(total(&run(&g, 0.1)), 3 + 11 + 6, "ten or eleven or nine; the finer of equals wins");
    // A count over a polyline with corners is shared among its sides.
    let mut g = Geometry::new(square(1.0));
    g.loops[0].edges[0].count = Some(10);
    let d = run(&g, 0.01);
    assert_eq!(total(&d), 10);
    assert!(d.loops[0].nodes.contains(&p(1., 1.)));
}

#[test]
fn spacing_follows_the_field() {
    let source = Source { xy: p(10., 0.), h: 0.05, radius: 0.5, falloff: 4.0 };
    let field = Sources::new(0.5, &[source], None).unwrap();
    let wave: Vec<_> = (0..=20).map(|i| p(f64::from(i), (f64::from(i) * 0.7).sin())).collect();
    let g = Geometry::new(vec![
        Curve::through(&wave, false).unwrap(),
        Curve::Polyline(vec![wave[20], p(20., 9.), p(0., 9.), wave[0]]),
    ]);
    let d = discretize(&g, &field, &DiscretizeOptions::default()).unwrap();
    assert_eq!(d.check(), []);
    let nodes = &d.loops[0].nodes;
    let mut hint = Hint::default();
    for (i, l) in lengths(nodes).into_iter().enumerate() {
        let h = field.h(nodes[i].midpoint(nodes[(i + 1) % nodes.len()]), &mut hint);
        assert!((l / h - 1.0).abs() < 0.06, "segment {i} of {}: {l} against {h}", nodes.len());
    }
}

#[test]
fn small_spots_are_seen() {
    let source = Source { xy: p(50., 0.), h: 0.1, radius: 0.5, falloff: 1.0 };
    let field = Sources::new(10.0, &[source], None).unwrap();
    let d = discretize(&Geometry::new(square(100.0)), &field, &DiscretizeOptions::default()).unwrap();
    assert!(d.loops[0].nodes.iter().filter(|q| q.distance(p(50., 0.)) < 0.5).count() >= 9);
}

#[test]
fn curvature_makes_finer() {
    let limit = CurvatureLimit { angle: 0.1, chord: f64::INFINITY, floor: 1e-3 };
    let options = DiscretizeOptions { curvature: Some(limit), ..DiscretizeOptions::default() };
    let g = Geometry::new(vec![Curve::circle(p(0., 0.), 1.0)]);
    assert_eq!(discretize(&g, &Uniform(9.0), &options).map(|d| total(&d)), Ok(62), "2 π / 0.1 = 62.8");
    let limit = CurvatureLimit { angle: 1.0, chord: 1e-3, floor: 1e-3 };
    let options = DiscretizeOptions { curvature: Some(limit), ..options };
    let d = discretize(&g, &Uniform(9.0), &options).unwrap();
    let nodes = &d.loops[0].nodes;
    let sag = 1.0 - nodes[0].midpoint(nodes[1]).length();
    assert!((sag / 1e-3 - 1.0).abs() < 0.1, "{sag}");
    // Straight sides are not touched.
    assert_eq!(discretize(&Geometry::new(square(1.0)), &Uniform(0.25), &options).map(|d| total(&d)), Ok(16));
}

#[test]
fn scars_join_curves_at_nodes() {
    // From the circle's side to its top, and a branch from the middle of the first scar.
    let r = std::f64::consts::FRAC_1_SQRT_2;
    let g = Geometry::new(vec![Curve::circle(p(0., 0.), 1.0)])
        .with_scar(vec![Curve::line(p(-r, r), p(r, -r))])
        .with_scar(vec![Curve::line(p(0.1, -0.1), p(0.4, 0.4))])
        .with_scar(vec![Curve::line(p(1.0, 0.0), p(0.9, 0.05))]);
    let d = run(&g, 0.23);
    let a = Arrangement::new(&d, &CheckOptions { repair_parity: true, allow_odd: false });
    let a = a.unwrap_or_else(|e| panic!("{e:?}"));
    assert_eq!(a.regions.len(), 2);
    assert!(d.loops[0].nodes.contains(&d.scars[0].nodes[0]));
    assert!(d.scars[0].nodes.contains(&d.scars[1].nodes[0]));
    assert!(a.regions.iter().all(|r| r.inner.is_empty()));
}

#[test]
fn defects_of_curves_are_listed() {
    let g = Geometry::new(vec![Curve::line(p(0., 0.), p(1., 0.)), Curve::line(p(1.5, 0.), p(0., 0.))])
        .with_hole(vec![])
        .with_scar(vec![Curve::Polyline(vec![p(0., 0.)])]);
    let found = discretize(&g, &Uniform(1.0), &DiscretizeOptions::default()).unwrap_err();
    assert!(matches!(
        found.as_slice(),
        [
            GeometryDefect::Gap { index: 0, .. },
            GeometryDefect::NoCurves { .. },
            GeometryDefect::BadCurve { .. }
        ]
    ));
    for h in [0.0, -1.0, f64::NAN, 1e-12] {
        let found = discretize(&Geometry::new(square(1.0)), &Uniform(h), &DiscretizeOptions::default());
        assert!(matches!(found.unwrap_err().as_slice(), [GeometryDefect::BadSize { .. }]), "{h}");
    }
    assert_eq!(
        discretize(&Geometry::default(), &Uniform(1.0), &DiscretizeOptions::default()),
        Ok(Domain::default())
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn totals_are_even_and_nodes_on_the_curves(
        radii in prop::collection::vec(0.3..0.49f64, 1..9), h in 0.02..3.0f64, turn in 0.0..6.0f64,
    ) {
        let n = radii.len() as f64;
        let star = (0..7).map(|i| p(n / 2.0, 0.5) + Point2::from_angle(f64::from(i) * TAU / 7.0) * (n + 2.0));
        let mut g = Geometry::new(vec![Curve::through(&star.collect::<Vec<_>>(), true).unwrap()]);
        for (i, r) in radii.iter().enumerate() {
            let c = p(i as f64 + 0.5, 0.5);
            g = g.with_hole(vec![Curve::arc(c, *r, turn, 2.0), Curve::arc(c, *r, turn + 2.0, TAU - 2.0)]);
        }
        let d = run(&g, h);
        prop_assert_eq!(total(&d) % 2, 0);
        prop_assert_eq!(d.check(), vec![]);
        for (i, r) in radii.iter().enumerate() {
            for q in &d.loops[i + 1].nodes {
                prop_assert!((q.distance(p(i as f64 + 0.5, 0.5)) - r).abs() < 1e-12 * n);
            }
            let l = lengths(&d.loops[i + 1].nodes);
            prop_assert!(l.iter().all(|x| (x - l[0]).abs() < 1e-9));
        }
    }
}
