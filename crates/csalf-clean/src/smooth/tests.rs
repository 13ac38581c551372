use super::*;
use csalf_geom::Point2;
use csalf_mesh::QualityReport;
use csalf_sizemap::{Hint, Uniform};
use proptest::prelude::*;

/// A small generator of numbers in -1 to 1.
struct Rng(u64);
impl Rng {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    fn point(&mut self) -> Point2 {
        Point2::new(self.next(), self.next())
    }
}

fn ids(e: [usize; 4]) -> [VertexId; 4] {
    e.map(VertexId::new)
}

/// n x m unit squares.
fn grid(n: usize, m: usize) -> QuadMesh {
    let mut mesh = QuadMesh::default();
    for j in 0..=m {
        for i in 0..=n {
            mesh.points.push(Point2::new(i as f64, j as f64));
        }
    }
    for j in 0..m {
        for i in 0..n {
            let k = j * (n + 1) + i;
            mesh.quads.push(ids([k, k + 1, k + n + 2, k + n + 1]));
        }
    }
    mesh
}

/// A unit disk: a square core of n x n quads and rings of 4 n quads around it; four inner vertices of valence
/// 3.
fn disk(n: usize) -> QuadMesh {
    let mut mesh = grid(n, n);
    let c = 0.4;
    for p in &mut mesh.points {
        *p = (*p / n as f64 * 2.0 - Point2::ONE) * c;
    }
    let at = |i: usize, j: usize| j * (n + 1) + i;
    let mut rim: Vec<usize> = Vec::new();
    rim.extend((0..n).map(|i| at(i, 0)));
    rim.extend((0..n).map(|j| at(n, j)));
    rim.extend((1..=n).rev().map(|i| at(i, n)));
    rim.extend((1..=n).rev().map(|j| at(0, j)));
    let start = rim.clone();
    let rows = n / 2 + 1;
    for r in 1..=rows {
        let f = r as f64 / rows as f64;
        let base = mesh.points.len();
        for (k, &v) in start.iter().enumerate() {
            let t = std::f64::consts::TAU * (k as f64 / (4 * n) as f64 - 0.375);
            let out = Point2::new(t.cos(), t.sin());
            mesh.points.push(mesh.points[v].lerp(out, f));
        }
        for k in 0..4 * n {
            let l = (k + 1) % (4 * n);
            mesh.quads.push(ids([rim[k], base + k, base + l, rim[l]]));
        }
        rim = (base..base + 4 * n).collect();
    }
    mesh
}

/// Rings of `n` quads between radius 1 and (1 + 2 pi / n)^rows, as thick as their chords are long.
fn annulus(n: usize, rows: usize) -> QuadMesh {
    let mut mesh = QuadMesh::default();
    for k in 0..=rows {
        let r = (1.0 + std::f64::consts::TAU / n as f64).powi(k as i32);
        for i in 0..n {
            let t = std::f64::consts::TAU * i as f64 / n as f64;
            mesh.points.push(r * Point2::new(t.cos(), t.sin()));
        }
    }
    for k in 0..rows {
        for i in 0..n {
            let j = (i + 1) % n;
            mesh.quads.push(ids([k * n + i, (k + 1) * n + i, (k + 1) * n + j, k * n + j]));
        }
    }
    mesh
}

/// Moves the inner vertices by up to `by` each way.
fn shake(mesh: &mut QuadMesh, by: f64, seed: u64) {
    let t = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
    let mut rng = Rng(seed);
    for (p, &b) in mesh.points.iter_mut().zip(&t.on_boundary) {
        if !b {
            *p += by * rng.point();
        }
    }
}

/// Wanted length proportional to the distance from the origin.
#[derive(Debug)]
struct Radial(f64);
impl SizeField for Radial {
    fn h(&self, p: Point2, _: &mut Hint) -> f64 {
        self.0 * p.length().max(0.1)
    }
    fn range(&self) -> (f64, f64) {
        (0.1 * self.0, 1e3 * self.0)
    }
}

fn topology(mesh: &QuadMesh) -> QuadTopology {
    QuadTopology::new(mesh.n_vertices(), &mesh.quads)
}

fn quality(mesh: &QuadMesh, size: &dyn SizeField) -> (f64, f64, csalf_mesh::quality::SizeConformity) {
    let r = QualityReport::new(mesh, Some(size), None);
    (r.min_sj, r.mean_sj, r.size.unwrap())
}

#[test]
fn a_shaken_grid_becomes_a_grid_again() {
    let mut mesh = grid(40, 30);
    shake(&mut mesh, 0.3, 1);
    let before = quality(&mesh, &Uniform(1.0));
    let t = topology(&mesh);
    let r = finish(&mut mesh, &t, &[], &Uniform(1.0), &SmoothOptions::default());
    let after = quality(&mesh, &Uniform(1.0));
    assert!(r.smooth.n_free > 1000 && r.smooth.min_sj.1 >= r.smooth.min_sj.0);
    assert!(before.0 < 0.3 && after.0 > 0.98, "{before:?} {after:?}");
    assert!(after.1 > 0.999 && after.2.share == 1.0 && after.2.rms_log < 0.02);
}

#[test]
fn a_disk_improves_in_every_figure() {
    let mut mesh = disk(16);
    let size = Uniform(1.0 / 16.0);
    let t = topology(&mesh);
    let drawn = quality(&mesh, &size);
    let options = SmoothOptions { threshold: 2.0, lambda: 0.3, ..SmoothOptions::default() };
    smooth(&mut mesh, &t, &[], &size, &options);
    let from_drawn = quality(&mesh, &size);
    assert!(from_drawn.0 > drawn.0 + 0.1 && from_drawn.1 > drawn.1 + 0.008, "{drawn:?} {from_drawn:?}");
    assert!(from_drawn.2.rms_log <= drawn.2.rms_log);
    // From far worse positions to the same place.
    shake(&mut mesh, 0.02, 3);
    assert!(quality(&mesh, &size).0 < 0.3);
    finish(&mut mesh, &t, &[], &size, &options);
    let again = quality(&mesh, &size);
    assert!(
        (again.0 - from_drawn.0).abs() < 0.04 && (again.1 - from_drawn.1).abs() < 0.002,
        "{again:?} {from_drawn:?}"
    );
}

#[test]
fn an_annulus_keeps_its_grading() {
    let mut mesh = annulus(60, 30);
    let size = Radial(std::f64::consts::TAU / 60.0);
    let drawn = mesh.clone();
    shake(&mut mesh, 0.04, 2);
    finish(&mut mesh, &topology(&drawn), &[], &size, &SmoothOptions::default());
    let (min, mean, s) = quality(&mesh, &size);
    assert!(min > 0.85 && mean > 0.99 && s.share == 1.0 && s.mean_log.abs() < 0.05, "{min} {mean} {s:?}");
}

#[test]
fn a_tangled_grid_is_untangled() {
    for (n, seed) in [(5, 1), (10, 2), (20, 3), (20, 4), (40, 5)] {
        let mut mesh = grid(n, n);
        let t = topology(&mesh);
        let mut rng = Rng(seed);
        for (p, &b) in mesh.points.iter_mut().zip(&t.on_boundary) {
            if !b {
                *p = (rng.point() + Point2::ONE) * 0.5 * n as f64;
            }
        }
        let r = untangle(&mut mesh, &t, &[], &Uniform(1.0), &SmoothOptions::default());
        assert!(r.n_bad_before > 0 && r.is_positive() && r.outer_iterations <= 10, "{r:?}");
        assert_eq!(csalf_mesh::certify(&mesh.points, &mesh.quads), None);
    }
}

/// A fixed vertex outside the domain: its quad in the corner cannot be repaired, the others can.
#[test]
fn what_cannot_be_untangled_is_reported_and_left_alone() {
    let mut mesh = grid(6, 6);
    mesh.points[8] = Point2::new(-0.5, 0.5);
    let mut fixed = vec![false; mesh.n_vertices()];
    fixed[8] = true;
    let t = topology(&mesh);
    let before = bad_quads(&mesh, FLAT);
    let r = finish(&mut mesh, &t, &fixed, &Uniform(1.0), &SmoothOptions::default());
    assert!(!before.is_empty() && !r.untangle.is_positive());
    assert_eq!(mesh.points[8], Point2::new(-0.5, 0.5));
    assert!(bad_quads(&mesh, FLAT).iter().all(|q| before.contains(q)));
}

#[test]
fn work_stays_where_it_is_needed() {
    let mut mesh = grid(60, 60);
    mesh.points[30 * 61 + 30] += Point2::new(0.4, 0.4);
    let before = mesh.clone();
    let r = smooth(&mut mesh, &topology(&before), &[], &Uniform(1.0), &SmoothOptions::default());
    assert!(r.n_seeds == 4 && r.n_free == 49, "{r:?}");
    assert!(mesh.points.iter().zip(&before.points).filter(|(a, b)| a != b).count() <= 49);
    assert!(r.min_sj.1 > 0.99);
    let r = smooth(&mut mesh, &topology(&before), &[], &Uniform(1.0), &SmoothOptions::default());
    assert_eq!((r.n_seeds, r.n_free, r.min_sj), (0, 0, (1.0, 1.0)));
}

/// Rows of quads one long and a quarter high, shaken: with boxes they come back, without they become
/// squarish.
#[test]
fn boxes_keep_layers() {
    let mut mesh = grid(12, 12);
    for p in &mut mesh.points {
        // Four thin rows below eight normal ones.
        p.y = if p.y < 4.0 { 0.25 * p.y } else { p.y - 3.0 };
    }
    let drawn = mesh.clone();
    shake(&mut mesh, 0.06, 8);
    let t = topology(&mesh);
    let options = SmoothOptions { threshold: 2.0, sweeps: 40, ..SmoothOptions::default() };
    let boxes = |q: QuadId| (q.0 < 48).then_some([1.0, 0.25]);
    let off =
        |m: &QuadMesh| m.points.iter().zip(&drawn.points).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    let mut boxed = mesh.clone();
    smooth_boxed(&mut boxed, &t, &[], &Uniform(1.0), &boxes, &options);
    smooth(&mut mesh, &t, &[], &Uniform(1.0), &options);
    assert!(off(&boxed) < 0.05, "{}", off(&boxed));
    assert!(off(&mesh) > 0.1, "{}", off(&mesh));
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let mut mesh = grid(150, 150);
    shake(&mut mesh, 0.45, 9);
    let t = topology(&mesh);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut m = mesh.clone();
        let r = pool.install(|| finish(&mut m, &t, &[], &Radial(0.01), &SmoothOptions::default()));
        (m, r)
    };
    let one = run(1);
    assert!(one.1.untangle.n_bad_before > 100 && one.1.untangle.is_positive(), "{:?}", one.1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(4));
}

#[test]
fn derivatives_are_those_of_the_value() {
    let mut mesh = disk(4);
    shake(&mut mesh, 0.03, 5);
    let t = topology(&mesh);
    let all: Vec<u32> = (0..mesh.n_quads() as u32).collect();
    let free = grow(&mesh, &t, &[], &all, 0);
    let mut region = Region::new(&mesh, &t, &free, &mut Scratch::new(&mesh));
    region.set_sizes(&Uniform(0.3));
    // Different lengths along the two directions, to test those too.
    for i in &mut region.inverse {
        i[1] *= 1.3;
    }
    let e = 1e-6;
    let weights = Weights { lambda: 0.3, power: 5 };
    let near = |a: f64, b: f64, scale: f64| assert!((a - b).abs() < 1e-5 * scale, "{a} {b}");
    for v in 0..region.n_free as u32 {
        let p = region.points[v as usize];
        let at = |x: f64, y: f64| energy::local(&region, v, p + Point2::new(x, y), weights);
        let c = at(0.0, 0.0);
        if c.min_d < 0.1 {
            continue;
        }
        let (r, l, u, d) = (at(e, 0.0), at(-e, 0.0), at(0.0, e), at(0.0, -e));
        let scale = c.hessian[0] + c.hessian[2];
        near(c.gradient.x, (r.value - l.value) / (2.0 * e), scale);
        near(c.gradient.y, (u.value - d.value) / (2.0 * e), scale);
        near(c.hessian[0], (r.gradient.x - l.gradient.x) / (2.0 * e), scale);
        near(c.hessian[1], (r.gradient.y - l.gradient.y) / (2.0 * e), scale);
        near(c.hessian[2], (u.gradient.y - d.gradient.y) / (2.0 * e), scale);
        assert!(c.hessian[0] * c.hessian[2] > c.hessian[1] * c.hessian[1], "the energy is convex");
        near(c.value, energy::trial(&region, v, p, weights, 0.0).0, c.value);
    }
    // The regularised energy of the whole, also where quads are inverted.
    region.points[0] += Point2::new(0.4, 0.3);
    let mut x = region.points[..region.n_free].to_vec();
    let mut g = vec![Point2::ZERO; x.len()];
    let mut other = g.clone();
    let (_, min_d) = energy::regularised(&region, &x, 0.3, 0.2, &mut g);
    assert!(min_d < 0.0);
    for v in 0..x.len() {
        let p = x[v];
        let mut at = |d: Point2| {
            x[v] = p + d;
            energy::regularised(&region, &x, 0.3, 0.2, &mut other).0
        };
        let got = Point2::new(
            at(Point2::new(e, 0.0)) - at(Point2::new(-e, 0.0)),
            at(Point2::new(0.0, e)) - at(Point2::new(0.0, -e)),
        ) / (2.0 * e);
        x[v] = p;
        assert!(got.distance(g[v]) < 1e-4 * (1.0 + g[v].length()), "{got} {}", g[v]);
    }
}

#[test]
fn lbfgs_finds_the_bottom_of_a_banana() {
    let mut x = [Point2::new(-1.2, 1.0), Point2::new(3.0, -2.0)];
    let value = lbfgs::minimise(&mut x, 200, 0.1, 0.0, |x, g| {
        let mut sum = 0.0;
        for (p, g) in x.iter().zip(g) {
            let (a, b) = (1.0 - p.x, p.y - p.x * p.x);
            sum += a * a + 100.0 * b * b;
            *g = Point2::new(-2.0 * a - 400.0 * p.x * b, 200.0 * b);
        }
        sum
    });
    assert!(value < 1e-12 && x.iter().all(|p| p.distance(Point2::ONE) < 1e-5), "{value} {x:?}");
}

/// A shaken pattern with some vertices fixed.
fn pattern() -> impl Strategy<Value = (QuadMesh, Vec<bool>)> {
    (0..3usize, 3..9usize, 0.0..0.9f64, any::<u64>(), 0..4usize).prop_map(|(kind, n, by, seed, fix)| {
        let (mut mesh, l) = match kind {
            0 => (grid(n, n + 2), 1.0),
            1 => (disk(n), 0.8 / n as f64),
            _ => (annulus(2 * n, n), 6.0 / (2 * n) as f64),
        };
        shake(&mut mesh, by * l, seed);
        let fixed = (0..mesh.n_vertices()).map(|i| fix > 0 && i % 7 == fix).collect();
        (mesh, fixed)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn fixed_stays_fixed_and_nothing_turns_over((mesh, fixed) in pattern(), whole in any::<bool>()) {
        let t = topology(&mesh);
        let mut m = mesh.clone();
        let threshold = if whole { 2.0 } else { 0.7 };
        let options = SmoothOptions { threshold, ..SmoothOptions::default() };
        let bad = bad_quads(&mesh, FLAT);
        let r = finish(&mut m, &t, &fixed, &Uniform(0.3), &options);
        for (i, (a, b)) in m.points.iter().zip(&mesh.points).enumerate() {
            prop_assert!(a.is_finite());
            prop_assert!(a == b || !(fixed[i] || t.on_boundary[i]));
        }
        prop_assert!(bad_quads(&m, FLAT).iter().all(|q| bad.contains(q)));
        prop_assert_eq!(r.untangle.n_bad_before, bad.len());
        let min = |m: &QuadMesh| QualityReport::new(m, None, None).min_sj;
        if bad.is_empty() {
            prop_assert!(min(&m) >= min(&mesh) - 1e-12, "{} {}", min(&m), min(&mesh));
        }
    }

    /// Scaling by a power of two changes no bit but the exponents; moving changes nothing beyond rounding.
    #[test]
    fn place_and_scale_do_not_matter((mesh, fixed) in pattern(), e in -30i32..30) {
        let t = topology(&mesh);
        let s = 2f64.powi(e);
        let o = Point2::new(3.0, -5.0);
        let run = |f: &dyn Fn(Point2) -> Point2, h: f64| {
            let mut m = mesh.clone();
            m.points.iter_mut().for_each(|p| *p = f(*p));
            finish(&mut m, &t, &fixed, &Uniform(h), &SmoothOptions::default());
            m
        };
        let base = run(&|p| p, 0.3);
        let scaled = run(&|p| s * p, 0.3 * s);
        prop_assert!(base.points.iter().zip(&scaled.points).all(|(a, b)| s * *a == *b));
        // A tangled start may end elsewhere after a change in the last digit; a sound one may not.
        if bad_quads(&mesh, 0.2).is_empty() {
            let moved = run(&|p| p + o, 0.3);
            prop_assert!(base.points.iter().zip(&moved.points).all(|(a, b)| (*a + o).distance(*b) < 1e-6));
        }
    }
}

/// Beside a fixed vertex close to the wall the energies of shape and size stop early; angles can do better.
#[test]
fn lifting_raises_the_worst_corner_and_nothing_else_moves() {
    let mut mesh = grid(20, 8);
    let near = 4 * 21 + 10;
    mesh.points[near] = Point2::new(10.4, 0.3);
    let mut fixed = vec![false; mesh.n_vertices()];
    fixed[near] = true;
    let t = topology(&mesh);
    finish(&mut mesh, &t, &fixed, &Uniform(1.0), &SmoothOptions::default());
    let min = |m: &QuadMesh| QualityReport::new(m, None, None).min_sj;
    let (before, old) = (min(&mesh), mesh.clone());
    assert!(before > 0.0);
    assert!(lift(&mut mesh, &t, &fixed, 0.9, 3) > 0);
    assert!(min(&mesh) > 1.2 * before, "{} {before}", min(&mesh));
    assert_eq!(mesh.points[near], old.points[near]);
    assert!((0..mesh.n_vertices()).all(|v| !t.on_boundary[v] || mesh.points[v] == old.points[v]));
    assert_eq!(lift(&mut mesh.clone(), &t, &fixed, 0.0, 3), 0);
}

/// All corners look well, but one side has nearly vanished.
#[test]
fn lifting_opens_a_vanished_side() {
    let mut mesh = grid(8, 8);
    let (a, b) = (4 * 9 + 4, 4 * 9 + 5);
    mesh.points[b] = mesh.points[a] + Point2::new(2e-4, 0.0);
    let t = topology(&mesh);
    assert!(QualityReport::new(&mesh, None, None).min_sj > 0.7);
    assert_eq!(lift(&mut mesh, &t, &[], 0.25, 3), 1);
    assert!(mesh.points[a].distance(mesh.points[b]) > 0.25);
    assert!(QualityReport::new(&mesh, None, None).min_sj > 0.7);
}
