//! Golden numbers: Verdict's as computed by VTK 9, the others by the judge of the public cases.

use super::*;
use crate::{QuadMesh, QualityReport};
use csalf_geom::{Point2, VertexId};
use csalf_sizemap::{Hint, SizeField};

fn close(got: f64, want: f64) {
    assert!((got - want).abs() <= 1e-9 * want.abs().max(1.0), "{got} is not {want}");
}

fn ids<const K: usize>(e: [usize; K]) -> [VertexId; K] {
    e.map(VertexId::new)
}

/// An 8 x 6 grid of unit squares whose inner nodes are moved by up to 0.45 each way.
fn shaken_grid() -> QuadMesh {
    let (n, m, a) = (8usize, 6usize, 0.9);
    let mut s = 1u64;
    let mut next = || {
        s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (s >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut mesh = QuadMesh::default();
    for j in 0..=m {
        for i in 0..=n {
            let d = Point2::new(next() - 0.5, next() - 0.5);
            let inner = i > 0 && i < n && j > 0 && j < m;
            mesh.points.push(Point2::new(i as f64, j as f64) + if inner { a * d } else { Point2::ZERO });
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

/// Four rings of 16 quads between radius 1 and 3.5.
fn annulus() -> QuadMesh {
    let (n, radii) = (16usize, [1.0, 1.4, 2.0, 2.9, 3.5]);
    let mut mesh = QuadMesh::default();
    for r in radii {
        for i in 0..n {
            let t = std::f64::consts::TAU * i as f64 / n as f64;
            mesh.points.push(r * Point2::new(t.cos(), t.sin()));
        }
    }
    for k in 0..4 {
        for i in 0..n {
            let j = (i + 1) % n;
            mesh.quads.push(ids([k * n + i, (k + 1) * n + i, (k + 1) * n + j, k * n + j]));
        }
    }
    mesh
}

#[derive(Debug)]
struct Linear;
impl SizeField for Linear {
    fn h(&self, p: Point2, _: &mut Hint) -> f64 {
        0.8 + 0.05 * p.x + 0.02 * p.y
    }
    fn range(&self) -> (f64, f64) {
        (0.8, 1.4)
    }
}

#[derive(Debug)]
struct Radial;
impl SizeField for Radial {
    fn h(&self, p: Point2, _: &mut Hint) -> f64 {
        0.4 * p.length()
    }
    fn range(&self) -> (f64, f64) {
        (0.4, 1.4)
    }
}

#[test]
fn shapes_are_verdicts() {
    let mesh = shaken_grid();
    let p = |i: usize| mesh.corners(csalf_geom::QuadId::new(i));
    let at = [0, 9, 13, 20, 27];
    let want = [
        [0.8576764494238144, 0.05259324595906354, 0.2619903385278708, 0.5406884361875786, 0.7215844360979565],
        [
            0.8566124442748082,
            0.05237855243954935,
            0.19581479284962164,
            0.5402633605975008,
            0.5015687485647234,
        ],
        [0.3125150642256695, 0.609802621702981, 0.8720374231588413, 0.15436461804655338, 0.24935526741668057],
        [1.2947219593113062, 1.8092687853801888, 2.799282964300404, 1.618635850006344, 1.3379242584719433],
        [59.05668729422497, 41.39602989976341, 23.243932465984788, 52.15565400600638, 61.57211352748136],
        [107.99008409544479, 176.98523805473266, 164.81180537383813, 147.26948401502864, 133.8145501779592],
    ];
    let metrics: [fn(&[Point2; 4]) -> f64; 6] = [
        scaled_jacobian::value,
        shape::value,
        skew::value,
        aspect::value,
        |p| angles::min_max(p).0,
        |p| angles::min_max(p).1,
    ];
    let sums = [
        34.75300075027289,
        31.53340913670193,
        12.663090834778973,
        71.94497461993814,
        2990.5124178887013,
        6130.549817838074,
    ];
    for ((metric, want), sum) in metrics.iter().zip(want).zip(sums) {
        for (i, want) in at.into_iter().zip(want) {
            close(metric(&p(i)), want);
        }
        // One quad is concave; so the sums also cover that case.
        close((0..mesh.n_quads()).map(|i| metric(&p(i))).sum::<f64>(), sum);
    }
}

#[test]
fn the_report_of_a_shaken_grid_is_the_judges() {
    let r = QualityReport::new(&shaken_grid(), Some(&Linear), Some([4.0, 3.0, 2.0]));
    assert_eq!((r.n_quads, r.n_nonpositive, r.n_local, r.n_inner, r.max_valence), (48, 1, 13, 35, 4));
    close(r.min_sj, -0.061559315726979404);
    close(r.p1_sj, -0.020154767713908332);
    close(r.mean_sj, 0.7240208489640186);
    close(r.min_angle, 23.24393246598481);
    close(r.max_angle, 183.5293204679437);
    close(r.mean_aspect, 1.4988536379153778);
    close(r.max_aspect, 2.7992829643004047);
    close(r.tau_global.unwrap(), 0.20056861150906471);
    close(r.tau_boundary.unwrap(), 0.39481030933522665);
    close(r.tau_local.unwrap(), 0.31056912639144035);
    close(r.area, 48.0);
    let s = r.size.unwrap();
    close(s.share, 0.6585365853658537);
    close(s.rms_log, 0.34354059836458367);
    close(s.mean_log, -0.03370790545042684);
    close(s.min_ratio, 0.3716822011388162);
    close(s.max_ratio, 1.799206904793229);
    let t = r.structure.unwrap();
    assert_eq!((t.row1_share, t.column_share, t.flat2_share), (1.0, [1.0; 3], Some(1.0)));
    assert_eq!((&t.closed_rings_per_loop[..], &t.rings_per_loop[..]), (&[1][..], &[1][..]));
}

#[test]
fn the_report_of_an_annulus_is_the_judges() {
    let r = QualityReport::new(&annulus(), Some(&Radial), Some([0.0, 1.0, 0.8]));
    close(r.min_sj, 0.9807852804032302);
    close(r.tau_global.unwrap(), 0.7291994073009742);
    close(r.tau_boundary.unwrap(), 0.7671957671957671);
    close(r.tau_local.unwrap(), 0.7094594594594593);
    close(r.size.unwrap().rms_log, 0.300079904371536);
    assert_eq!(r.irregular_share, Some(0.0));
    let t = r.structure.unwrap();
    assert_eq!((&t.closed_rings_per_loop[..], &t.rings_per_loop[..]), (&[3, 3][..], &[3, 3][..]));
}

#[test]
fn triangles_are_judged_too() {
    let mut mesh = annulus();
    let q = mesh.quads.remove(20);
    mesh.triangles = vec![[q[0], q[1], q[2]], [q[0], q[2], q[3]]];
    let r = QualityReport::new(&mesh, Some(&Radial), Some([0.0, 1.0, 0.8]));
    assert_eq!((r.n_quads, r.n_triangles, r.n_local, r.n_inner, r.max_valence), (63, 2, 5, 48, 5));
    close(r.min_sj, 0.6976698198234498);
    close(r.p1_sj, 0.7416028517943306);
    close(r.mean_sj, 0.9731301179616142);
    close(r.min_angle, 37.171281146026054);
    close(r.mean_aspect, 1.3827132867308456);
    close(r.tau_local.unwrap(), 0.711382113821138);
    close(r.irregular_share.unwrap(), 0.041666666666666664);
    close(r.size.unwrap().share, 0.8584070796460177);
    close(r.size.unwrap().max_ratio, 1.3287304263157127);
    let t = r.structure.unwrap();
    assert_eq!(t.row1_share, 0.9375);
    assert_eq!(t.column_share, [0.9375, 0.84375, 0.8125]);
    assert_eq!((&t.closed_rings_per_loop[..], &t.rings_per_loop[..]), (&[1, 2][..], &[0, 1][..]));
}

#[test]
fn cards_hold_for_the_unit_square() {
    let p = Point2::new;
    let sq = [p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)];
    let (lo, hi) = angles::min_max(&sq);
    let got = [
        scaled_jacobian::value(&sq),
        jacobian_ratio::value(&sq),
        lo,
        hi,
        aspect::value(&sq),
        shape::value(&sq),
        skew::value(&sq),
    ];
    for (card, got) in CARDS.iter().zip(got) {
        assert_eq!(got, card.unit_square, "{}", card.name);
        assert!(card.normal.0 <= got && got <= card.normal.1);
        assert!(card.full.0 <= card.normal.0 && card.normal.1 <= card.full.1);
    }
}

/// Handbook 1.12 and 1.14: tau of parallelograms is 1; a ring of n squarish quads reaches (n - pi)/(n + pi).
#[test]
fn tau_of_parallelograms_and_rings() {
    let p = Point2::new;
    let mut t = Tau::default();
    assert_eq!(t.mean(), None);
    t.add(&Corners::new(&[p(0., 0.), p(1., 0.), p(3., 1.), p(2., 1.)]));
    assert_eq!(t.mean(), Some(1.0));
    let n = 64;
    let mut ring = Tau::default();
    let half = std::f64::consts::PI / n as f64;
    // Mid circle of radius 1, quads as thick as their mid chord is long, to first order.
    let (a, b) = (1.0 - half, 1.0 + half);
    let at = |r: f64, t: f64| p(r * t.cos(), r * t.sin());
    ring.add(&Corners::new(&[at(a, -half), at(b, -half), at(b, half), at(a, half)]));
    close(ring.mean().unwrap(), (n as f64 - std::f64::consts::PI) / (n as f64 + std::f64::consts::PI));
}

#[test]
fn an_empty_mesh_has_a_report() {
    let r = QualityReport::new(&QuadMesh::default(), Some(&Linear), None);
    assert_eq!((r.n_quads, r.tau_global, r.size, r.structure.is_none()), (0, None, None, true));
    assert!(r.to_string().contains("quads 0"));
}

#[test]
fn an_inverted_quad_is_counted() {
    let mut mesh = shaken_grid();
    mesh.quads[30].reverse();
    let r = QualityReport::new(&mesh, None, None);
    assert_eq!(r.n_nonpositive, 2);
    assert!(r.min_sj < -0.3 && r.max_aspect == f64::INFINITY);
}
