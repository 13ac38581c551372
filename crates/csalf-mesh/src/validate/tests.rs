use super::*;
use proptest::prelude::*;

/// An n x n grid of unit squares with its boundary. Boundary nodes first.
fn grid(n: usize) -> (QuadMesh, Vec<[VertexId; 2]>) {
    let mut order = Vec::new();
    for i in 0..n {
        order.push((i, 0));
    }
    for j in 0..n {
        order.push((n, j));
    }
    for i in (1..=n).rev() {
        order.push((i, n));
    }
    for j in (1..=n).rev() {
        order.push((0, j));
    }
    let m = order.len();
    for j in 1..n {
        for i in 1..n {
            order.push((i, j));
        }
    }
    let find = |i, j| VertexId::new(order.iter().position(|&o| o == (i, j)).unwrap());
    let points = order.iter().map(|&(i, j)| Point2::new(i as f64, j as f64)).collect();
    let mut mesh = QuadMesh { points, ..QuadMesh::default() };
    for j in 0..n {
        for i in 0..n {
            mesh.quads.push([find(i, j), find(i + 1, j), find(i + 1, j + 1), find(i, j + 1)]);
        }
    }
    let boundary = (0..m).map(|i| [VertexId::new(i), VertexId::new((i + 1) % m)]).collect();
    (mesh, boundary)
}

fn names(mesh: &QuadMesh, e: &Expectation<'_>) -> Vec<String> {
    validate(mesh, e)
        .iter()
        .map(|d| format!("{d:?}").split([' ', '(', '{']).next().unwrap().to_owned())
        .collect()
}

#[test]
fn a_sound_mesh_has_no_defect() {
    let (mesh, boundary) = grid(4);
    let v = VertexId::new;
    let e = Expectation {
        nodes: &mesh.points[..16],
        boundary: &boundary,
        scars: &[[v(17), v(16)]],
        points: &[v(20)],
        area: 16.0,
    };
    assert_eq!(validate(&mesh, &e), vec![]);
    assert_eq!(certify(&mesh.points, &mesh.quads), None);
}

#[test]
fn every_kind_of_defect_is_found() {
    let (good, boundary) = grid(4);
    let e = Expectation { boundary: &boundary, area: 16.0, ..Default::default() };
    let v = VertexId::new;
    let inner = 20; // The node in the middle, (2, 2).
    assert_eq!(good.points[inner], Point2::new(2.0, 2.0));

    let mut m = good.clone();
    m.quads[5].reverse();
    let got = names(&m, &e);
    assert!(got.contains(&"Inverted".into()) && got.contains(&"SameDirection".into()), "{got:?}");

    let mut m = good.clone();
    m.quads.remove(5);
    let got = names(&m, &e);
    assert!(got.contains(&"BoundaryExtra".into()) && got.contains(&"Area".into()), "{got:?}");
    assert!(got.contains(&"Euler".into()), "{got:?}");

    let mut m = good.clone();
    m.quads.remove(0);
    let got = names(&m, &e);
    assert!(got.contains(&"BoundaryMissing".into()) && got.contains(&"Unused".into()), "{got:?}");

    // Moved to just beyond the line of its neighbours: concave, not inverted.
    let mut m = good.clone();
    m.points[inner] = Point2::new(2.6, 2.6);
    assert_eq!(validate(&m, &e), vec![MeshDefect::NotConvex { quad: QuadId(10), corner: 0 }]);
    assert_eq!(certify(&m.points, &m.quads), Some(10));

    // Exactly on that line, then a hair inside: convex for the exact predicate, flat for the judge.
    m.points[inner] = Point2::new(2.5, 2.5);
    assert_eq!(validate(&m, &e), vec![MeshDefect::NotConvex { quad: QuadId(10), corner: 0 }]);
    m.points[inner] = Point2::new(2.5, 2.5 - 1e-9);
    assert_eq!(validate(&m, &e), vec![MeshDefect::Flat { quad: QuadId(10), corner: 0 }]);
    assert_eq!(certify(&m.points, &m.quads), None);

    let mut m = good.clone();
    m.points[inner] = Point2::new(2.0, 3.0);
    assert!(names(&m, &e).contains(&"Coincident".into()));

    let mut m = good.clone();
    m.quads[5][0] = m.quads[5][1];
    assert!(names(&m, &e).contains(&"RepeatedVertex".into()));

    let mut m = good.clone();
    m.quads.push(m.quads[5]);
    assert!(names(&m, &e).contains(&"OverShared".into()));

    let mut m = good.clone();
    m.points.push(Point2::new(0.5, 0.5));
    assert_eq!(validate(&m, &e), vec![MeshDefect::Unused(v(25))]);

    let mut m = good.clone();
    m.points[inner].x = f64::NAN;
    assert_eq!(validate(&m, &e), vec![MeshDefect::NotFinite(v(inner))]);

    let mut m = good.clone();
    m.quads[3][2] = v(99);
    assert_eq!(validate(&m, &e), vec![MeshDefect::BadIndex { element: 3, vertex: v(99), n_vertices: 25 }]);

    let more =
        Expectation { scars: &[[v(16), v(20)]], points: &[v(77)], nodes: &[Point2::new(1.0, 0.0)], ..e };
    let want = vec![
        MeshDefect::ScarMissing(v(16), v(20)),
        MeshDefect::PointMissing(v(77)),
        MeshDefect::NodeMoved(v(0)),
    ];
    assert_eq!(validate(&good, &more), want);

    let mut m = good.clone();
    let q = m.quads.remove(0);
    m.triangles = vec![[q[0], q[1], q[2]], [q[0], q[3], q[2]]];
    assert!(names(&m, &e).contains(&"InvertedTriangle".into()));
    m.triangles[1] = [q[0], q[2], q[3]];
    assert_eq!(validate(&m, &e), vec![]);
}

#[test]
fn corners_are_decided_exactly() {
    // Far from the origin the float determinant of the flat corner is noise.
    let o = Point2::new(1e8 + 0.1, -3e7);
    let q = |d: f64| [o, o + Point2::new(2.0, 0.0), o + Point2::new(1.0, 1.0 + d), o + Point2::new(0.0, 2.0)];
    assert!(is_strictly_convex(&q(1e-6)));
    assert!(!is_strictly_convex(&q(-1e-6)));
    let p = q(0.0);
    let exact = orient2d(p[1], p[2], p[3]) > 0.0;
    assert_eq!(is_strictly_convex(&p), exact);
}

proptest! {
    /// The certificate is the predicate on all four corners, whatever the coordinates.
    #[test]
    fn certificate_is_exact(c in prop::collection::vec(-4i32..5, 8), e in -40i32..40) {
        let s = 2f64.powi(e) * 1.1;
        let p: [Point2; 4] = std::array::from_fn(|k| s * Point2::new(c[2 * k].into(), c[2 * k + 1].into()));
        let want = (0..4).all(|k| orient2d(p[k], p[(k + 1) % 4], p[(k + 2) % 4]) > 0.0);
        prop_assert_eq!(is_strictly_convex(&p), want);
    }
}

/// A corner of a cube, open below: three squares. One turned round, one folded, one index too large.
#[test]
fn defects_in_space() {
    let points = [(0., 0.), (1., 0.), (1., 1.), (0., 1.), (1., 0.), (1., 1.), (0., 1.)];
    let heights = [1., 1., 1., 1., 0., 0., 0.];
    let quads = [[0, 1, 2, 3], [1, 4, 5, 2], [2, 5, 6, 3]].map(|q| q.map(VertexId));
    let sound =
        QuadMesh { points: points.map(Point2::from).to_vec(), quads: quads.to_vec(), ..QuadMesh::default() };
    assert_eq!(validate_in_space(&sound, &heights), vec![]);
    let mut turned = sound.clone();
    turned.quads[1].reverse();
    let found = validate_in_space(&turned, &heights);
    assert_eq!(found.len(), 2);
    assert!(found.iter().all(|d| matches!(d, MeshDefect::SameDirection(..))), "{found:?}");
    let mut folded = sound.clone();
    folded.quads[0] = [0, 1, 3, 2].map(VertexId);
    assert!(matches!(validate_in_space(&folded, &heights)[0], MeshDefect::NotConvex { quad: QuadId(0), .. }));
    let mut wild = sound.clone();
    wild.quads[2][1] = VertexId(7);
    assert!(matches!(validate_in_space(&wild, &heights)[..], [MeshDefect::BadIndex { element: 2, .. }]));
    assert!(matches!(validate_in_space(&sound, &[f64::NAN; 7])[0], MeshDefect::NotFinite(VertexId(0))));
}
