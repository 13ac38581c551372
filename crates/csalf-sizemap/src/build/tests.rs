use super::*;
use crate::Source;

fn p(x: f64, y: f64) -> Point2 {
    Point2::new(x, y)
}

fn build_one(
    spec: &SizeSpec,
    loops: &[Vec<Point2>],
    extras: &Extras<'_>,
) -> Result<Arc<dyn SizeField>, SizeError> {
    build(spec, loops, extras, Tolerance::of_points(loops.iter().flatten().copied()))
}

fn h(f: &Arc<dyn SizeField>, q: Point2) -> f64 {
    f.h(q, &mut Hint::default())
}

/// A rectangle 4 x 2 whose bottom has segments of 1 and whose other sides are one segment each.
fn plate() -> Vec<Vec<Point2>> {
    vec![vec![p(0., 0.), p(1., 0.), p(2., 0.), p(3., 0.), p(4., 0.), p(4., 2.), p(0., 2.)]]
}

#[test]
fn boundary_nodes_take_the_mean_of_their_segments() {
    let f = build_one(&SizeSpec::Boundary, &plate(), &Extras::default()).unwrap();
    assert_eq!(
        [h(&f, p(1., 0.)), h(&f, p(2., 0.)), h(&f, p(4., 0.)), h(&f, p(4., 2.))],
        [1.0, 1.0, 1.5, 3.0]
    );
    assert_eq!(f.range(), (1.0, 3.0));
    assert_eq!(h(&f, p(0.25, 0.)), 1.375);
    assert_eq!(f.constant(), None);
}

#[test]
fn holes_and_orientation_do_not_matter_to_the_inside() {
    let hole = vec![p(1., 0.5), p(1., 1.5), p(3., 1.5), p(3., 0.5)];
    let mut loops = plate();
    loops.push(hole);
    let a = build_one(&SizeSpec::Boundary, &loops, &Extras::default()).unwrap();
    loops.reverse();
    loops.iter_mut().for_each(|l| l.reverse());
    let b = build_one(&SizeSpec::Boundary, &loops, &Extras::default()).unwrap();
    for q in [p(0.5, 0.25), p(3.5, 1.0), p(2.0, 0.2), p(0.7, 1.8)] {
        assert!((h(&a, q) - h(&b, q)).abs() < 1e-15, "{q}");
    }
    // Inside the hole the nearest rim counts: nothing of the outer loop.
    assert!((h(&a, p(2.0, 0.75)) - 1.5).abs() < 1e-15);
}

#[test]
fn closed_kinds() {
    let u = build_one(&SizeSpec::Uniform { h: 0.5 }, &plate(), &Extras::default()).unwrap();
    assert_eq!(u.constant(), Some(0.5));
    let s = Source { xy: p(0., 0.), h: 0.1, radius: 1.0, falloff: 1.0 };
    let s = SizeSpec::Sources { far: 1.0, sources: vec![s] };
    let f = build_one(&s, &plate(), &Extras::default()).unwrap();
    assert_eq!(h(&f, p(0.0, 1.5)), 0.55);
    // Limited to 0.2, the rise of 0.9 takes 4.5.
    let f = build_one(&s, &plate(), &Extras { gradation: Some(0.2), ..Extras::default() }).unwrap();
    assert!((h(&f, p(0.0, 1.5)) - 0.2).abs() < 1e-15);
    assert_eq!(h(&f, p(0.0, 5.5)), 1.0);
}

#[test]
fn hard_points_are_spots_and_never_enlarge() {
    let points = [(p(2., 1.), 0.1), (p(1., 1.), 50.0)];
    let extras = Extras { hard_points: &points, ..Extras::default() };
    for spec in [SizeSpec::Boundary, SizeSpec::Uniform { h: 0.5 }] {
        let plain = build_one(&spec, &plate(), &Extras::default()).unwrap();
        let f = build_one(&spec, &plate(), &extras).unwrap();
        assert_eq!(h(&f, p(2., 1.)), 0.1);
        assert!((h(&f, p(2.5, 1.)) - 0.2).abs() < 1e-15);
        assert_eq!(h(&f, p(1., 1.)), h(&plain, p(1., 1.)).min(0.1 + DEFAULT_GRADATION));
        assert_eq!(f.range().0, 0.1);
    }
}

#[test]
fn faults_are_typed() {
    let e = |spec: &SizeSpec, loops: &[Vec<Point2>], x: &Extras<'_>| build_one(spec, loops, x).unwrap_err();
    let none = Extras::default();
    let doubled = [vec![p(0., 0.), p(1., 0.), p(1., 0.), p(1., 0.), p(0., 1.)]];
    assert_eq!(
        e(&SizeSpec::Boundary, &doubled, &none),
        SizeError::NotPositive { what: "loop node", index: 2, value: 0.0 }
    );
    let nan = [vec![p(0., 0.), p(1., f64::NAN), p(0., 1.)]];
    assert!(matches!(e(&SizeSpec::Boundary, &nan, &none), SizeError::BadPoint { index: 1, .. }));
    assert_eq!(e(&SizeSpec::Boundary, &[], &none), SizeError::NoArea);
    let u = |h| e(&SizeSpec::Uniform { h }, &plate(), &none);
    assert!(matches!(u(-1.0), SizeError::NotPositive { .. }));
    assert!(matches!(u(f64::INFINITY), SizeError::NotFinite { .. }));
    for g in [0.0, -0.2, f64::NAN, f64::INFINITY] {
        let x = Extras { gradation: Some(g), ..none };
        assert!(matches!(e(&SizeSpec::Boundary, &plate(), &x), SizeError::BadGradation(_)));
    }
    let x = Extras { hard_points: &[(p(1., 1.), 0.0)], ..none };
    assert!(matches!(
        e(&SizeSpec::Boundary, &plate(), &x),
        SizeError::NotPositive { what: "hard point", .. }
    ));
}

#[test]
fn gradation_limits_boundary_and_user_fields() {
    let x = Extras { gradation: Some(0.1), ..Extras::default() };
    let f = build_one(&SizeSpec::Boundary, &plate(), &x).unwrap();
    // From 1 at the bottom the size may grow by 0.2 to the top; it was 3 there.
    assert!((h(&f, p(2., 2.)) - 1.2).abs() < 0.03, "{}", h(&f, p(2., 2.)));
    let spec = SizeSpec::Background {
        points: vec![p(-1., -1.), p(5., -1.), p(5., 3.), p(-1., 3.), p(2., 1.)],
        triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
        values: vec![1.0, 1.0, 1.0, 1.0, 0.1],
    };
    let f = build_one(&spec, &plate(), &x).unwrap();
    assert_eq!(h(&f, p(2., 1.)), 0.1);
    for r in [0.2, 0.5, 0.9] {
        assert!((h(&f, p(2. + r, 1.)) / (0.1 + 0.1 * r) - 1.0).abs() < 0.1);
    }
}
