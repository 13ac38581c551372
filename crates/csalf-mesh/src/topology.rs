//! Connectivity of a quad mesh, derived from it.
//!
//! ```text
//!   side k of quad q runs q[k] → q[k+1]; its half-edge is 4q + k
//!       3---2---2
//!       |       |        next, prev and quad are arithmetic; only twins are stored
//!       3   q   1
//!       |       |
//!       0---0---1
//! ```

use csalf_geom::VertexId;
use rayon::prelude::*;

/// Twins, stars and boundary of an all-quad mesh. Built in O(n) from the quads; knows no coordinates.
#[derive(Clone, Debug)]
pub struct QuadTopology {
    /// Twin of each half-edge `4 q + k`, or [`QuadTopology::NONE`] on the boundary.
    pub twin: Vec<u32>,
    /// Start of each vertex's slice in `star`; one entry more than vertices.
    pub star_start: Vec<u32>,
    /// Half-edges leaving each vertex, i.e. its quads with the vertex's corner: `4 q + corner`, ascending.
    pub star: Vec<u32>,
    /// True for vertices on a boundary half-edge.
    pub on_boundary: Vec<bool>,
    /// Number of edges that more than two quads share, or that two quads run along in the same direction. 0 in a
    /// valid mesh; such half-edges have no twin.
    pub n_bad_edges: usize,
}

impl QuadTopology {
    /// No half-edge.
    pub const NONE: u32 = u32::MAX;

    /// Builds the topology, in parallel if it is large. Every vertex index must be below `n_vertices`. Cost O(n); no hashing, so the result
    /// depends on nothing but the input.
    pub fn new(n_vertices: usize, quads: &[[VertexId; 4]]) -> Self {
        let mut star_start = vec![0u32; n_vertices + 1];
        for q in quads {
            for v in q {
                star_start[v.index() + 1] += 1;
            }
        }
        for i in 0..n_vertices {
            star_start[i + 1] += star_start[i];
        }
        let mut fill = star_start.clone();
        let mut star = vec![0u32; 4 * quads.len()];
        for (q, vs) in quads.iter().enumerate() {
            for (k, v) in vs.iter().enumerate() {
                let f = &mut fill[v.index()];
                star[*f as usize] = (4 * q + k) as u32;
                *f += 1;
            }
        }
        let head = |h: u32| quads[(h / 4) as usize][((h + 1) & 3) as usize];
        let tail = |h: u32| quads[(h / 4) as usize][(h & 3) as usize];
        let out = |v: VertexId| &star[star_start[v.index()] as usize..star_start[v.index() + 1] as usize];
        // The half-edge that runs back along h: the only one that comes from its head into its tail. First in the order
        // of the stars.
        let mut back = vec![Self::NONE; star.len()];
        for_each_star(&star_start, &mut back, |v, back| {
            let quads_at = &star[star_start[v] as usize..star_start[v + 1] as usize];
            for (slot, &h) in back.iter_mut().zip(quads_at) {
                let b = head(h);
                for &g in quads_at {
                    let into = (g & !3) | ((g + 3) & 3);
                    if tail(into) == b {
                        *slot = if *slot == Self::NONE { into } else { MANY };
                    }
                }
            }
        });
        let mut twin = vec![Self::NONE; 4 * quads.len()];
        for (&h, &t) in star.iter().zip(&back) {
            twin[h as usize] = t;
        }
        // A pair must be one both ways; a half-edge without a partner must be alone in its direction.
        let is_pair = |h: usize| twin.get(twin[h] as usize).is_some_and(|&back| back == h as u32);
        let mut on_boundary = vec![false; n_vertices];
        let mut bad = filter_indices(twin.len(), |h| !is_pair(h));
        bad.retain(|&i| {
            let h = i as u32;
            let lone = || out(tail(h)).iter().filter(|&&g| head(g) == head(h)).count() == 1;
            let boundary = twin[i] == Self::NONE && lone();
            if boundary {
                on_boundary[tail(h).index()] = true;
                on_boundary[head(h).index()] = true;
            }
            !boundary
        });
        let n_bad_edges = bad.len();
        for h in bad {
            twin[h] = Self::NONE;
        }
        Self { twin, star_start, star, on_boundary, n_bad_edges }
    }

    /// The quads at `v`, as half-edges `4 q + corner`.
    #[inline]
    pub fn star(&self, v: VertexId) -> &[u32] {
        &self.star[self.star_start[v.index()] as usize..self.star_start[v.index() + 1] as usize]
    }

    /// Number of quads at `v` (for an inner vertex this is its valence).
    #[inline]
    pub fn n_quads_at(&self, v: VertexId) -> usize {
        (self.star_start[v.index() + 1] - self.star_start[v.index()]) as usize
    }

    /// The neighbours of `v` on the boundary: before and after it, material on the left. `None` if it is not on the
    /// boundary, or if the boundary passes more than once. `quads` must be those of the topology.
    pub fn boundary_neighbours(&self, v: VertexId, quads: &[[VertexId; 4]]) -> Option<[VertexId; 2]> {
        let (mut before, mut after, mut n_out) = (None, None, 0);
        for &h in self.star(v) {
            let q = quads[(h / 4) as usize];
            if self.twin[h as usize] == Self::NONE {
                after = Some(q[((h + 1) & 3) as usize]);
                n_out += 1;
            }
            let previous = (h & !3) | ((h + 3) & 3);
            if self.twin[previous as usize] == Self::NONE {
                before = Some(q[((h + 3) & 3) as usize]);
            }
        }
        if n_out == 1 { Some([before?, after?]) } else { None }
    }

    /// Inner vertices whose valence is not 4, ascending.
    pub fn irregular(&self) -> Vec<VertexId> {
        (0..self.on_boundary.len())
            .map(VertexId::new)
            .filter(|&v| !self.on_boundary[v.index()] && !matches!(self.n_quads_at(v), 0 | 4))
            .collect()
    }
}

/// More than one candidate for a twin.
const MANY: u32 = u32::MAX - 1;

/// Entries of one parallel task; arrays up to this size are done in place.
const CHUNK: usize = 1 << 16;

/// Calls `f` with every vertex and the part of `list` that belongs to its star.
fn for_each_star(star_start: &[u32], list: &mut [u32], f: impl Fn(usize, &mut [u32]) + Sync) {
    let all = |first: usize, starts: &[u32], mut list: &mut [u32]| {
        for (i, w) in starts.windows(2).enumerate() {
            let (star, rest) = std::mem::take(&mut list).split_at_mut((w[1] - w[0]) as usize);
            f(first + i, star);
            list = rest;
        }
    };
    let n = star_start.len() - 1;
    if n <= CHUNK {
        all(0, star_start, list);
        return;
    }
    let mut rest = list;
    let mut tasks = Vec::with_capacity(n / CHUNK + 1);
    for first in (0..n).step_by(CHUNK) {
        let starts = &star_start[first..=(first + CHUNK).min(n)];
        let (part, after) = rest.split_at_mut((starts[starts.len() - 1] - starts[0]) as usize);
        tasks.push((first, starts, part));
        rest = after;
    }
    tasks.into_par_iter().for_each(|(first, starts, part)| all(first, starts, part));
}

/// The indices below `n` that satisfy `f`, ascending.
fn filter_indices(n: usize, f: impl Fn(usize) -> bool + Sync) -> Vec<usize> {
    if n <= CHUNK {
        (0..n).filter(|&i| f(i)).collect()
    } else {
        (0..n).into_par_iter().with_min_len(CHUNK).filter(|&i| f(i)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(i: usize) -> VertexId {
        VertexId::new(i)
    }

    #[test]
    fn two_quads_share_an_edge() {
        let q = [[v(0), v(1), v(4), v(3)], [v(1), v(2), v(5), v(4)]];
        let t = QuadTopology::new(6, &q);
        assert_eq!(t.twin[1], 7);
        assert_eq!(t.twin[7], 1);
        assert_eq!(t.twin.iter().filter(|&&h| h == QuadTopology::NONE).count(), 6);
        assert!(t.on_boundary.iter().all(|&b| b));
        assert_eq!(t.n_bad_edges, 0);
        assert_eq!(t.n_quads_at(v(1)), 2);
        assert_eq!(t.boundary_neighbours(v(1), &q), Some([v(0), v(2)]));
    }

    #[test]
    fn edges_run_twice_in_one_direction_are_bad() {
        let q = [[v(0), v(1), v(2), v(3)], [v(0), v(1), v(4), v(5)]];
        assert_eq!(QuadTopology::new(6, &q).n_bad_edges, 2);
    }
}
