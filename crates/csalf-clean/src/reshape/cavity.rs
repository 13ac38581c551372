//! Disks of a few quads around a seed.
//!
//! ```text
//!   q        q and a neighbour, two, all four      stars and fans of its vertices      stars of both ends of an edge
//! ```

use crate::ops::{MAX_RIM, Site};
use csalf_geom::VertexId;
use csalf_mesh::QuadTopology;

/// Most quads of a cavity.
const MOST: usize = 12;

/// A disk of quads.
#[derive(Clone, Debug)]
pub(super) struct Cavity {
    /// Ascending.
    pub(super) quads: Vec<u32>,
    /// Counter-clockwise.
    pub(super) rim: Vec<u32>,
    /// Number of the quads at each rim vertex.
    pub(super) inside: Vec<usize>,
}

/// The cavities around quad `q`, each once, the smallest first.
pub(super) fn around(site: &Site<'_>, protected: &[bool], q: u32) -> Vec<Cavity> {
    let topology = site.topology;
    let mut sets: Vec<Vec<u32>> = vec![vec![q]];
    let beyond = |h: u32| {
        Some(topology.twin[h as usize] / 4).filter(|_| topology.twin[h as usize] != QuadTopology::NONE)
    };
    let next: Vec<u32> = (0..4).filter_map(|k| beyond(4 * q + k)).collect();
    for (i, &a) in next.iter().enumerate() {
        sets.push(vec![q, a]);
        for &b in &next[..i] {
            sets.push(vec![q, a, b]);
        }
        // A neighbour of the neighbour.
        sets.extend((0..4).filter_map(|k| beyond(4 * a + k)).filter(|&b| b != q).map(|b| vec![q, a, b]));
    }
    sets.push(std::iter::once(q).chain(next.iter().copied()).collect());
    let star = |v: VertexId| topology.star(v).iter().map(|&h| h / 4);
    let vs = site.mesh.quads[q as usize];
    for (k, &v) in vs.iter().enumerate() {
        sets.push(star(v).collect());
        sets.push(star(v).chain(star(vs[(k + 1) & 3])).collect());
        sets.push(star(v).chain(next.iter().copied()).collect());
        // The star and one more quad beyond its far sides.
        sets.extend(next.iter().map(|&n| star(v).chain([n]).collect()));
    }
    sets.push(star(vs[0]).chain(star(vs[2])).collect());
    sets.push(star(vs[1]).chain(star(vs[3])).collect());
    for s in &mut sets {
        s.sort_unstable();
        s.dedup();
    }
    sets.sort_unstable_by(|a, b| a.len().cmp(&b.len()).then_with(|| a.cmp(b)));
    sets.dedup();
    sets.retain(|s| s.len() <= MOST && s.iter().all(|&q| !protected[q as usize]));
    sets.into_iter().filter_map(|quads| disk(site, quads)).collect()
}

/// The quads as a cavity, if they are a disk with a rim that no vertex occurs in twice, no edge and no vertex inside that
/// must stay.
fn disk(site: &Site<'_>, quads: Vec<u32>) -> Option<Cavity> {
    let (mesh, topology) = (site.mesh, site.topology);
    let has = |q: u32| quads.binary_search(&q).is_ok();
    // Rim half-edges as (tail, head).
    let mut edges: Vec<(u32, u32)> = Vec::with_capacity(2 * MAX_RIM);
    for h in quads.iter().flat_map(|&q| 4 * q..4 * q + 4) {
        let vs = mesh.quads[(h / 4) as usize];
        let (a, b) = (vs[(h & 3) as usize].0, vs[((h + 1) & 3) as usize].0);
        let twin = topology.twin[h as usize];
        if twin == QuadTopology::NONE || !has(twin / 4) {
            edges.push((a, b));
        } else if site.keeps(a, b) {
            return None;
        }
    }
    let n = edges.len();
    edges.sort_unstable();
    if !(4..=MAX_RIM).contains(&n) || edges.windows(2).any(|w| w[0].0 == w[1].0) {
        return None;
    }
    let mut rim = vec![edges[0].0];
    loop {
        let last = *rim.last()?;
        let next = edges[edges.binary_search_by_key(&last, |e| e.0).ok()?].1;
        if next == rim[0] {
            break;
        }
        if rim.len() == n {
            return None;
        }
        rim.push(next);
    }
    let mut inner: Vec<u32> = quads.iter().flat_map(|&q| mesh.quads[q as usize].map(|v| v.0)).collect();
    inner.sort_unstable();
    inner.dedup();
    inner.retain(|v| !rim.contains(v));
    let free =
        |v: u32| !topology.on_boundary[v as usize] && !site.fixed.get(v as usize).copied().unwrap_or(false);
    // One walk, and Euler: a disk.
    if rim.len() != n || 2 * quads.len() + 2 != n + 2 * inner.len() || !inner.iter().all(|&v| free(v)) {
        return None;
    }
    let at = |v: u32| quads.iter().filter(|&&q| mesh.quads[q as usize].iter().any(|w| w.0 == v)).count();
    let inside = rim.iter().map(|&v| at(v)).collect();
    Some(Cavity { quads, rim, inside })
}
