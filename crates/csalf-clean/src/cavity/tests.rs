use super::*;
use csalf_geom::{Point2, QuadId};
use csalf_mesh::{Appraisal, Patch, Refusal, RegionTask, certify};
use csalf_sizemap::Uniform;
use proptest::prelude::*;

/// Fills contours of four given corners and equal opposite counts by bilinear interpolation of the sides.
#[derive(Debug)]
struct Blocks;

impl RegionMesher for Blocks {
    fn name(&self) -> &'static str {
        "blocks"
    }
    fn appraise(&self, _: &RegionTask<'_>) -> Option<Appraisal> {
        None
    }
    fn mesh(&self, task: &RegionTask<'_>) -> Result<Patch, Refusal> {
        let c = task.contour;
        let n = c.len();
        let at: Vec<usize> = (0..n).filter(|&i| c.wanted[i] == 1).collect();
        let [o, right, top, left] = at[..] else { return Err(Refusal::NotApplicable) };
        let (a, b) = (right - o, top - right);
        if left - top != a || 2 * (a + b) != n {
            return Err(Refusal::NotApplicable);
        }
        let ring = |k: usize| ((o + k) % n) as u32;
        let name = |i: usize, j: usize| match (i, j) {
            (i, 0) => ring(i),
            (i, j) if i == a => ring(a + j),
            (i, j) if j == b => ring(a + b + a - i),
            (0, j) => ring(2 * a + b + (b - j)),
            (i, j) => (n + (j - 1) * (a - 1) + i - 1) as u32,
        };
        let mut patch = Patch::default();
        let p = |v: u32| c.points[v as usize];
        for j in 1..b {
            for i in 1..a {
                let (s, t) = (i as f64 / a as f64, j as f64 / b as f64);
                let (u, v) = (p(name(i, 0)).lerp(p(name(i, b)), t), p(name(0, j)).lerp(p(name(a, j)), s));
                patch.points.push(u.midpoint(v));
            }
        }
        for j in 0..b {
            for i in 0..a {
                patch.quads.push([name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)]);
            }
        }
        Ok(patch)
    }
}

/// A grid of n x n unit quads.
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

/// Turns the edge between quads q and q + 1 of a row: two 3-5 pairs. The quads stay convex after smoothing.
fn rotate(mesh: &mut QuadMesh, q: usize) {
    let ([a, b, c, d], [_, e, f, _]) = (mesh.quads[q], mesh.quads[q + 1]);
    mesh.quads[q] = [a, b, e, d];
    mesh.quads[q + 1] = [d, e, f, c];
}

fn task<'a>(
    fixed: &'a [bool],
    protected: &'a [bool],
    kept: &'a [[VertexId; 2]],
    size: &'a Uniform,
) -> CavityTask<'a> {
    let tolerance = Tolerance::of_diagonal(10.0);
    CavityTask { fixed, protected, kept, size, mesher: &Blocks, tolerance, rules: CavityRules::default() }
}

fn smoothed(mut mesh: QuadMesh) -> (QuadMesh, QuadTopology) {
    let t = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
    crate::finish(&mut mesh, &t, &[], &Uniform(1.0), &crate::SmoothOptions::default());
    (mesh, t)
}

#[test]
fn a_turned_edge_is_healed() {
    let mut mesh = grid(10);
    rotate(&mut mesh, 44);
    let (mut mesh, topology) = smoothed(mesh);
    assert_eq!(topology.irregular().len(), 4);
    let r = refill_cavities(&mut mesh, &topology, &task(&[], &[], &[], &Uniform(1.0)));
    assert_eq!(r.n_seeds, 4);
    assert!(r.taken >= 1);
    let topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
    assert!(topology.irregular().is_empty());
    assert_eq!((mesh.n_vertices(), mesh.n_quads()), (121, 100));
    assert_eq!(certify(&mesh.points, &mesh.quads), None);
}

/// A mesher that refuses everything.
#[derive(Debug)]
struct Nobody;

impl RegionMesher for Nobody {
    fn name(&self) -> &'static str {
        "nobody"
    }
    fn appraise(&self, _: &RegionTask<'_>) -> Option<Appraisal> {
        None
    }
    fn mesh(&self, _: &RegionTask<'_>) -> Result<Patch, Refusal> {
        Err(Refusal::NotApplicable)
    }
}

#[test]
fn small_disks_need_no_mesher() {
    let mut mesh = grid(10);
    // A turned edge, a quad put into a quad, and a quad collapsed onto a diagonal.
    rotate(&mut mesh, 44);
    let q = mesh.quads[77];
    let first = mesh.n_vertices();
    let c = mesh.corners(QuadId(77)).iter().sum::<Point2>() * 0.25;
    mesh.points.extend(q.map(|v| c.lerp(mesh.points[v.index()], 0.4)));
    let n = [0, 1, 2, 3].map(|k| VertexId::new(first + k));
    mesh.quads[77] = n;
    for k in 0..4 {
        mesh.quads.push([q[k], q[(k + 1) & 3], n[(k + 1) & 3], n[k]]);
    }
    let (mut mesh, topology) = smoothed(mesh);
    assert_eq!(topology.irregular().len(), 4 + 8);
    let size = Uniform(1.0);
    let mut task = task(&[], &[], &[], &size);
    task.mesher = &Nobody;
    let r = refill_cavities(&mut mesh, &topology, &task);
    assert!(r.small >= 2 && r.small == r.taken, "{r:?}");
    let topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
    assert!(topology.irregular().is_empty(), "{r:?}");
    assert_eq!((mesh.n_vertices(), mesh.n_quads()), (121, 100));
    assert_eq!(certify(&mesh.points, &mesh.quads), None);
}

#[test]
fn protected_quads_and_scars_stay() {
    let mut mesh = grid(10);
    rotate(&mut mesh, 44);
    let (mesh, topology) = smoothed(mesh);
    // The turned quads themselves are protected.
    let mut protected = vec![false; 100];
    (protected[44], protected[45]) = (true, true);
    let mut m = mesh.clone();
    let r = refill_cavities(&mut m, &topology, &task(&[], &protected, &[], &Uniform(1.0)));
    for q in [44usize, 45] {
        let now = r.quads.get(q).copied().unwrap_or(q as u32);
        let name = |v: VertexId| VertexId(r.vertices.get(v.index()).copied().unwrap_or(v.0));
        assert_eq!(m.quads[now as usize], mesh.quads[q].map(name));
    }
    // The turned edge is a scar.
    let [_, b, e, d] = mesh.quads[44];
    let _ = b;
    let mut fixed = vec![false; mesh.n_vertices()];
    (fixed[e.index()], fixed[d.index()]) = (true, true);
    let mut m = mesh.clone();
    let kept = [[e, d]];
    let r = refill_cavities(&mut m, &topology, &task(&fixed, &[], &kept, &Uniform(1.0)));
    let name = |v: VertexId| VertexId(r.vertices.get(v.index()).copied().unwrap_or(v.0));
    let (e, d) = (name(e), name(d));
    assert!(m.quads.iter().any(|q| (0..4).any(|k| q[k] == d && q[(k + 1) % 4] == e)), "the scar is an edge");
    assert_eq!(m.points[e.index()], mesh.points[kept[0][0].index()]);
}

#[test]
fn numbers_of_quads_outside_are_followed() {
    let mut mesh = grid(10);
    rotate(&mut mesh, 44);
    let (mut mesh, topology) = smoothed(mesh);
    let far = mesh.corners(QuadId(99)).iter().sum::<Point2>();
    let r = refill_cavities(&mut mesh, &topology, &task(&[], &[], &[], &Uniform(1.0)));
    let q = r.quads.get(99).copied().unwrap_or(99);
    assert_eq!(mesh.corners(QuadId(q)).iter().sum::<Point2>(), far);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn never_worse(
        edges in proptest::collection::vec((1..9u32, 1..8u32), 1..6),
        shake in proptest::collection::vec((-0.2..0.2f64, -0.2..0.2f64), 121),
    ) {
        let mut mesh = grid(10);
        let mut used = [false; 100];
        for (j, i) in edges {
            let q = (10 * j + i) as usize;
            if !used[q] && !used[q + 1] {
                (used[q], used[q + 1]) = (true, true);
                rotate(&mut mesh, q);
            }
        }
        for (p, s) in mesh.points.iter_mut().zip(&shake) {
            if (0.5..9.5).contains(&p.x) && (0.5..9.5).contains(&p.y) {
                *p += Point2::new(s.0, s.1);
            }
        }
        let (mut mesh, topology) = smoothed(mesh);
        prop_assume!(certify(&mesh.points, &mesh.quads).is_none());
        let min = |m: &QuadMesh| {
            m.quads.iter().map(|q| Corners::new(&q.map(|v| m.points[v.index()])).min_scaled()).fold(1.0, f64::min)
        };
        let rim: Vec<Point2> = (0..11).map(|i| mesh.points[i]).collect();
        let before = (topology.irregular().len(), min(&mesh));
        let mut again = mesh.clone();
        let size = Uniform(1.0);
        let r = refill_cavities(&mut mesh, &topology, &task(&[], &[], &[], &size));
        prop_assert_eq!(r.clone(), refill_cavities(&mut again, &topology, &task(&[], &[], &[], &size)));
        prop_assert_eq!(&again, &mesh);
        let topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
        prop_assert_eq!(topology.n_bad_edges, 0);
        prop_assert!(certify(&mesh.points, &mesh.quads).is_none());
        prop_assert_eq!(topology.on_boundary.iter().filter(|b| **b).count(), 40);
        prop_assert!(rim.iter().enumerate().all(|(i, p)| mesh.points[i] == *p));
        if r.taken > 0 {
            prop_assert!(topology.irregular().len() < before.0 || r.n_seeds > before.0);
        }
        prop_assert!(min(&mesh) >= before.1.min(0.3), "{} after {}", min(&mesh), before.1);
        // Euler: V - E + F = 1 with E = (4 F + 40) / 2.
        prop_assert_eq!(mesh.n_vertices() as i64, mesh.n_quads() as i64 + 21);
    }
}
