use super::*;

/// A cube of two triangles per side, each with its own points, as in a file.
fn cube() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let at = |i: f64, j: f64| {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, i, j);
                DVec3::from_array(p)
            };
            let mut q = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
            if side == 0.0 {
                q.reverse();
            }
            for t in [[0, 1, 2], [0, 2, 3]] {
                let n = points.len() as u32;
                points.extend(t.map(|k: usize| q[k]));
                triangles.push([n, n + 1, n + 2]);
            }
        }
    }
    (points, triangles)
}

#[test]
fn a_cube_has_six_faces_and_twelve_edges() {
    let (points, mut triangles) = cube();
    // One turned over, one twice, one without area.
    triangles[3].swap(0, 1);
    triangles.push(triangles[0]);
    triangles.push([0, 0, 1]);
    let m = model_of_triangles(&points, &triangles, &FacetOptions::default());
    assert_eq!((m.faces.len(), m.edges.len(), m.vertices.len()), (6, 12, 8));
    assert!(m.bodies[0].solid);
    assert!(m.edge_uses().iter().all(|u| u.len() == 2 && u[0].1.forward != u[1].1.forward));
    assert_eq!(m.notes.len(), 2, "{:?}", m.notes);
}

#[test]
fn a_tube_has_closed_edges() {
    let n = 24_u32;
    let ring = |z: f64| {
        (0..n).map(move |k| {
            let (s, c) = (f64::from(k) / f64::from(n) * std::f64::consts::TAU).sin_cos();
            DVec3::new(c, s, z)
        })
    };
    let points: Vec<DVec3> = ring(0.0).chain(ring(1.0)).collect();
    let triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|k| {
            let l = (k + 1) % n;
            [[k, l, n + l], [k, n + l, n + k]]
        })
        .collect();
    let m = model_of_triangles(&points, &triangles, &FacetOptions::default());
    assert_eq!((m.faces.len(), m.edges.len(), m.vertices.len()), (1, 2, 2));
    assert!(m.edges.iter().all(crate::brep::Edge::is_closed));
    assert!(!m.bodies[0].solid);
}

#[test]
fn nothing_is_a_model_without_faces() {
    let m = model_of_triangles(&[], &[], &FacetOptions::default());
    assert!(m.faces.is_empty());
    let m = model_of_triangles(&[DVec3::NAN], &[[0, 0, 7]], &FacetOptions::default());
    assert!(m.faces.is_empty() && m.notes.len() == 1);
}

/// A strip of `n` squares with half a turn in it.
fn moebius(n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let at = |i: u32, side: f64| {
        let turn = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let out = 4.0 + side * (0.5 * turn).cos();
        DVec3::new(out * turn.cos(), out * turn.sin(), side * (0.5 * turn).sin())
    };
    let points = (0..n).flat_map(|i| [at(i, -1.0), at(i, 1.0)]).collect();
    let squares = (0..n).map(|i| {
        let (a, b) = (2 * i, 2 * i + 1);
        // The last meets the first upside down.
        if i + 1 < n { [a, a + 2, b + 2, b] } else { [a, 1, 0, b] }
    });
    (points, squares.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

#[test]
fn a_strip_with_half_a_turn_is_cut_once() {
    let (points, triangles) = moebius(24);
    let model = model_of_triangles(&points, &triangles, &FacetOptions::default());
    assert_eq!(model.faces.len(), 1);
    assert!(!model.bodies[0].solid);
    // One loop: both sides of the cut, and the one rim of the strip in two parts.
    let uses: Vec<usize> = model.edge_uses().iter().map(Vec::len).collect();
    assert_eq!((model.faces[0].loops.len(), model.faces[0].loops[0].uses.len()), (1, 4), "{uses:?}");
    assert_eq!(uses.iter().filter(|n| **n == 2).count(), 1, "{uses:?}");
}

#[test]
fn a_face_without_area_fails_with_the_reason() {
    let points = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
    let model = model_of_triangles(&points, &[[0, 1, 2]], &FacetOptions::default());
    let mesh = crate::mesh_model(&model, &crate::ModelOptions::default());
    assert!(mesh.mesh.quads.is_empty() && model.faces.len() == mesh.failures.len());
    assert!(mesh.failures.iter().all(|f| f.message.contains("no area")), "{:?}", mesh.failures);
    assert_eq!(mesh.failures.len(), 1);
}
