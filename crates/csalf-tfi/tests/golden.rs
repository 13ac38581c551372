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
    let (patch, s, irregular) = mesh(&p, &Uniform(1.0 / 12.0), TfiRules::default()).unwrap();
    assert_eq!((patch.quads.len(), irregular), (144, 0));
    assert!(s.min_sj > 1.0 - 1e-9);
    let (paper, ..) = mesh(&p, &Uniform(1.0 / 12.0), TfiRules::paper()).unwrap();
    assert_eq!(paper, patch);
}

#[test]
fn triangle_has_one_irregular_vertex() {
    let p = polygon(&[(0., 0.), (1., 0.), (0.5, 0.75f64.sqrt())], &[16; 3]);
    let (patch, s, irregular) = mesh(&p, &Uniform(1.0 / 16.0), TfiRules::default()).unwrap();
    assert_eq!((patch.quads.len(), irregular), (192, 1));
    assert!(s.min_sj > 0.85, "{s:?}");
    assert!(mesh(&p, &Uniform(1.0 / 16.0), TfiRules::paper()).is_none());
}

#[test]
fn pentagon_is_five_blocks() {
    let corners: Vec<(f64, f64)> = circle(5).iter().map(|p| (p.x, p.y)).collect();
    let (patch, s, irregular) =
        mesh(&polygon(&corners, &[6; 5]), &Uniform(0.19), TfiRules::default()).unwrap();
    assert_eq!((patch.quads.len(), irregular), (45, 1));
    assert!(s.min_sj > 0.9, "{s:?}");
}

#[test]
fn contours_that_are_not_patches_are_refused() {
    let l = [(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)];
    assert!(mesh(&polygon(&l, &[8, 4, 4, 4, 4, 8]), &Uniform(0.25), TfiRules::default()).is_none());
    let odd = polygon(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)], &[3, 2, 2, 2]);
    assert!(mesh(&odd, &Uniform(0.5), TfiRules::default()).is_none());
}
