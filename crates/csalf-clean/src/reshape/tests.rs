use super::*;
use crate::smooth::lift;
use csalf_geom::Point2;
use csalf_sizemap::Uniform;

/// n x n unit quads.
fn grid(n: u32) -> QuadMesh {
    let v = |i, j| VertexId(j * (n + 1) + i);
    QuadMesh {
        points: (0..=n).flat_map(|j| (0..=n).map(move |i| Point2::new(f64::from(i), f64::from(j)))).collect(),
        quads: (0..n)
            .flat_map(|j| (0..n).map(move |i| [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)]))
            .collect(),
        triangles: Vec::new(),
    }
}

fn min_sj(mesh: &QuadMesh) -> f64 {
    let of = |q: &[VertexId; 4]| Corners::new(&q.map(|v| mesh.points[v.index()])).min_scaled();
    mesh.quads.iter().map(of).fold(1.0, f64::min)
}

/// A grid whose second quad in the lowest row has given the lower left one's upper edge end away: the boundary node
/// (1, 0) has one quad, at an angle of nearly 180°.
fn with_a_singlet() -> QuadMesh {
    let mut mesh = grid(6);
    let ([a, b, c, d], [_, e, f, _]) = (mesh.quads[0], mesh.quads[1]);
    mesh.quads[0] = [a, b, e, d];
    mesh.quads[1] = [d, e, f, c];
    mesh.points[b.index()] += Point2::new(0.0, -0.1);
    mesh
}

fn run(mesh: &mut QuadMesh, protected: &[bool], kept: &[[VertexId; 2]]) -> ReshapeReport {
    let mut topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
    let mut fixed = vec![false; mesh.n_vertices()];
    kept.iter().flatten().for_each(|v| fixed[v.index()] = true);
    let mut protected = protected.to_vec();
    let task = ReshapeTask { kept, size: &Uniform(1.0), tolerance: Tolerance::of_diagonal(10.0) };
    crate::finish(mesh, &topology, &fixed, &Uniform(1.0), &crate::SmoothOptions::default());
    lift(mesh, &topology, &fixed, POOR, 3);
    let report = reshape(mesh, &mut topology, &mut fixed, &mut protected, &task);
    assert_eq!(topology.twin, QuadTopology::new(mesh.n_vertices(), &mesh.quads).twin);
    assert_eq!((fixed.len(), protected.len()), (mesh.n_vertices(), mesh.n_quads()));
    assert_eq!(csalf_mesh::certify(&mesh.points, &mesh.quads), None);
    report
}

#[test]
fn a_flat_corner_at_the_boundary_is_given_two_quads() {
    let mut mesh = with_a_singlet();
    let before = mesh.clone();
    assert!(min_sj(&mesh) < 0.2, "{}", min_sj(&mesh));
    let report = run(&mut mesh, &[], &[]);
    assert!(report.taken >= 1 && min_sj(&mesh) > 0.6, "{report:?} {}", min_sj(&mesh));
    // The boundary is the same, and where nothing was poor, all is.
    let rim = |i: usize| i < 7 || i.is_multiple_of(7) || i % 7 == 6 || i >= 42;
    assert!((0..49).filter(|&i| rim(i)).all(|i| mesh.points[i] == before.points[i]));
    let mut again = before;
    assert_eq!(run(&mut again, &[], &[]), report);
    assert_eq!(again, mesh);
}

#[test]
fn what_is_protected_or_kept_stays() {
    let mut protected = vec![false; 36];
    (protected[0], protected[1]) = (true, true);
    let mut mesh = with_a_singlet();
    let poor = [mesh.quads[0], mesh.quads[1]];
    run(&mut mesh, &protected, &[]);
    assert_eq!([mesh.quads[0], mesh.quads[1]], poor);
    let mut mesh = with_a_singlet();
    let kept = [[mesh.quads[0][2], mesh.quads[0][3]]];
    let ends = kept[0].map(|v| mesh.points[v.index()]);
    run(&mut mesh, &[], &kept);
    let is = |v: VertexId, p: Point2| mesh.points[v.index()] == p;
    let edge = |q: &[VertexId; 4]| (0..4).any(|k| is(q[k], ends[0]) && is(q[(k + 1) & 3], ends[1]));
    assert!(mesh.quads.iter().any(edge), "the scar is an edge");
}

#[test]
fn nothing_happens_to_a_good_mesh() {
    let mut mesh = grid(5);
    let report = run(&mut mesh, &[], &[]);
    assert_eq!(report, ReshapeReport::default());
    assert_eq!(mesh, grid(5));
}
