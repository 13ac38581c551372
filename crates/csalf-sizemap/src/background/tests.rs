use super::*;
use crate::SizeError;
use proptest::prelude::*;

fn p(x: f64, y: f64) -> Point2 {
    Point2::new(x, y)
}

/// A square with a square hole, and values that are linear in x and y.
fn frame(turn: f64) -> (Background, Vec<Point2>) {
    let r = Point2::from_angle(turn);
    let mut pts =
        vec![p(0., 0.), p(4., 0.), p(4., 4.), p(0., 4.), p(1., 1.), p(1., 3.), p(3., 3.), p(3., 1.)];
    let values: Vec<f64> = pts.iter().map(|q| linear(*q)).collect();
    pts.iter_mut().for_each(|q| *q = r.rotate(*q));
    (Background::from_points(&pts, &values, &[vec![0, 1, 2, 3], vec![4, 5, 6, 7]]).unwrap(), pts)
}

fn linear(q: Point2) -> f64 {
    1.0 + 0.25 * q.x + 0.5 * q.y
}

fn h(b: &Background, q: Point2) -> f64 {
    b.h(q, &mut Hint::default())
}

#[test]
fn linear_inside_nearest_outside() {
    let (b, _) = frame(0.0);
    assert_eq!(b.n_triangles(), 8);
    for q in [p(0.5, 0.5), p(3.5, 2.0), p(1.0, 0.2), p(4.0, 4.0), p(0.0, 1.3), p(1.0, 2.0)] {
        assert!((h(&b, q) - linear(q)).abs() < 1e-14, "{q}");
    }
    // In the hole and outside: the value at the foot on the rim.
    assert!((h(&b, p(1.25, 2.0)) - linear(p(1.0, 2.0))).abs() < 1e-14);
    assert!((h(&b, p(7.0, 2.0)) - linear(p(4.0, 2.0))).abs() < 1e-14);
    assert_eq!(h(&b, p(-3.0, -5.0)), linear(p(0.0, 0.0)));
    assert_eq!(h(&b, p(1e300, 1e300)), linear(p(4.0, 4.0)));
    assert_eq!(h(&b, p(f64::NAN, 0.0)), 1.0);
    assert_eq!(h(&b, p(f64::INFINITY, 0.0)), 1.0);
}

#[test]
fn nodes_give_their_own_values() {
    for turn in [0.0, 0.3, 1.1] {
        let (b, pts) = frame(turn);
        for (q, v) in pts.iter().zip(b.values()) {
            assert_eq!(h(&b, *q), v);
        }
    }
}

#[test]
fn user_triangles_in_any_orientation_are_kept() {
    // The diagonal that Delaunay would not take; one triangle clockwise; an unused node.
    let pts = [p(0., 0.), p(4., 0.), p(5., 1.), p(1., 1.), p(9., 9.)];
    let b = Background::from_triangles(&pts, &[[0, 1, 2], [0, 3, 2]], &[1.0, 2.0, 3.0, 4.0, 9.0]).unwrap();
    assert_eq!(b.n_triangles(), 2);
    assert!((h(&b, p(2.5, 0.5)) - 2.0).abs() < 1e-15);
    assert_eq!(b.range(), (1.0, 4.0));
}

#[test]
fn hanging_nodes_and_overlaps_are_repaired() {
    let pts = [p(0., 0.), p(2., 0.), p(2., 2.), p(0., 2.), p(1., 1.), p(3., 1.)];
    // Node 4 hangs on the diagonal 0-2; the last triangle overlaps the first.
    let tris = [[0, 1, 2], [0, 4, 3], [4, 2, 3], [1, 5, 4]];
    let b = Background::from_triangles(&pts, &tris, &[1.0; 6]).unwrap();
    let v: Vec<_> = b.points().collect();
    let area: f64 = b
        .triangles()
        .map(|t| {
            let [a, b, c] = t.map(|i| v[i as usize]);
            0.5 * (b - a).perp_dot(c - a)
        })
        .sum();
    // The repaired cells may reach over the rim of the union (4.5), but not past its hull.
    assert!((4.0..=5.0).contains(&area), "{area}");
    assert_eq!(h(&b, p(0.3, 0.7)), 1.0);
}

#[test]
fn errors_name_the_place() {
    let pts = [p(0., 0.), p(1., 0.), p(0., 1.)];
    let tri = |v: &[f64]| Background::from_triangles(&pts, &[[0, 1, 2]], v).unwrap_err();
    assert_eq!(
        tri(&[1.0, -2.0, 1.0]),
        SizeError::NotPositive { what: "background node", index: 1, value: -2.0 }
    );
    assert!(matches!(tri(&[1.0, 1.0, f64::NAN]), SizeError::NotFinite { index: 2, .. }));
    assert_eq!(tri(&[1.0]), SizeError::Lengths { n_points: 3, n_values: 1 });
    let e = Background::from_triangles(&pts, &[[0, 1, 7]], &[1.0; 3]).unwrap_err();
    assert_eq!(e, SizeError::BadTriangle { triangle: 0, node: 7, n_points: 3 });
    let flat = [p(0., 0.), p(1., 1.), p(2., 2.)];
    assert_eq!(Background::from_triangles(&flat, &[[0, 1, 2]], &[1.0; 3]).unwrap_err(), SizeError::NoArea);
    let e = Background::from_points(&flat, &[1.0; 3], &[vec![0, 1, 2]]).unwrap_err();
    assert_eq!(e, SizeError::NoArea);
    assert_eq!(Background::from_points(&[], &[], &[]).unwrap_err(), SizeError::NoArea);
}

/// A star-shaped loop of `n` nodes with radii that vary, with a hole, and inner points on a lattice so that many
/// queries fall on sides and nodes.
fn star(n: usize, seed: u64) -> (Vec<Point2>, Vec<f64>, Vec<Vec<u32>>) {
    let mut s = seed | 1;
    let mut rnd = move || {
        s ^= s << 13;
        s ^= s >> 7;
        s ^= s << 17;
        (s >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut pts = Vec::new();
    for i in 0..n {
        let r = if i % 2 == 0 { 8.0 } else { 5.0 + 3.0 * rnd() };
        pts.push(Point2::from_angle(std::f64::consts::TAU * i as f64 / n as f64) * r);
    }
    for i in 0..6 {
        pts.push(Point2::from_angle(-std::f64::consts::TAU * i as f64 / 6.0));
    }
    for i in -3..4 {
        for j in -3..4 {
            let q = p(f64::from(i), f64::from(j));
            if q.length() > 1.5 && q.length() < 4.5 {
                pts.push(q);
            }
        }
    }
    let values = pts.iter().map(|_| 0.1 + rnd()).collect();
    (pts, values, vec![(0..n as u32).collect(), (n as u32..n as u32 + 6).collect()])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The same bits from every start triangle, and after any history; finite, positive and in range.
    #[test]
    fn a_hint_changes_no_bit(n in 5usize..60, seed in any::<u64>(), scale in -40i32..40) {
        let (mut pts, values, loops) = star(n, seed);
        let f = f64::from(scale).exp2();
        pts.iter_mut().for_each(|q| *q *= f);
        let b = Background::from_points(&pts, &values, &loops).unwrap();
        let mut queries: Vec<Point2> = pts.clone();
        for w in pts.windows(2) {
            queries.push(w[0].midpoint(w[1]));
            queries.push(w[0].lerp(w[1], 0.3));
        }
        for i in 0..40 {
            // Lattice lines: most of these lie on sides.
            queries.push(p(f64::from(i) * 0.5 - 10.0, (f64::from(i * 7 % 13) - 6.0) * 0.5) * f);
        }
        let mut history = Hint::default();
        for &q in &queries {
            let want = h(&b, q);
            prop_assert!(want >= b.range().0 && want <= b.range().1);
            prop_assert_eq!(b.h(q, &mut history).to_bits(), want.to_bits());
            for start in 0..b.triangles.len() as u32 + 2 {
                prop_assert_eq!(b.h(q, &mut Hint { owner: start, ..Hint::default() }).to_bits(), want.to_bits(), "at {} from {}", q, start);
            }
            // The last resort finds the same.
            let s = q * b.scale;
            let (_, place) = b.search(0, s);
            let found = match place { Place::In(t, o) => b.value(t, o, s), Place::OffHull => b.outside(s) };
            prop_assert_eq!(found.to_bits(), want.to_bits());
        }
    }

    /// Values are continuous: a small step changes them little, across sides and across the rim.
    #[test]
    fn continuous_across_sides_and_rim(n in 5usize..40, seed in any::<u64>(), x in -9.0f64..9.0, y in -9.0f64..9.0) {
        let (pts, values, loops) = star(n, seed);
        let b = Background::from_points(&pts, &values, &loops).unwrap();
        let q = p(x, y);
        let inside = loops.iter().filter(|l| {
            let poly: Vec<_> = l.iter().map(|&i| pts[i as usize]).collect();
            csalf_geom::polygon::locate(&poly, q) == csalf_geom::polygon::Side::Inside
        }).count() == 1;
        let step = h(&b, q + p(1e-9, -1e-9)) - h(&b, q);
        // Outside, the nearest boundary point may jump.
        prop_assert!(!inside || step.abs() < 1e-5, "{}", step);
    }

    /// A field that is linear on the nodes is linear everywhere inside (partition of unity of eq. 19).
    #[test]
    fn reproduces_linear_fields(n in 5usize..60, seed in any::<u64>(), a in 0.0f64..6.5, r in 1.2f64..4.5) {
        let (pts, _, loops) = star(n, seed);
        let f = |q: Point2| 20.0 + q.x - 0.5 * q.y;
        let values: Vec<f64> = pts.iter().map(|&q| f(q)).collect();
        let b = Background::from_points(&pts, &values, &loops).unwrap();
        let q = Point2::from_angle(a) * r;
        prop_assert!((h(&b, q) - f(q)).abs() < 1e-12);
    }
}
