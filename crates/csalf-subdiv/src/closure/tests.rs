use super::table::STENCILS;
use super::*;
use csalf_geom::{angle::interior_angle, polygon::signed_area};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write as _;

fn p(x: f64, y: f64) -> Point2 {
    Point2::new(x, y)
}

fn by_angles(rim: &[Point2]) -> Vec<f64> {
    let n = rim.len();
    (0..n).map(|i| interior_angle(rim[(i + n - 1) % n], rim[i], rim[(i + 1) % n]) / FRAC_PI_2).collect()
}

fn closed(rim: &[Point2]) -> Option<(f64, ClosureResult)> {
    let mut out = ClosureResult::default();
    close(rim, &by_angles(rim), &mut out).map(|sj| (sj, out))
}

#[test]
fn the_table_is_what_the_enumeration_gives() {
    for (n, inner) in [(4, 0..5), (6, 0..4), (8, 0..3)] {
        let made: Vec<_> = inner.flat_map(|m| generate::classes(n, m)).collect();
        let kept: Vec<_> = STENCILS.iter().filter(|s| s.n == n).map(|s| s.quads.to_vec()).collect();
        assert_eq!(made, kept, "{n} nodes");
    }
    // The counts of the handbook, also beyond the table.
    assert_eq!((0..5).map(|m| generate::classes(6, m).len()).collect::<Vec<_>>(), [1, 1, 1, 1, 4]);
    assert_eq!((0..3).map(|m| generate::classes(8, m).len()).collect::<Vec<_>>(), [2, 2, 4]);
}

/// A stencil drawn with its rim on a circle.
fn drawing(p: &Placement) -> String {
    let (w, h) = (37usize, 13usize);
    let rim: Vec<Point2> =
        (0..p.n).map(|i| Point2::from_angle(TAU * (i as f64 / p.n as f64 - 0.375))).collect();
    let inner = smooth_points(p, &rim);
    let cell = |q: Point2| {
        let x = ((q.x + 1.0) / 2.0 * (w - 1) as f64).round() as usize;
        (x, ((1.0 - q.y) / 2.0 * (h - 1) as f64).round() as usize)
    };
    let mut grid = vec![vec![' '; w + 1]; h];
    for q in &p.quads[..p.n_quads] {
        for k in 0..4 {
            let (a, b) = (p.at(&rim, &inner, q[k]), p.at(&rim, &inner, q[(k + 1) % 4]));
            for t in 1..40 {
                let (x, y) = cell(a.lerp(b, t as f64 / 40.0));
                grid[y][x] = '.';
            }
        }
    }
    for v in 0..p.n + p.n_inner {
        let (x, y) = cell(p.at(&rim, &inner, v as u8));
        grid[y][x] = char::from_digit(v as u32, 16).unwrap_or('?');
    }
    let mut s = String::new();
    for row in grid {
        let row: String = row.into_iter().collect();
        let _ = writeln!(s, "{}", row.trim_end());
    }
    let names: Vec<String> =
        p.quads[..p.n_quads].iter().map(|q| q.map(|v| format!("{v:x}")).join(" ")).collect();
    let valence: String = p.valence[..p.n].iter().map(|d| format!("{d}")).collect();
    let _ = writeln!(s, "ring {}  new {}  quads {}  rim {valence}", p.n, p.n_inner, p.n_quads);
    let _ = writeln!(s, "  {}\n", names.join(" / "));
    s
}

fn smooth_points(p: &Placement, rim: &[Point2]) -> [Point2; MAX_INNER] {
    let mut inner = [Point2::ZERO; MAX_INNER];
    for (q, weight) in inner.iter_mut().zip(p.weight).take(p.n_inner) {
        *q = rim.iter().zip(weight).map(|(&r, w)| r * w).sum();
    }
    inner
}

#[test]
fn pictures_of_all_stencils() {
    let mut all = String::new();
    for n in [4, 6, 8] {
        let mut seen = Vec::new();
        for p in placements(n) {
            let kind = (p.n_inner, p.cost.to_bits(), {
                let mut v: Vec<u64> = (0..n).map(|i| p.valence[i] as u64).collect();
                let turns: Vec<Vec<u64>> = (0..n)
                    .flat_map(|_| {
                        v.rotate_left(1);
                        let mut r = v.clone();
                        r.reverse();
                        [v.clone(), r]
                    })
                    .collect();
                turns.into_iter().min()
            });
            if !seen.contains(&kind) {
                seen.push(kind);
                all.push_str(&drawing(p));
            }
        }
    }
    insta::assert_snapshot!("stencils", all);
}

#[test]
fn every_placement_is_a_sound_disk() {
    for n in [4usize, 6, 8] {
        assert!(placements(n).len() <= MAX_PLACEMENTS);
        for p in placements(n) {
            // Euler: Q = n/2 + inner - 1. Charge: sum (4 - d) inside + sum (2 - d) on the rim = 4 (handbook 4.7).
            assert_eq!(p.n_quads + 1, n / 2 + p.n_inner);
            let mut valence = [0i32; 12];
            let mut sides = Vec::new();
            for q in &p.quads[..p.n_quads] {
                for k in 0..4 {
                    valence[q[k] as usize] += 1;
                    sides.push((q[k], q[(k + 1) % 4]));
                }
            }
            sides.sort_unstable();
            let rim: Vec<_> = sides.iter().filter(|&&(a, b)| !sides.contains(&(b, a))).copied().collect();
            let mut want: Vec<_> = (0..n as u8).map(|i| (i, (i + 1) % n as u8)).collect();
            want.sort_unstable();
            assert_eq!(rim, want);
            let rim_charge: i32 = valence[..n].iter().map(|d| 2 - d).sum();
            let inner_charge: i32 = valence[n..n + p.n_inner].iter().map(|d| 4 - d).sum();
            assert_eq!(rim_charge + inner_charge, 4);
            assert!(p.weight[..p.n_inner].iter().all(|w| (w.iter().sum::<f64>() - 1.0).abs() < 1e-12));
        }
    }
    let counts = [4, 6, 8].map(|n| placements(n).len());
    assert_eq!(counts, count_placements());
    assert_eq!(counts, [2, 14, 66]);
}

/// Distinct placements, counted without the shortcut of the table's key: by exact comparison under renaming.
fn count_placements() -> [usize; 3] {
    [4u8, 6, 8].map(|n| {
        let rows = STENCILS.iter().filter(|s| s.n == n);
        rows.map(|s| generate::images(&s.quads.to_vec(), n, s.inner)).sum()
    })
}

#[test]
fn well_known_contours() {
    let square = [p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)];
    let (sj, r) = closed(&square).unwrap();
    assert_eq!((sj, r.quads().len()), (1.0, 1));
    // Two squares side by side.
    let two = [p(0., 0.), p(1., 0.), p(2., 0.), p(2., 1.), p(1., 1.), p(0., 1.)];
    let (sj, r) = closed(&two).unwrap();
    assert_eq!((sj, r.quads().len()), (1.0, 2));
    // A triangle with a node in the middle of each side.
    let tri = [p(0., 0.), p(1., 0.), p(2., 0.), p(1.5, 0.9), p(1., 1.8), p(0.5, 0.9)];
    let (_, r) = closed(&tri).unwrap();
    assert_eq!((r.points().len(), r.quads().len()), (1, 3));
    // 2 x 2 squares.
    let four = [p(0., 0.), p(1., 0.), p(2., 0.), p(2., 1.), p(2., 2.), p(1., 2.), p(0., 2.), p(0., 1.)];
    let (sj, r) = closed(&four).unwrap();
    assert!((sj - 1.0).abs() < 1e-12);
    assert_eq!((r.points().len(), r.quads().len()), (1, 4));
    // An L of three squares needs no inner node.
    let l = [p(0., 0.), p(1., 0.), p(2., 0.), p(2., 1.), p(1., 1.), p(1., 2.), p(0., 2.), p(0., 1.)];
    let (sj, r) = closed(&l).unwrap();
    assert_eq!((sj, r.points().len(), r.quads().len()), (1.0, 0, 3));
    // A boomerang of four nodes is relieved by four inner nodes, or refused; never a folded quad.
    let boomerang = [p(0., 0.), p(1., 0.), p(0.45, 0.45), p(0., 1.)];
    assert!(closed(&boomerang).is_some_and(|(_, r)| r.quads().len() == 5));
    assert!(closed(&square[..3]).is_none());
    assert!(closed(&[square[0]; 6]).is_none());
    assert!(closed(&[p(f64::NAN, 0.), square[1], square[2], square[3]]).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_closed_is_convex_and_exact(
        half in 2usize..5, radii in prop::collection::vec(0.3..1.0f64, 8),
        shift in 0usize..8, exponent in -20i32..=20,
    ) {
        let n = 2 * half;
        let rim: Vec<Point2> =
            (0..n).map(|i| Point2::from_angle(TAU * i as f64 / n as f64) * radii[i]).collect();
        let Some((sj, r)) = closed(&rim) else { return Ok(()) };
        prop_assert!((LEAST_SJ..=1.0 + 1e-12).contains(&sj));
        let at = |v: u8| if (v as usize) < n { rim[v as usize] } else { r.points()[v as usize - n] };
        let mut area = 0.0;
        for q in r.quads() {
            let v = q.map(at);
            prop_assert!((0..4).all(|k| is_left(v[k], v[(k + 1) & 3], v[(k + 2) & 3])));
            area += signed_area(&v);
        }
        prop_assert!((area - signed_area(&rim)).abs() < 1e-12);
        prop_assert_eq!(appraise(&rim, &by_angles(&rim)), Some((sj, r.quads().len())));
        // The start node does not matter, except among ties.
        let mut turned = rim.clone();
        turned.rotate_left(shift % n);
        let other = closed(&turned);
        prop_assert!(other.is_some_and(|(s, t)| t.quads().len() == r.quads().len() && (s - sj).abs() < 0.2));
        // Powers of two change nothing.
        let scaled: Vec<Point2> = rim.iter().map(|&q| q * 2f64.powi(exponent)).collect();
        prop_assert_eq!(closed(&scaled).map(|c| (c.0, c.1.quads, c.1.n_quads)), Some((sj, r.quads, r.n_quads)));
    }

    /// The pruned choice is the best of all placements.
    #[test]
    fn pruning_loses_nothing(half in 2usize..5, radii in prop::collection::vec(0.5..1.0f64, 8)) {
        let n = 2 * half;
        let rim: Vec<Point2> =
            (0..n).map(|i| Point2::from_angle(TAU * i as f64 / n as f64) * radii[i]).collect();
        let wanted = by_angles(&rim);
        let score = |p: &'static Placement| {
            let f = smooth(p, &rim);
            let misfit: f64 = (0..n).map(|i| (p.valence[i] - wanted[i]).powi(2)).sum();
            (f.sj >= LEAST_SJ).then_some(misfit + p.cost - 2.0 * f.sj.min(ENOUGH_SJ))
        };
        let all = placements(n).iter().filter_map(&score).fold(f64::INFINITY, f64::min);
        if let (true, Some(f)) = (all.is_finite(), select(&rim, &wanted)) {
            prop_assert!((score(f.placement).unwrap_or(f64::INFINITY) - all).abs() < 1e-12);
        }
    }

    /// What the angles of the rim forbid, no placement reaches.
    #[test]
    fn angles_forbid_nothing_that_is_good(half in 2usize..5, radii in prop::collection::vec(0.3..1.0f64, 8),
        least in 0.02..0.6f64)
    {
        let n = 2 * half;
        let rim: Vec<Point2> =
            (0..n).map(|i| Point2::from_angle(TAU * i as f64 / n as f64) * radii[i]).collect();
        let wanted = by_angles(&rim);
        let reached = placements(n).iter().any(|p| smooth(p, &rim).sj >= least);
        prop_assert!(!reached || can_reach(&rim, &wanted, least));
        prop_assert!(!can_reach(&rim, &wanted, least + 0.1) || can_reach(&rim, &wanted, least));
    }
}
