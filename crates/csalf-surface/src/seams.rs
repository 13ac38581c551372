//! The cuts as chains of mesh nodes: each chain is discretised once, both sides share the nodes.
//!
//! ```text
//!   junction ●───●───●───●───● junction      a junction: where more or fewer than two cuts meet, or a given node
//!        chart 0   chain   chart 1           counts n: nearest to ∫ ds/h, then changed by one along a spanning
//!                                            tree of the charts until the contour of every chart is even
//! ```
//!
//! Source: handbook 9.4, 10.1 and 10.2 (on a tree the T-join is unique).

use crate::FaceError;
use crate::locate::Anchor;
use crate::patch::{NONE, Patch};
use std::collections::BTreeMap;

/// Fewest segments of a chain, and of one that closes on itself: two chains between the same ends must
/// differ.
const FEWEST: (usize, usize) = (2, 4);

/// A run of cut sides between junctions.
#[derive(Clone, Debug)]
struct Chain {
    /// Half-sides in direction.
    sides: Vec<u32>,
    /// Integral of 1/h up to the start of each side, and in total.
    w: Vec<f64>,
    n: usize,
    least: usize,
    charts: [u32; 2],
}

/// Mesh nodes on cuts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seams {
    /// Mesh node at each vertex of the patch, or [`NONE`].
    pub(crate) node_at: Vec<u32>,
    /// Nodes inside sides: per half-side, in its direction, (share, node).
    pub(crate) inside: BTreeMap<u32, Vec<(f64, u32)>>,
    /// Where each new node sits; node ids start after the given ones.
    pub(crate) anchors: Vec<Anchor>,
}

/// Places nodes on all cuts. `node_at`: given nodes; `n_given`: their number; `n_real`: per chart, number of
/// given segments on its contour; `finer`: factor of the sizes, at most 1.
#[allow(clippy::too_many_arguments, reason = "one call, and all of it is context")]
pub(crate) fn place(
    patch: &Patch,
    cut: &[bool],
    sizes: &[f64],
    chart_of: &[u32],
    node_at: Vec<u32>,
    n_given: usize,
    n_real: &[usize],
    finer: f64,
) -> Result<Seams, FaceError> {
    let mut chains = chains(patch, cut, sizes, chart_of, &node_at);
    if finer >= 1.0 {
        relieve(patch, &mut chains, &node_at);
    } else {
        for c in &mut chains {
            c.w.iter_mut().for_each(|w| *w /= finer);
            c.n = (c.w[c.w.len() - 1].round() as usize).max(c.least);
        }
    }
    balance(&mut chains, n_real)?;
    let mut out = Seams { node_at, ..Seams::default() };
    let mut id = n_given as u32;
    for c in &chains {
        let first = c.sides[0];
        let (start, _) = patch.ends(first);
        let (_, end) = patch.ends(c.sides[c.sides.len() - 1]);
        for (v, h, at_end) in [(start, first, false), (end, c.sides[c.sides.len() - 1], true)] {
            if out.node_at[v as usize] == NONE {
                out.node_at[v as usize] = id;
                id += 1;
                out.anchors.push(on_side(h, if at_end { 1.0 } else { 0.0 }));
            }
        }
        let total = c.w[c.w.len() - 1];
        for i in 1..c.n {
            let target = total * i as f64 / c.n as f64;
            let k = c.w.partition_point(|&w| w <= target).clamp(1, c.sides.len()) - 1;
            let width = c.w[k + 1] - c.w[k];
            let s = if width > 0.0 { ((target - c.w[k]) / width).clamp(0.0, 1.0) } else { 0.5 };
            let h = c.sides[k];
            out.inside.entry(h).or_default().push((s, id));
            out.inside.entry(patch.twin[h as usize]).or_default().push((1.0 - s, id));
            out.anchors.push(on_side(h, s));
            id += 1;
        }
        // The other side runs the other way.
        for h in &c.sides {
            if let Some(list) = out.inside.get_mut(&patch.twin[*h as usize]) {
                list.reverse();
            }
        }
    }
    Ok(out)
}

fn on_side(h: u32, s: f64) -> Anchor {
    let mut bary = [0.0; 3];
    bary[h as usize % 3] = 1.0 - s;
    bary[(h as usize % 3 + 1) % 3] = s;
    Anchor { facet: h / 3, bary }
}

fn chains(patch: &Patch, cut: &[bool], sizes: &[f64], chart_of: &[u32], node_at: &[u32]) -> Vec<Chain> {
    let mut leaving: Vec<(u32, u32)> = (0..cut.len() as u32)
        .filter(|&h| cut[h as usize] && patch.twin[h as usize] != NONE)
        .map(|h| (patch.ends(h).0, h))
        .collect();
    leaving.sort_unstable();
    let out_of = |v: u32| {
        let i = leaving.partition_point(|x| x.0 < v);
        let n = leaving[i..].iter().take_while(|x| x.0 == v).count();
        &leaving[i..i + n]
    };
    let junction = |v: u32| out_of(v).len() != 2 || node_at[v as usize] != NONE;
    let mut done = vec![false; cut.len()];
    let mut out = Vec::new();
    // From junctions first; what is left are closed chains.
    for closed in [false, true] {
        for &(v, h) in &leaving {
            if done[h as usize] || (!closed && !junction(v)) {
                continue;
            }
            let mut sides = vec![h];
            let mut at = h;
            loop {
                done[at as usize] = true;
                done[patch.twin[at as usize] as usize] = true;
                let end = patch.ends(at).1;
                if end == v || junction(end) {
                    break;
                }
                let Some(&(_, next)) = out_of(end).iter().find(|x| x.1 != patch.twin[at as usize]) else {
                    break;
                };
                if done[next as usize] {
                    break;
                }
                sides.push(next);
                at = next;
            }
            let mut w = vec![0.0];
            for &h in &sides {
                let (a, b) = patch.ends(h);
                let l = patch.points[a as usize].distance(patch.points[b as usize]);
                let rate = 0.5 * (1.0 / sizes[a as usize] + 1.0 / sizes[b as usize]);
                w.push(w[w.len() - 1] + l * rate);
            }
            let least = if patch.ends(at).1 == v { FEWEST.1 } else { FEWEST.0 };
            let n = (w[w.len() - 1].round() as usize).max(least);
            let charts = [chart_of[h as usize / 3], chart_of[patch.twin[h as usize] as usize / 3]];
            out.push(Chain { sides, w, n, least, charts });
        }
    }
    out
}

/// Allows a single segment where it cannot be taken for another: no other chain has the same ends, and they
/// are not both given nodes.
fn relieve(patch: &Patch, chains: &mut [Chain], node_at: &[u32]) {
    let ends = |c: &Chain| {
        let (a, b) = (patch.ends(c.sides[0]).0, patch.ends(c.sides[c.sides.len() - 1]).1);
        (a.min(b), a.max(b))
    };
    let mut all: Vec<_> = chains.iter().map(ends).collect();
    all.sort_unstable();
    for c in chains {
        let e = ends(c);
        let i = all.partition_point(|x| *x < e);
        let alone = all.get(i + 1) != Some(&e);
        let given = node_at[e.0 as usize] != NONE && node_at[e.1 as usize] != NONE;
        if alone && !given && e.0 != e.1 {
            c.least = 1;
            c.n = (c.w[c.w.len() - 1].round() as usize).max(1);
        }
    }
}

/// Changes counts by one until every chart has an even contour.
fn balance(chains: &mut [Chain], n_real: &[usize]) -> Result<(), FaceError> {
    let n = n_real.len();
    let mut odd: Vec<bool> = n_real.iter().map(|r| r % 2 == 1).collect();
    for c in chains.iter() {
        for k in c.charts {
            odd[k as usize] ^= c.n % 2 == 1;
        }
    }
    // Spanning forest, breadth first.
    let mut parent: Vec<Option<(usize, usize)>> = vec![None; n];
    let mut seen = vec![false; n];
    let mut order = Vec::with_capacity(n);
    for root in 0..n {
        if std::mem::replace(&mut seen[root], true) {
            continue;
        }
        let mut i = order.len();
        order.push(root);
        while i < order.len() {
            let at = order[i];
            for (k, c) in chains.iter().enumerate() {
                let [a, b] = c.charts.map(|x| x as usize);
                let other = if a == at {
                    b
                } else if b == at {
                    a
                } else {
                    continue;
                };
                if !std::mem::replace(&mut seen[other], true) {
                    parent[other] = Some((k, at));
                    order.push(other);
                }
            }
            i += 1;
        }
    }
    for &at in order.iter().rev() {
        if !odd[at] {
            continue;
        }
        let Some((k, up)) = parent[at] else {
            return Err(FaceError::Odd { n_segments: n_real.iter().sum() });
        };
        let c = &mut chains[k];
        let wanted = c.w[c.w.len() - 1];
        if wanted > c.n as f64 || c.n <= c.least {
            c.n += 1;
        } else {
            c.n -= 1;
        }
        odd[at] = false;
        odd[up] = !odd[up];
    }
    Ok(())
}
