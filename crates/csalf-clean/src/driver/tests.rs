use super::*;
use csalf_geom::Point2;
use csalf_mesh::{Expectation, QualityReport, validate};
use csalf_sizemap::Uniform;
use proptest::prelude::*;

fn mesh(points: &[[f64; 2]], quads: &[[u32; 4]]) -> QuadMesh {
    QuadMesh {
        points: points.iter().map(|&p| p.into()).collect(),
        quads: quads.iter().map(|q| q.map(VertexId)).collect(),
        triangles: Vec::new(),
    }
}

/// n x n unit squares.
fn grid(n: u32) -> QuadMesh {
    let points: Vec<_> =
        (0..(n + 1) * (n + 1)).map(|k| [f64::from(k % (n + 1)), f64::from(k / (n + 1))]).collect();
    let quads: Vec<_> = (0..n * n).map(|k| k + k / n).map(|k| [k, k + 1, k + n + 2, k + n + 1]).collect();
    mesh(&points, &quads)
}

/// The directed boundary of a mesh, for comparison with that after a change.
fn boundary(m: &QuadMesh) -> Vec<[VertexId; 2]> {
    let t = QuadTopology::new(m.n_vertices(), &m.quads);
    let half = (0..4 * m.n_quads()).filter(|&h| t.twin[h] == QuadTopology::NONE);
    half.map(|h| [m.quads[h / 4][h % 4], m.quads[h / 4][(h + 1) % 4]]).collect()
}

fn run(m: &mut QuadMesh, h: f64) -> RepairReport {
    repair(m, &mut vec![], &mut vec![], &[], &Uniform(h), &SmoothOptions::default()).0
}

/// Runs the repair and checks that the result is a valid mesh of the same boundary.
fn run_valid(m: &mut QuadMesh, h: f64) -> RepairReport {
    let (nodes, rim) = (m.points.clone(), boundary(m));
    let on = QuadTopology::new(m.n_vertices(), &m.quads).on_boundary;
    let area = QualityReport::new(m, None, None).area;
    let r = run(m, h);
    let new = |v: VertexId| if r.vertices.is_empty() { v } else { VertexId(r.vertices[v.index()]) };
    let rim: Vec<_> = rim.into_iter().map(|s| s.map(new)).collect();
    for (i, p) in nodes.iter().enumerate().filter(|(i, _)| on[*i]) {
        assert_eq!(m.points[new(VertexId::new(i)).index()], *p);
    }
    assert_eq!(validate(m, &Expectation { boundary: &rim, area, ..Expectation::default() }), vec![]);
    r
}

/// Puts a vertex into quad `q` that has only two quads.
fn insert_doublet(m: &mut QuadMesh, q: usize, turned: bool) {
    let [a, b, c, e] = m.quads[q];
    let v = VertexId::new(m.n_vertices());
    m.points.push(0.25 * m.corners(csalf_geom::QuadId::new(q)).iter().sum::<Point2>());
    let (first, second) = if turned { ([v, b, c, e], [v, e, a, b]) } else { ([v, a, b, c], [v, c, e, a]) };
    m.quads[q] = first;
    m.quads.push(second);
}

#[test]
fn a_doublet_is_removed() {
    let mut m = grid(4);
    insert_doublet(&mut m, 5, false);
    let r = run_valid(&mut m, 1.0);
    assert_eq!(r.applied, vec![("doublet", 1), ("singlet", 0)]);
    assert_eq!((m.n_vertices(), m.n_quads()), (25, 16));
    assert_eq!(QualityReport::new(&m, None, None).min_sj, 1.0);
    assert_eq!(
        (r.vertices[24], r.vertices[25], r.quads[4], r.quads[5], r.quads[6]),
        (24, REMOVED, 4, REMOVED, 5)
    );
}

#[test]
fn a_fixed_doublet_and_protected_quads_stay() {
    let mut m = grid(4);
    insert_doublet(&mut m, 5, false);
    let mut fixed = vec![false; 26];
    fixed[25] = true;
    let r = repair(&mut m, &mut fixed, &mut vec![], &[], &Uniform(1.0), &SmoothOptions::default()).0;
    assert_eq!(r.applied[0].1, 0);
    assert!(!r.finish.untangle.is_positive());
    let mut protected = vec![false; 17];
    protected[5] = true;
    let r = repair(&mut m, &mut vec![], &mut protected, &[], &Uniform(1.0), &SmoothOptions::default()).0;
    assert_eq!((r.applied[0].1, m.n_quads(), protected.len()), (0, 17, 17));
}

/// Both neighbours have two quads: a piece of a row is put in.
#[test]
fn a_flat_singlet_gets_a_piece_of_a_row() {
    let p = [[-2., 0.], [-1., 0.], [0., 0.], [1., 0.], [2., 0.], [2., 2.], [0., 2.], [-2., 2.]];
    let mut m = mesh(&p, &[[2, 3, 6, 1], [6, 3, 4, 5], [1, 6, 7, 0]]);
    let r = run_valid(&mut m, 1.0);
    assert_eq!(r.applied, vec![("doublet", 0), ("singlet", 1)]);
    assert_eq!((m.n_vertices(), m.n_quads()), (11, 6));
    assert!(QualityReport::new(&m, None, None).min_sj > 0.6);
}

#[test]
fn a_singlet_over_a_vertex_of_three_edges() {
    let p = [[-2., 0.], [-1., 0.], [0., 0.], [1., 0.], [2., 0.], [0., 2.5], [0., 1.2]];
    let mut m = mesh(&p, &[[2, 3, 6, 1], [6, 3, 4, 5], [1, 6, 5, 0]]);
    let r = run_valid(&mut m, 1.0);
    assert_eq!(r.applied[1], ("singlet", 1));
    // The vertex above the singlet is gone, three are new.
    assert_eq!((m.n_vertices(), m.n_quads(), r.vertices[6]), (9, 5, REMOVED));
}

/// A neighbour has three quads: one edge is rotated, on either side.
#[test]
fn an_edge_is_rotated_where_a_neighbour_can_spare_a_quad() {
    let p = [[-1., 0.], [0., 0.], [1., 0.], [2., 0.], [2., 1.], [1.2, 1.], [0.5, 1.6], [-1., 1.6]];
    let q = [[1, 2, 7, 0], [7, 2, 5, 6], [2, 3, 4, 5]];
    let mut m = mesh(&p, &q);
    let r = run_valid(&mut m, 1.0);
    assert_eq!((r.applied[1], m.n_vertices(), m.n_quads()), (("singlet", 1), 8, 3));
    let mirrored = p.map(|[x, y]| [-x, y]);
    let mut m = mesh(&mirrored, &q.map(|[a, b, c, d]| [a, d, c, b]));
    let r = run_valid(&mut m, 1.0);
    assert_eq!((r.applied[1], m.n_vertices(), m.n_quads()), (("singlet", 1), 8, 3));
}

/// At 168 degrees the mesh is valid without the change; it is kept because the smallest scaled Jacobian
/// rises.
#[test]
fn an_optional_change_must_help() {
    let p = [[-2., 0.], [-1., 0.], [0., -0.1], [1., 0.], [2., 0.], [2., 2.], [0., 2.], [-2., 2.]];
    let q = [[2, 3, 6, 1], [6, 3, 4, 5], [1, 6, 7, 0]];
    let mut m = mesh(&p, &q);
    assert!(QualityReport::new(&m, None, None).min_sj > 0.15);
    assert_eq!(run_valid(&mut m, 1.0).applied[1].1, 1);
    assert!(QualityReport::new(&m, None, None).min_sj > 0.5);
    // Under a low roof there is no room for a row: everything stays as it was.
    let low = p.map(|[x, y]| [x, 0.1 * y]);
    let mut m = mesh(&low, &q);
    let before = QualityReport::new(&m, None, None).min_sj;
    run(&mut m, 1.0);
    assert!(QualityReport::new(&m, None, None).min_sj >= before);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// However many doublets are put in, also into each other, all come out again.
    #[test]
    fn doublets_vanish(at in prop::collection::vec((0..40usize, any::<bool>()), 1..12)) {
        let mut m = grid(5);
        for (q, turned) in at {
            let q = q % m.n_quads();
            insert_doublet(&mut m, q, turned);
        }
        let r = run_valid(&mut m, 1.0);
        prop_assert!(r.applied[0].1 > 0);
        let t = QuadTopology::new(m.n_vertices(), &m.quads);
        prop_assert!((0..m.n_vertices()).all(|v| t.on_boundary[v] || t.n_quads_at(VertexId::new(v)) > 2));
    }
}

/// Node 1 is straight, has one quad, and can borrow one across 0-3 unless that is a scar.
#[test]
fn a_kept_edge_is_not_rotated() {
    let points =
        [[0., 0.], [1., 0.], [2., 0.], [1.2, 1.2], [3., 0.5], [2.4, 1.6], [0., 1.2], [1.0, 2.4], [2.2, 2.6]];
    let m = mesh(&points, &[[0, 1, 2, 3], [2, 4, 5, 3], [0, 3, 7, 6], [3, 5, 8, 7]]);
    let topology = QuadTopology::new(m.n_vertices(), &m.quads);
    let rotates = |kept: &[[VertexId; 2]]| {
        let site = Site { mesh: &m, topology: &topology, fixed: &[], kept };
        Singlet.find(&site).iter().any(|e| e.remove.contains(&0) && e.remove.contains(&2))
    };
    assert!(rotates(&[]));
    assert!(!rotates(&[[VertexId(0), VertexId(3)]]));
}
