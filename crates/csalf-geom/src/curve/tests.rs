use super::*;

fn p(x: f64, y: f64) -> Point2 {
    Point2::new(x, y)
}

/// Derivatives against differences, at places away from breaks.
fn check_derivatives(c: &Curve) {
    let (t0, t1) = c.range();
    let e = 1e-5 * (t1 - t0);
    for k in 0..37 {
        let t = t0 + (t1 - t0) * (0.013 + 0.97 * f64::from(k) / 36.0);
        if c.breaks().iter().any(|b| (b - t).abs() < 2.0 * e) {
            continue;
        }
        let (a, m, b) = (c.eval(t - e), c.eval(t), c.eval(t + e));
        let d1 = (b.point - a.point) / (2.0 * e);
        let d2 = (b.d1 - a.d1) / (2.0 * e);
        assert!(d1.distance(m.d1) < 1e-6 * (1.0 + m.d1.length()), "{c:?} at {t}: {d1} {}", m.d1);
        assert!(d2.distance(m.d2) < 1e-5 * (1.0 + m.d2.length()), "{c:?} at {t}: {d2} {}", m.d2);
    }
}

fn wave() -> Vec<Point2> {
    (0..9).map(|i| p(f64::from(i), (f64::from(i) * 0.9).sin())).collect()
}

fn quarter() -> Nurbs {
    let w = std::f64::consts::FRAC_1_SQRT_2;
    let points = [p(2., 0.), p(2., 2.), p(0., 2.), p(-2., 2.), p(-2., 0.)];
    let knots = [0., 0., 0., 1., 1., 2., 2., 2.];
    Nurbs::new(2, &knots, &points, &[1., w, 1., w, 1.]).unwrap()
}

#[test]
fn derivatives_match_differences() {
    let arc = Curve::Arc { center: p(1., 2.), radii: p(3., 1.), rotation: 0.4, start: 1.0, sweep: -2.5 };
    let knots = [0., 0., 0., 0., 1., 2., 2., 3., 3., 3., 3.];
    for c in [
        arc,
        Curve::Polyline(wave()),
        Curve::Quadratic([p(0., 0.), p(1., 2.), p(3., 0.)]),
        Curve::Cubic([p(0., 0.), p(1., 2.), p(3., 0.), p(4., 4.)]),
        Curve::Nurbs(quarter()),
        Curve::Nurbs(Nurbs::new(3, &knots, &wave()[..7], &[]).unwrap()),
        Curve::through(&wave(), false).unwrap(),
        Curve::through(&[p(0., 0.), p(2., 0.), p(2., 1.), p(0., 2.)], true).unwrap(),
    ] {
        check_derivatives(&c);
        assert!(c.is_finite());
    }
}

#[test]
fn a_rational_spline_is_a_circle() {
    let c = Curve::Nurbs(quarter());
    for i in 0..=100 {
        let q = c.eval(f64::from(i) * 0.02);
        assert!((q.point.length() - 2.0).abs() < 1e-14);
        assert!((q.radius() - 2.0).abs() < 1e-9);
    }
    assert_eq!((c.start(), c.end()), (p(2., 0.), p(-2., 0.)));
    assert_eq!(c.breaks(), [1.0]);
}

#[test]
fn a_spline_passes_its_points_and_is_smooth() {
    let square = [p(1., 1.), p(-1., 1.), p(-1., -1.), p(1., -1.)];
    for (points, closed) in [(wave(), false), (square.to_vec(), true)] {
        let s = Spline::new(&points, closed).unwrap();
        for (i, q) in points.iter().enumerate() {
            assert_eq!(s.eval(s.knots()[i]).point, *q);
        }
        for &t in &Curve::Spline(s.clone()).breaks() {
            let (a, b) = (s.eval(t - 1e-9), s.eval(t));
            assert!(a.d1.distance(b.d1) < 1e-7 && a.d2.distance(b.d2) < 1e-7, "{a:?} {b:?}");
        }
        let (t0, t1) = s.range();
        let (a, b) = (s.eval(t0), s.eval(t1));
        if closed {
            assert!(a.d1.distance(b.d1) < 1e-12 && a.d2.distance(b.d2) < 1e-12);
        } else {
            assert!(a.d2.length() < 1e-12 && b.d2.length() < 1e-12);
        }
    }
    // By symmetry: at the corners of a square the tangent is along the other diagonal.
    let s = Spline::new(&square, true).unwrap();
    assert!(s.eval(0.0).d1.dot(p(1., 1.)).abs() < 1e-12);
}

#[test]
fn bulges_are_arcs() {
    // A half circle to the right of the chord (counter-clockwise from a to b).
    let c = Curve::bulge(p(0., 0.), p(2., 0.), 1.0);
    assert!(c.eval(0.5).point.distance(p(1., -1.)) < 1e-15);
    let c = Curve::bulge(p(0., 0.), p(2., 0.), -0.5);
    assert!(c.start().distance(p(0., 0.)) < 1e-15 && c.end().distance(p(2., 0.)) < 1e-15);
    assert!(c.eval(0.5).point.distance(p(1., 0.5)) < 1e-15, "the height is bulge times half the chord");
    assert_eq!(Curve::bulge(p(0., 0.), p(2., 0.), 0.0), Curve::line(p(0., 0.), p(2., 0.)));
}

#[test]
fn directions_hold_at_corners_and_where_the_derivative_vanishes() {
    let c = Curve::Polyline(vec![p(0., 0.), p(1., 0.), p(1., 1.)]);
    assert!(c.direction(1.0, 0.0).distance(p(-1., 0.)) < 1e-9);
    assert!(c.direction(1.0, 2.0).distance(p(0., 1.)) < 1e-9);
    let c = Curve::Cubic([p(0., 0.), p(0., 0.), p(1., 1.), p(2., 0.)]);
    assert!(c.direction(0.0, 1.0).distance(p(1., 1.).normalize()) < 1e-3);
    let c = Curve::circle(p(0., 0.), 1.0);
    assert!(c.direction(1.0, 0.0).distance(p(0., -1.)) < 1e-3);
}

#[test]
fn bad_curves_are_refused() {
    assert_eq!(Nurbs::new(0, &[], &wave(), &[]), Err(CurveError::Degree));
    assert_eq!(Nurbs::new(3, &[0.0; 8], &wave()[..4], &[]), Err(CurveError::Knots));
    assert_eq!(Nurbs::new(1, &[0., 0., 1.], &wave()[..2], &[]), Err(CurveError::Knots));
    assert_eq!(Nurbs::new(1, &[0., 1., 0., 1.], &wave()[..2], &[]), Err(CurveError::Knots));
    assert_eq!(Nurbs::new(1, &[0., 0., 1., 1.], &wave()[..2], &[1., 0.]), Err(CurveError::Weights));
    assert!(matches!(Nurbs::new(3, &[], &wave()[..2], &[]), Err(CurveError::TooFewPoints { .. })));
    assert_eq!(Spline::new(&[p(0., 0.), p(0., 0.)], false), Err(CurveError::RepeatedPoint { index: 1 }));
    assert_eq!(Spline::new(&[p(0., f64::NAN), p(0., 0.)], false), Err(CurveError::NotFinite));
    assert!(!Curve::Polyline(vec![]).is_finite());
    let _ = Curve::Polyline(vec![]).eval(0.0);
}

#[test]
fn paths_come_in_through_kurbo() {
    let path = kurbo::BezPath::from_svg("M 0 0 L 1 0 Q 2 0 2 1 C 2 2 1 2 0 2 Z").unwrap();
    let curves: Vec<Curve> = path.segments().map(Curve::from).collect();
    assert_eq!(curves.len(), 4);
    assert!(curves.windows(2).all(|w| w[0].end() == w[1].start()));
    assert_eq!(curves[3].end(), curves[0].start());
    let arc = kurbo::Arc::new((1.0, 2.0), (3.0, 1.0), 0.5, 1.0, 0.3);
    let c = Curve::from(arc);
    let bez: Vec<_> = kurbo::Shape::path_segments(&arc, 1e-9).collect();
    let kurbo::PathSeg::Cubic(first) = bez[0] else { panic!("an arc starts with a cubic") };
    assert!(c.start().distance(p(first.p0.x, first.p0.y)) < 1e-12);
}
