use super::draw::{Drawing, plan};
use super::*;
use crate::Front;
use crate::ring::{Ring, settle};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write as _;

fn canonical(q: [u32; 4]) -> [u32; 4] {
    let k = (0..4).min_by_key(|&k| q[k]).unwrap_or(0);
    std::array::from_fn(|i| q[(i + k) % 4])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// Handbook 13.2, item 1: march and cyclic formulation give the same ring on random type words.
    #[test]
    fn the_march_makes_the_cyclic_ring(w in crate::ring::tests::words()) {
        let n = w.len();
        prop_assume!(n >= 4);
        same_ring(&w)?;
    }
}

fn same_ring(w: &[Front]) -> Result<(), TestCaseError> {
    let n = w.len();
    let ring = match Ring::new(&settle(w, &mut vec![true; n], |_| true)) {
        Ok(r) => r,
        Err(_) => return Ok(()),
    };
    let Closed::Ring { rays, quads } = march(w) else {
        return Err(TestCaseError::fail("no corners meet in this word"));
    };
    let mut map: BTreeMap<u32, u32> = (0..n as u32).map(|i| (i, i)).collect();
    for (i, own) in rays.iter().enumerate() {
        let cyclic: Vec<u32> = ring.rays_of(i).collect();
        prop_assert_eq!(own.len(), cyclic.len(), "rays of node {}", i);
        for (a, b) in own.iter().zip(cyclic) {
            prop_assert_eq!(*map.entry(*a).or_insert(b), b, "ray of node {}", i);
        }
    }
    let mut a: Vec<[u32; 4]> = Vec::new();
    for q in &quads {
        let mut named = [0; 4];
        for k in 0..4 {
            named[k] =
                *map.get(&q[k]).ok_or_else(|| TestCaseError::fail("a quad has a node that is no ray"))?;
        }
        a.push(canonical(named));
    }
    let mut b: Vec<[u32; 4]> = ring.quads.iter().map(|q| canonical(*q)).collect();
    a.sort_unstable();
    b.sort_unstable();
    prop_assert_eq!(a, b);
    Ok(())
}

/// All words of five fronts, as the handbook's check (13.2, item 1).
#[test]
fn all_short_words_agree() {
    let letters = ['K', 'E', 'S', 'C', 'R'].map(|c| Front::of_letter(c).expect("a front"));
    let mut n_words = 0;
    for k in 0..5usize.pow(5) {
        let w: Vec<Front> = (0..5).map(|i| letters[k / 5usize.pow(i) % 5]).collect();
        if (0..5).any(|i| w[i].is_corner() && w[(i + 1) % 5].is_corner()) {
            continue;
        }
        n_words += 1;
        same_ring(&w).unwrap_or_else(|e| panic!("{w:?}: {e}"));
    }
    assert!(n_words > 2000);
}

#[test]
fn two_corners_are_peeled() {
    let w: Vec<Front> = "ESSE".chars().filter_map(Front::of_letter).collect();
    assert_eq!(march(&w), Closed::Peel([2, 3, 0, 1]));
}

const FRONTS: [Front; 5] = [Front::Acute, Front::Right, Front::Flat, Front::RightReversal, Front::Reversal];

fn quad_text(q: &[Name; 4]) -> String {
    q.iter().map(|v| v.text()).collect()
}

/// One cell of Table II in words, letters and pictures.
fn cell_text(first: Front, last: Front) -> (String, String) {
    let s = stencil(first, last);
    let mut out = String::new();
    let _ = writeln!(
        out,
        "first front ABC: {first:?} ({})   last front XAB: {last:?} ({})\n",
        first.letter(),
        last.letter()
    );
    let mut list = |title: &str, items: Vec<String>| {
        if !items.is_empty() {
            let _ = writeln!(out, "{title:<9}{}", items.join(", "));
        }
    };
    list("opening", s.opening.iter().map(quad_text).collect());
    list("create", s.create.iter().map(quad_text).collect());
    list("change", s.change.iter().map(|(a, b)| format!("{} to {}", quad_text(a), quad_text(b))).collect());
    list("withdraw", s.withdraw.iter().map(quad_text).collect());
    list("merge", s.merge.iter().map(|(a, b)| format!("{} into {}", a.text(), b.text())).collect());
    list("drop", s.drop.iter().map(|v| v.text().to_string()).collect());
    let _ = writeln!(out, "\n{}\n", s.note);
    let p = plan(first, last, &s);
    out.push_str(&Drawing::text(&p));
    (out, Drawing::svg(&p))
}

/// Every pair of first and last front: text, and an SVG twin beside it.
#[test]
fn closure_stencils() {
    for first in FRONTS {
        for last in FRONTS {
            let name = format!("first_{}_last_{}", first.letter(), last.letter());
            let (text, svg) = cell_text(first, last);
            insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
                insta::assert_snapshot!(name.clone(), text);
                insta::assert_binary_snapshot!(format!("{name}_drawn.svg").as_str(), svg.into_bytes());
            });
        }
    }
}
