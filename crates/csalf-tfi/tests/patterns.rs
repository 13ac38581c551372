//! Properties of every pattern of the table, and the frozen table in words.

use csalf_geom::{Point2, VertexId};
use csalf_mesh::QuadTopology;
use csalf_sizemap::Uniform;
use csalf_tfi::fill::Filler;
use csalf_tfi::pattern::{Chords, MAX_CHORDS, MAX_INNER, MAX_SIDES, MAX_VERTICES, Pattern};
use csalf_tfi::table::{TABLE, patterns};
use proptest::prelude::*;
use std::fmt::Write;

fn all() -> impl Iterator<Item = &'static Pattern> {
    (0..=MAX_SIDES).flat_map(|n| patterns(n).iter())
}

/// One line per pattern: sides as words of chords (letters), inner valences, quads.
#[test]
fn table_is_frozen() {
    let mut out = String::new();
    for d in TABLE {
        let p = Pattern::new(d);
        let letter = |e: usize| char::from(b'a' + p.chord[e]);
        let word = |i: usize| -> String {
            let end = p.sides.get(i + 1).map_or(p.n_boundary, |&v| v as usize);
            (p.sides[i] as usize..end).map(letter).collect()
        };
        let words: Vec<String> = (0..p.sides.len()).map(word).collect();
        let mut valence = vec![0; p.n_vertices];
        p.quads.iter().flatten().for_each(|&v| valence[v as usize] += 1);
        let inner: Vec<String> = valence[p.n_boundary..].iter().map(|d| d.to_string()).collect();
        let (words, inner) = (words.join(" | "), inner.join(""));
        writeln!(
            out,
            "{:10} {} corners  sides {words:24} inner {inner:6} quads {:?}",
            p.name, p.n_corners, p.quads
        )
        .unwrap();
    }
    insta::assert_snapshot!(out);
}

#[test]
fn table_is_consistent() {
    for p in all() {
        assert!(p.n_chords <= MAX_CHORDS && p.n_vertices <= MAX_VERTICES, "{}", p.name);
        assert!(p.n_vertices - p.n_boundary <= MAX_INNER, "{}", p.name);
        let mut valence = vec![0i32; p.n_vertices];
        p.quads.iter().flatten().for_each(|&v| valence[v as usize] += 1);
        // Topological charge (handbook 4.7), and corners where the sides begin.
        let charge: i32 = valence[p.n_boundary..].iter().map(|d| 4 - d).sum::<i32>()
            + valence[..p.n_boundary].iter().map(|d| 2 - d).sum::<i32>();
        assert_eq!(charge, 4, "{}", p.name);
        for (v, &d) in valence[..p.n_boundary].iter().enumerate() {
            let corner = p.n_corners > 0 && p.sides.contains(&(v as u8));
            assert_eq!(d, if corner { 1 } else { 2 }, "{} vertex {v}", p.name);
        }
    }
}

#[test]
fn mirror_images_mirror() {
    for p in all() {
        let twice = p.mirrored().mirrored();
        assert!((0..p.n_boundary).any(|r| twice.is_rotation_of(p, r)), "{}", p.name);
    }
}

/// Handbook 13.2.5: every even rectangle that is not too thin is reg, diag35 or al35.
#[test]
fn rectangles_are_complete() {
    let found = |name: &str, s: [u32; 4]| {
        patterns(4).iter().filter(|p| p.name.trim_end_matches('\'') == name).any(|p| {
            (0..4).any(|r| {
                let mut any = false;
                let turned = [0, 1, 2, 3].map(|k| s[(k + r) % 4]);
                p.solve(&turned, 1, usize::MAX, &mut |_| any = true);
                any
            })
        })
    };
    for code in 0..7u32.pow(4) {
        let s = [0, 1, 2, 3].map(|k| 1 + code / 7u32.pow(k) % 7);
        let (d1, d2) = (s[0].abs_diff(s[2]), s[1].abs_diff(s[3]));
        let (low1, low2) = (s[0].min(s[2]), s[1].min(s[3]));
        if (d1 + d2) % 2 == 1 {
            assert!(!["reg", "diag35", "al35"].iter().any(|p| found(p, s)), "{s:?} is odd");
            continue;
        }
        let (long, other) = if d1 >= d2 { (low1, low2) } else { (low2, low1) };
        let thick = long >= 2 && other >= d1.abs_diff(d2) / 2 + 2;
        assert_eq!(found("reg", s), d1 == 0 && d2 == 0, "{s:?}");
        assert_eq!(found("diag35", s), d1 == d2 && d1 > 0 && low1 >= 2 && low2 >= 2, "{s:?}");
        assert_eq!(found("al35", s), d1 != d2 && thick, "{s:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// The built mesh has exactly the boundary, the irregular vertices and the quads that the pattern
    /// predicts.
    #[test]
    fn filled_patterns_keep_their_promise(
        counts in proptest::collection::vec(1u32..5, MAX_CHORDS),
        turn in 0u32..100,
    ) {
        for p in all() {
            let mut x: Chords = [0; MAX_CHORDS];
            x[..p.n_chords].copy_from_slice(&counts[..p.n_chords]);
            let at = |e: usize| x[p.chord[e] as usize];
            let n: u32 = (0..p.n_boundary).map(at).sum();
            let side = |i: usize| -> u32 {
                let end = p.sides.get(i + 1).map_or(p.n_boundary, |&v| v as usize);
                (p.sides[i] as usize..end).map(at).sum()
            };
            let sides: Vec<u32> = (0..p.sides.len()).map(side).collect();
            let mut seen = false;
            let closed = (0..p.n_chords).find(|&c| p.by_side.iter().all(|s| s[c] == 0)).map_or(1, |c| x[c]);
            p.solve(&sides, closed, usize::MAX, &mut |y| seen |= *y == x);
            prop_assert!(seen, "{} does not find its own solution", p.name);

            let step = std::f64::consts::TAU / f64::from(n);
            let ring = (0..n).map(|i| Point2::from_angle(step * f64::from(i)));
            let mut f = Filler::default();
            f.fill(p, &x, ring, turn % n, &Uniform(0.1), &x);
            let quads: Vec<[VertexId; 4]> = f.quads.iter().map(|q| q.map(VertexId)).collect();
            let t = QuadTopology::new(f.points.len(), &quads);
            prop_assert_eq!(t.n_bad_edges, 0);
            prop_assert_eq!(quads.len() as u64, p.n_quads(&x));
            prop_assert_eq!(t.irregular().len(), p.n_irregular, "{}", p.name);
            let rim: Vec<usize> = (0..t.twin.len()).filter(|&h| t.twin[h] == QuadTopology::NONE).collect();
            prop_assert_eq!(rim.len(), n as usize);
            for h in rim {
                let q = f.quads[h / 4];
                prop_assert_eq!((q[h % 4] + 1) % n, q[(h + 1) % 4]);
            }
            prop_assert_eq!(f.points.len() + quads.len(), (4 * quads.len() + n as usize) / 2 + 1);
        }
    }
}
