use super::*;
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

fn frame() -> Frame {
    Frame::new(DVec3::new(3.0, -2.0, 1.0), DVec3::new(1.0, 2.0, -0.5), DVec3::new(0.3, 0.1, 2.0))
}

/// A quarter of a cylinder of radius 1 and height 2 about z, as a NURBS: u round, v up.
fn quarter() -> NurbsSurface {
    let points: Vec<DVec3> = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .iter()
        .flat_map(|&(x, y)| [DVec3::new(x, y, 0.0), DVec3::new(x, y, 2.0)])
        .collect();
    let w = FRAC_1_SQRT_2;
    let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    NurbsSurface::new([2, 1], knots, &points, &[1.0, 1.0, w, w, 1.0, 1.0]).expect("a quarter")
}

/// A bump: bicubic, free form.
fn bump() -> NurbsSurface {
    let points: Vec<DVec3> = (0..5)
        .flat_map(|i| {
            (0..5).map(move |j| {
                let (x, y) = (f64::from(i), f64::from(j));
                DVec3::new(x, y, (0.9 * x).sin() * (0.7 * y).cos())
            })
        })
        .collect();
    let k = vec![0.0, 0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0, 1.0];
    let weights: Vec<f64> = (0..25).map(|i| 1.0 + 0.2 * f64::from(i % 3)).collect();
    NurbsSurface::new([3, 3], [k.clone(), k], &points, &weights).expect("a bump")
}

fn surfaces() -> Vec<(Surface, DVec2, DVec2)> {
    let b = |a: f64, b: f64, c: f64, d: f64| (DVec2::new(a, b), DVec2::new(c, d));
    let f = frame();
    let all = [
        (Surface::Plane(f), b(-3.0, -3.0, 3.0, 3.0)),
        (Surface::Cylinder { frame: f, radius: 2.0 }, b(-3.0, -3.0, 3.0, 3.0)),
        (Surface::Cone { frame: f, radius: 2.0, angle: 0.5 }, b(-3.0, -3.0, 3.0, 3.0)),
        (Surface::Cone { frame: f, radius: 2.0, angle: -0.5 }, b(-3.0, -3.0, 3.0, 3.0)),
        (Surface::Sphere { frame: f, radius: 2.0 }, b(-3.0, -1.4, 3.0, 1.4)),
        (Surface::Torus { frame: f, major: 3.0, minor: 1.0 }, b(-3.0, -3.0, 3.0, 3.0)),
        (Surface::Nurbs(quarter()), b(0.02, 0.02, 0.98, 0.98)),
        (Surface::Nurbs(bump()), b(0.02, 0.02, 0.98, 0.98)),
    ];
    all.into_iter().map(|(s, (lo, hi))| (s, lo, hi)).collect()
}

#[test]
fn a_rational_quarter_is_a_circle() {
    let s = quarter();
    for k in 0..=20 {
        let p = s.eval(DVec2::new(f64::from(k) / 20.0, 0.3)).point;
        assert!((p.truncate().length() - 1.0).abs() < 1e-14, "{p}");
        assert!((p.z - 0.6).abs() < 1e-14);
    }
    let at = s.eval(DVec2::new(0.3, 0.7));
    assert!((at.max_curvature() - 1.0).abs() < 1e-12, "{}", at.max_curvature());
    assert!(at.normal().dot(at.point.with_z(0.0)) > 0.999);
}

/// Of a quarter cylinder, in and out; and none of a surface without normals.
#[test]
fn an_offset_of_a_quarter_cylinder_is_another() {
    for distance in [0.25, -0.4] {
        let s = quarter().offset(distance, 1e-8).expect("a fit");
        let sign = quarter().eval(DVec2::splat(0.5));
        let out = sign.du.cross(sign.dv).dot(sign.point.truncate().extend(0.0)).signum();
        for k in 0..=50 {
            let p = s.eval(DVec2::new(f64::from(k) / 50.0, 0.37)).point;
            assert!((p.truncate().length() - (1.0 + out * distance)).abs() < 1e-7, "{p}");
            assert!((p.z - 0.74).abs() < 1e-7);
        }
    }
    let flat = vec![DVec3::ZERO; 6];
    let nothing = NurbsSurface::new(
        [2, 1],
        [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]],
        &flat,
        &[1.0; 6],
    );
    assert!(nothing.expect("a point").offset(1.0, 1e-8).is_none(), "a point has no normal");
}

#[test]
fn bad_knots_are_refused() {
    let p = [DVec3::ZERO, DVec3::X, DVec3::Y];
    for knots in [
        vec![0.0; 6],
        vec![0.0, 0.0, 0.0, 1.0, 1.0],
        vec![0.0, 0.0, 0.0, 1.0, f64::NAN, 1.0],
        vec![1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
    ] {
        assert!(NurbsCurve::new(2, knots, &p, &[1.0; 3]).is_none());
    }
    assert!(NurbsCurve::new(0, vec![0.0; 4], &p, &[1.0; 3]).is_none());
    assert!(NurbsCurve::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], &p, &[1.0, 0.0, 1.0]).is_none());
    assert!(NurbsCurve::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], &p, &[1.0; 3]).is_some());
}

#[test]
fn a_transposed_surface_is_the_same_points() {
    let s = bump();
    let t = s.transposed();
    for k in 0..10 {
        let uv = DVec2::new(0.1 * f64::from(k), 0.97 - 0.08 * f64::from(k));
        assert!(s.eval(uv).point.distance(t.eval(DVec2::new(uv.y, uv.x)).point) < 1e-13);
    }
}

#[test]
fn the_nearest_point_of_a_curve() {
    let c = Curve::circle(frame(), 2.0);
    let p = c.eval(2.0).point * 1.1 - frame().origin * 0.1;
    assert!((c.nearest(p, [0.0, PI]) - 2.0).abs() < 1e-6);
    assert!((c.closed_form_parameter(p).expect("a circle") - 2.0).abs() < 1e-12);
}

proptest! {
    #[test]
    fn inversion_finds_the_parameters(x in 0.0..1.0f64, y in 0.0..1.0f64) {
        for (s, lo, hi) in surfaces() {
            let uv = lo + (hi - lo) * DVec2::new(x, y);
            let p = s.eval(uv).point;
            let inverter = Inverter::new(&s);
            let (found, d) = inverter.invert(p, None, 1e-9);
            prop_assert!(d < 1e-7, "{}: {d} at {uv}", s.kind());
            let near = inverter.near(found, uv);
            prop_assert!(near.distance(uv) < 1e-5, "{}: {near} for {uv}", s.kind());
            let (hinted, d) = inverter.invert(p, Some(uv + DVec2::splat(0.01)), 1e-9);
            prop_assert!(d < 1e-7 && hinted.distance(uv) < 1e-5, "{}: {hinted} for {uv}", s.kind());
        }
    }

    /// Of points beside the surface and beyond its rims, too, none of a fine grid of its points is nearer.
    #[test]
    fn no_other_point_is_nearer(x in -0.6..1.6f64, y in -0.6..1.6f64, off in -0.5..0.5f64) {
        for surface in [quarter(), bump()] {
            let [u, v] = [0, 1].map(|k| surface.knots[k].range());
            let at = |x: f64, y: f64| {
                surface.eval(DVec2::new(u[0] + (u[1] - u[0]) * x, v[0] + (v[1] - v[0]) * y))
            };
            let rim = at(x.clamp(0.0, 1.0), y.clamp(0.0, 1.0));
            let across = rim.du.cross(rim.dv).normalize_or_zero();
            let p = rim.point + rim.du * (x - x.clamp(0.0, 1.0)) + rim.dv * (y - y.clamp(0.0, 1.0)) + across * off;
            let least = (0..=90)
                .flat_map(|i| (0..=90).map(move |j| (f64::from(i) / 90.0, f64::from(j) / 90.0)))
                .map(|(x, y)| at(x, y).point.distance(p))
                .fold(f64::INFINITY, f64::min);
            let s = Surface::Nurbs(surface.clone());
            let (_, d) = Inverter::new(&s).invert(p, None, 0.0);
            prop_assert!(d <= least + 1e-9, "{d} and {least} at {p}");
        }
    }

    #[test]
    fn derivatives_are_those_of_differences(x in 0.05..0.95f64, y in 0.05..0.95f64) {
        let h = 1e-5;
        for (s, lo, hi) in surfaces() {
            let uv = lo + (hi - lo) * DVec2::new(x, y);
            let at = s.eval(uv);
            let d = |du: f64, dv: f64| s.eval(uv + DVec2::new(du, dv)).point;
            let scale = at.du.length() + at.dv.length() + at.duu.length() + at.dvv.length() + at.duv.length();
            let off = |a: DVec3, b: DVec3| (a - b).length() / scale;
            prop_assert!(off(at.du, (d(h, 0.0) - d(-h, 0.0)) / (2.0 * h)) < 1e-6);
            prop_assert!(off(at.dv, (d(0.0, h) - d(0.0, -h)) / (2.0 * h)) < 1e-6);
            let g = 1e-4;
            prop_assert!(off(at.duu, (d(g, 0.0) + d(-g, 0.0) - d(0.0, 0.0) * 2.0) / (g * g)) < 1e-4);
            prop_assert!(off(at.dvv, (d(0.0, g) + d(0.0, -g) - d(0.0, 0.0) * 2.0) / (g * g)) < 1e-4);
            prop_assert!(off(at.duv, (d(g, g) + d(-g, -g) - d(g, -g) - d(-g, g)) / (4.0 * g * g)) < 1e-4);
        }
    }

    #[test]
    fn motions_move_everything_alike(u in 0.0..0.9f64, v in 0.0..0.9f64) {
        let motion = Motion { to: frame() };
        for (s, lo, hi) in surfaces() {
            let uv = lo + (hi - lo) * DVec2::new(u, v);
            let (a, b) = (motion.point(s.eval(uv).point), s.moved(&motion).eval(uv).point);
            prop_assert!(a.distance(b) < 1e-12 * (1.0 + a.length()));
        }
    }
}
