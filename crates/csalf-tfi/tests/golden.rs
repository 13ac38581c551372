//! Golden fills (handbook 13.2.7, A.12 - A.15) and properties of every filled pattern.

use csalf_geom::{Point2, Tolerance, VertexId};
use csalf_mesh::{Contour, Patch, QuadTopology, RegionMesher, RegionTask};
use csalf_sizemap::{SizeField, Uniform};
use csalf_tfi::quality::{Shape, shape};
use csalf_tfi::{TfiRules, Transfinite};

fn polygon(corners: &[(f64, f64)], counts: &[usize]) -> Vec<Point2> {
    let n = corners.len();
    (0..n)
        .flat_map(|i| {
            let (a, b) = (Point2::from(corners[i]), Point2::from(corners[(i + 1) % n]));
            (0..counts[i]).map(move |k| a.lerp(b, k as f64 / counts[i] as f64))
        })
        .collect()
}

fn circle(n: usize) -> Vec<Point2> {
    (0..n).map(|i| Point2::from_angle(std::f64::consts::TAU * i as f64 / n as f64)).collect()
}

/// The thresholds of handbook 5.6, for which its golden numbers were measured.
fn handbook() -> TfiRules {
    TfiRules { size_error: 1.35, worst_size_error: 2.9, ..TfiRules::default() }
}

fn mesh(points: &[Point2], size: &dyn SizeField, rules: TfiRules) -> Option<(Patch, Shape, usize)> {
    let contour = Contour::from_ring(points, 1.0);
    let tolerance = Tolerance::of_points(points.iter().copied());
    let patch = Transfinite::new(rules).mesh(&RegionTask { contour: &contour, size, tolerance }).ok()?;
    let mut all = points.to_vec();
    all.extend(&patch.points);
    let quads: Vec<[VertexId; 4]> = patch.quads.iter().map(|q| q.map(VertexId)).collect();
    let topology = QuadTopology::new(all.len(), &quads);
    assert_eq!(topology.n_bad_edges, 0);
    let rim = topology.twin.iter().filter(|&&t| t == QuadTopology::NONE).count();
    assert_eq!(rim, points.len(), "the boundary of the patch is the contour");
    let edges = (4 * quads.len() + rim) / 2;
    assert_eq!(all.len() + quads.len(), edges + 1, "Euler: a disk");
    Some((patch.clone(), shape(&all, &patch.quads), topology.irregular().len()))
}

#[test]
fn square_is_a_lattice() {
    let p = polygon(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)], &[12; 4]);
    let (patch, s, irregular) = mesh(&p, &Uniform(1.0 / 12.0), handbook()).unwrap();
    assert_eq!((patch.quads.len(), irregular), (144, 0));
    assert!(s.min_sj > 1.0 - 1e-9);
    let (paper, ..) = mesh(&p, &Uniform(1.0 / 12.0), TfiRules::paper()).unwrap();
    assert_eq!(paper, patch);
}

#[test]
fn triangle_has_one_irregular_vertex() {
    let p = polygon(&[(0., 0.), (1., 0.), (0.5, 0.75f64.sqrt())], &[16; 3]);
    let (patch, s, irregular) = mesh(&p, &Uniform(1.0 / 16.0), handbook()).unwrap();
    assert_eq!((patch.quads.len(), irregular), (192, 1));
    assert!(s.min_sj > 0.85, "{s:?}");
    assert!(mesh(&p, &Uniform(1.0 / 16.0), TfiRules::paper()).is_none());
}

#[test]
fn pentagon_is_five_blocks() {
    let corners: Vec<(f64, f64)> = circle(5).iter().map(|p| (p.x, p.y)).collect();
    let (patch, s, irregular) = mesh(&polygon(&corners, &[6; 5]), &Uniform(0.19), handbook()).unwrap();
    assert_eq!((patch.quads.len(), irregular), (45, 1));
    assert!(s.min_sj > 0.9, "{s:?}");
}

#[test]
fn contours_that_are_not_patches_are_refused() {
    let l = [(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)];
    assert!(mesh(&polygon(&l, &[8, 4, 4, 4, 4, 8]), &Uniform(0.25), handbook()).is_none());
    let odd = polygon(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)], &[3, 2, 2, 2]);
    assert!(mesh(&odd, &Uniform(0.5), handbook()).is_none());
}

#[test]
fn disc_has_four_irregular_vertices() {
    let (patch, s, irregular) = mesh(&circle(48), &Uniform(0.105), handbook()).unwrap();
    assert_eq!(irregular, 4);
    assert!(s.min_sj > 0.7 && s.mean_sj > 0.97, "{} quads, {s:?}", patch.quads.len());
}

#[derive(Debug)]
struct Diagonal;
impl SizeField for Diagonal {
    fn h(&self, p: Point2, _: &mut csalf_sizemap::Hint) -> f64 {
        0.35 + 0.12 * (p.x + p.y)
    }
    fn range(&self) -> (f64, f64) {
        (0.35, 2.75)
    }
}

/// Handbook 13.2.7: the graded square, sides 15, 6, 6, 15, sizes 0.35 to 2.7, is one diag35.
#[test]
fn graded_square_is_one_pattern() {
    let corners = [(0., 0.), (10., 0.), (10., 10.), (0., 10.)].map(Point2::from);
    let mut points = Vec::new();
    for (i, n) in [15usize, 6, 6, 15].into_iter().enumerate() {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        let line = csalf_sizemap::line::LineSizes::new(a, b, &Diagonal, &mut csalf_sizemap::Hint::default());
        points.push(a);
        points.extend((1..n).map(|k| a.lerp(b, line.parameter(k, n - 1))));
    }
    let (patch, s, irregular) = mesh(&points, &Diagonal, handbook()).unwrap();
    assert_eq!((patch.quads.len(), irregular), (90, 2));
    assert!(s.min_sj > 0.8, "{s:?}");
    assert!(mesh(&points, &Diagonal, TfiRules::paper()).is_none());
}

/// The start node, the place, the rotation and the scale do not matter beyond rounding.
#[test]
fn frame_does_not_matter() {
    let p = polygon(&[(0., 0.), (3., 0.), (2.5, 2.4), (0., 2.)], &[20, 15, 17, 14]);
    let (_, base, n) = mesh(&p, &Uniform(0.15), handbook()).unwrap();
    let turned: Vec<Point2> = (0..p.len())
        .map(|i| {
            let q = p[(i + 23) % p.len()];
            Point2::new(0.6 * q.x - 0.8 * q.y, 0.8 * q.x + 0.6 * q.y) * 8.0 + Point2::new(100.0, -50.0)
        })
        .collect();
    let (_, other, m) = mesh(&turned, &Uniform(1.2), handbook()).unwrap();
    assert_eq!(n, m);
    assert!((base.min_sj - other.min_sj).abs() < 1e-6, "{base:?} {other:?}");
}

/// An annulus cut open by a bridge whose nodes occur twice: one block, closed on itself.
#[test]
fn bridged_annulus_is_an_o_grid() {
    let mut c = Contour::default();
    let mut push = |r: f64, k: usize, id: usize| {
        let p = Point2::from_angle(std::f64::consts::TAU * (k % 32) as f64 / 32.0) * r;
        c.push(p, id as u32, 0.25, Default::default());
    };
    (0..=32).for_each(|k| push(2.0, k, k % 32));
    (1..5).for_each(|k| push(2.0 - 0.2 * k as f64, 0, 100 + k));
    (0..=32).rev().for_each(|k| push(1.0, k, 200 + k % 32));
    (1..5).rev().for_each(|k| push(2.0 - 0.2 * k as f64, 0, 100 + k));
    let tolerance = Tolerance::of_points(c.points.iter().copied());
    let task = RegionTask { contour: &c, size: &Uniform(0.25), tolerance };
    let appraisal = Transfinite::default().appraise(&task).unwrap();
    assert!(appraisal.min_sj > 0.9, "the coarse trial sees the bend: {appraisal:?}");
    let patch = Transfinite::default().mesh(&task).unwrap();
    assert_eq!(patch.quads.len(), 32 * 5);
    let all: Vec<Point2> = c.points.iter().chain(&patch.points).copied().collect();
    assert!(shape(&all, &patch.quads).min_sj > 0.99);
}

proptest::proptest! {
    /// Whatever comes in, what comes out is valid (checked in `mesh`), strictly convex and never a panic.
    #[test]
    fn random_rings(
        radii in proptest::collection::vec(0.2f64..1.0, 4..60),
        smooth in 0.0f64..1.0,
        h in 0.01f64..1.0,
    ) {
        let n = radii.len();
        let p: Vec<Point2> = (0..n)
            .map(|i| {
                let r = smooth + (1.0 - smooth) * radii[i];
                Point2::from_angle(std::f64::consts::TAU * i as f64 / n as f64) * r
            })
            .collect();
        let rules = TfiRules { size_error: 1e9, worst_size_error: 1e9, ..TfiRules::relaxed() };
        if let Some((_, s, _)) = mesh(&p, &Uniform(h), rules) {
            proptest::prop_assert!(s.min_sj > 0.0);
        }
    }
}

/// A recipe makes the patch that planning makes, and one of another contour does no harm.
#[test]
fn recipes_make_the_same_patch() {
    let tfi = Transfinite::default();
    let shapes = [
        polygon(&[(0., 0.), (6., 0.), (6., 4.), (0., 4.)], &[6, 4, 6, 4]),
        polygon(&[(0., 0.), (6., 0.), (3., 5.)], &[6, 6, 6]),
        polygon(&[(0., 0.), (6., 0.), (6., 4.), (0., 4.)], &[7, 4, 5, 4]),
        circle(24).into_iter().map(|p| 4.0 * p).collect(),
    ];
    let contours = shapes.map(|p| Contour::from_ring(&p, 1.0));
    let h = Uniform(1.0);
    let tolerance = Tolerance::of_points(contours[0].points.iter().copied());
    let task = |contour| RegionTask { contour, size: &h, tolerance };
    let mut made = 0;
    for c in &contours {
        let Some((appraisal, recipe)) = tfi.foresee(&task(c)) else { continue };
        assert_eq!(Some(appraisal), tfi.appraise(&task(c)));
        assert!(tfi.glance(&task(c)).is_some());
        for other in &contours {
            assert_eq!(tfi.mesh_by(&task(other), &recipe).is_ok(), tfi.mesh(&task(other)).is_ok());
        }
        assert_eq!(tfi.mesh_by(&task(c), &recipe), tfi.mesh(&task(c)));
        made += 1;
    }
    assert!(made >= 3, "{made} forecasts");
}
