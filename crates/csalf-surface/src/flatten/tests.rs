//! The flattenings against closed forms and their promises.

use super::*;
use crate::patch::Patch;
use proptest::prelude::*;

/// A grid of n x n cells over the unit square, mapped.
fn chart(n: u32, f: impl Fn(f64, f64) -> DVec3) -> Chart {
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let mut facets = Facets::default();
    for j in 0..=n {
        for i in 0..=n {
            facets.points.push(f(f64::from(i) / f64::from(n), f64::from(j) / f64::from(n)));
        }
    }
    for j in 0..n {
        for i in 0..n {
            facets.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            facets.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let patch = Patch::new(&facets).expect("a grid");
    let all = (0..patch.triangles.len() as u32).collect();
    let cut = vec![false; patch.twin.len()];
    Chart::new(&patch, &cut, all, &mut vec![NONE; patch.triangles.len()])
}

fn order(c: &Chart) -> Order {
    Order::new(&c.points, &c.triangles)
}

#[test]
fn the_solver_solves() {
    let c = chart(9, |s, t| DVec3::new(s, t, 0.0));
    let n = c.vertex.len();
    let mut m = Symmetric::new(n);
    let mut dense = vec![vec![0f64; n]; n];
    let o = order(&c);
    for t in &c.triangles {
        for k in 0..3 {
            let (i, j) = (o.rank[t[k] as usize], o.rank[t[(k + 1) % 3] as usize]);
            for (a, b, x) in [(i, i, 1.1), (j, j, 1.2), (i, j, -1.0)] {
                m.add(a, b, x);
                dense[a as usize][b as usize] += x;
                if a != b {
                    dense[b as usize][a as usize] += x;
                }
            }
        }
    }
    let mut x: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
    let b = x.clone();
    m.factor().expect("definite").solve(&mut x);
    for (row, want) in dense.iter().zip(b) {
        let got: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
        assert!((got - want).abs() < 1e-12);
    }
    let mut bad = Symmetric::new(2);
    bad.add(0, 0, 1.0);
    bad.add(1, 1, 1.0);
    bad.add(0, 1, 1.0);
    assert!(bad.factor().is_none(), "singular");
}

#[test]
fn a_conformal_map_of_a_plane_is_a_similarity() {
    let c = chart(6, |s, t| DVec3::new(2.0 * s + 0.3 * t, t, 0.5 * t));
    let flat = conformal::conformal(&c, &order(&c)).expect("a plane");
    let v = judge(&c, &flat);
    assert!(
        v.n_flipped == 0 && (v.anisotropy - 1.0).abs() < 1e-9 && (v.scale_range - 1.0).abs() < 1e-9,
        "{v:?}"
    );
    assert!((v.mean_scale - 1.0).abs() < 1e-9 && v.angle_error < 1e-6);
}

#[test]
fn overlap_is_seen() {
    // A strip wound one and a half times round, in the plane.
    let c = chart(24, |s, t| DVec3::new(9.0 * s, t, 0.0));
    let wound: Flat = c.points.iter().map(|p| DVec2::from_angle(-p.x) * (1.0 + p.y)).collect();
    let v = judge(&c, &wound);
    assert!(v.n_flipped == 0 && v.overlaps, "{v:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Tutte's map has no flips whatever the surface, and relaxing it makes none and lowers the distortion.
    #[test]
    fn convex_maps_have_no_flips(z in prop::collection::vec(-1.0f64..1.0, 64), rough in 0.0f64..1.5) {
        let c = chart(7, |s, t| {
            let k = (7.0 * t).round() as usize * 8 + (7.0 * s).round() as usize;
            DVec3::new(s, t, rough * z[k])
        });
        let start = tutte::tutte(&c).expect("a disc");
        let (a, b) = (judge(&c, &start), relax::relax(&c, &order(&c), start));
        let b = judge(&c, &b);
        prop_assert_eq!((a.n_flipped, b.n_flipped), (0, 0));
        prop_assert!(!a.overlaps);
    }

    /// A developable strip is unrolled with its lengths.
    #[test]
    fn unrolling_keeps_lengths(bend in -3.0f64..3.0, twist in 0.3f64..1.0) {
        let c = chart(8, |s, t| DVec3::new((bend * s).sin() / bend, (1.0 - (bend * s).cos()) / bend, twist * t));
        if let Some(flat) = unroll::unroll(&c) {
            for t in &c.triangles {
                for k in 0..3 {
                    let (i, j) = (t[k] as usize, t[(k + 1) % 3] as usize);
                    prop_assert!((flat[i].distance(flat[j]) - c.points[i].distance(c.points[j])).abs() < 1e-9);
                }
            }
        } else {
            prop_assert!(bend.abs() < 1e-3, "only rounding may hinder it");
        }
    }
}
