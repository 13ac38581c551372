use super::*;
use proptest::prelude::*;

fn word(s: &str) -> Vec<Front> {
    s.chars().filter_map(Front::of_letter).collect()
}

fn full(s: &str) -> Ring {
    let w = word(s);
    let roles = settle(&w, &mut vec![true; w.len()], |_| true);
    Ring::new(&roles).expect("the word has no adjacent corners")
}

fn sizes(s: &str) -> (usize, usize) {
    let r = full(s);
    (r.quads.len(), r.new_loop.len())
}

/// Edges of the quads that no other quad runs along the other way, sorted.
fn border(quads: &[[u32; 4]]) -> Vec<(u32, u32)> {
    let mut e: Vec<_> = quads.iter().flat_map(|q| (0..4).map(|k| (q[k], q[(k + 1) % 4]))).collect();
    e.sort_unstable();
    assert!(e.windows(2).all(|w| w[0] != w[1]), "an edge is run along twice in one direction");
    e.iter().copied().filter(|&(a, b)| e.binary_search(&(b, a)).is_err()).collect()
}

/// Handbook 2.4, golden values.
#[test]
fn golden_counts() {
    let square = format!("E{0}E{0}E{0}E{0}", "SSSSS");
    assert_eq!(sizes(&square), (20, 16));
    // An L of 32 nodes: five corners, one right reversal.
    let l = format!("E{0}E{1}E{1}C{1}E{1}E{0}", "SSSSSSS", "SSS");
    assert_eq!(l.len(), 32);
    assert_eq!(sizes(&l), (28, 24));
    assert_eq!(sizes("RSSSRSSS"), (12, 16));
    assert_eq!(sizes(&"S".repeat(16)), (16, 16));
    assert_eq!(sizes("CSSCSSCSSCSS"), (16, 20));
    assert_eq!(sizes("CCCC"), (8, 12));
    assert_eq!(sizes("RR"), (6, 10));
    let p = Ring::around_point();
    assert_eq!((p.quads.len(), p.new_loop.len()), (4, 8));
    assert_eq!(border(&p.quads).len(), 8);
}

#[test]
fn a_ring_may_fill_everything() {
    assert_eq!(sizes("ESESES"), (3, 1));
    assert_eq!(full("SESESE").n_new, 1);
}

#[test]
fn acute_nodes_leave_their_edges_on_the_new_loop() {
    let r = full("KSSSSS");
    assert_eq!(r.quads.len(), 4);
    assert_eq!(r.new_loop, [0, 1, 6, 7, 8, 9, 10, 5]);
}

#[test]
fn adjacent_corners_are_refused() {
    let w = word("EESS");
    let roles = settle(&w, &mut [true; 4], |_| true);
    assert_eq!(Ring::new(&roles), Err(NoRing::AdjacentCorners(0)));
}

#[test]
fn chains_retreat_from_nodes_that_have_no_room_for_an_end() {
    let w = word("KSSSSSSS");
    let mut cover = vec![true; 8];
    settle(&w, &mut cover, |i| i != 1);
    assert_eq!(cover, [false, false, true, true, true, true, true, false]);
}

pub(crate) fn words() -> impl Strategy<Value = Vec<Front>> {
    use Front::{Acute, Flat, Reversal, Right, RightReversal};
    let letter = prop_oneof![1 => Just(Acute), 3 => Just(Right), 6 => Just(Flat), 3 => Just(RightReversal),
        2 => Just(Reversal)];
    prop::collection::vec(letter, 3..14).prop_map(|mut w| {
        let n = w.len();
        for i in 0..n {
            if w[i].is_corner() && w[(i + 1) % n].is_corner() {
                w[i] = Flat;
            }
        }
        w
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Handbook 13.2, item 2: the border of the ring is the covered edges and the new loop reversed; parity stays.
    #[test]
    fn the_ring_is_what_lies_between_the_loops(w in words(), mask in any::<u16>(), partial in any::<bool>()) {
        let n = w.len();
        let mut cover: Vec<bool> = (0..n).map(|i| !partial || mask >> i & 1 == 1).collect();
        let roles = settle(&w, &mut cover, |_| true);
        let r = match Ring::new(&roles) {
            Ok(r) => r,
            Err(why) => {
                prop_assert!(why == NoRing::Pinched || cover.iter().all(|c| !c));
                return Ok(());
            }
        };
        if r.new_loop.len() < 3 {
            return Ok(()); // everything is filled, or two sides are glued to each other
        }
        prop_assert_eq!(r.new_loop.len() % 2, n % 2);
        let m = r.new_loop.len();
        let mut want: Vec<(u32, u32)> = (0..n).filter(|&i| cover[i]).map(|i| (i as u32, ((i + 1) % n) as u32)).collect();
        for k in 0..m {
            let (a, b) = (r.new_loop[k], r.new_loop[(k + 1) % m]);
            let uncovered = (a as usize) < n && (b as usize) < n && !cover[a as usize] && (a as usize + 1) % n == b as usize;
            if !uncovered {
                want.push((b, a));
            }
        }
        want.sort_unstable();
        prop_assert_eq!(border(&r.quads), want);
    }

    #[test]
    fn counts_follow_the_formula(w in words()) {
        let w: Vec<Front> = w.into_iter().map(|f| if f == Front::Acute { Front::Flat } else { f }).collect();
        let n = w.len();
        prop_assume!(n > 3);
        let count = |f: Front| w.iter().filter(|&&g| g == f).count();
        let (e, c, rr) = (count(Front::Right), count(Front::RightReversal), count(Front::Reversal));
        let r = Ring::new(&settle(&w, &mut vec![true; n], |_| true));
        prop_assume!(r != Err(NoRing::Pinched));
        let r = r.expect("no adjacent corners");
        prop_assert_eq!(r.quads.len(), n - e + c + 2 * rr);
        let formula = n + 2 * c + 4 * rr - 2 * e;
        if formula > 1 {
            prop_assert_eq!(r.n_new, formula);
            prop_assert_eq!(r.new_loop.len(), formula);
        } else {
            prop_assert_eq!(r.n_new, 1);
        }
    }
}
