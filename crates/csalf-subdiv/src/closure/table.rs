//! The stencils, one row per class, and their placements.
//!
//! Data made by the enumeration in `generate.rs`, which a test runs again and compares.

use csalf_geom::Point2;
use std::sync::LazyLock;

/// Most rim nodes, inner nodes and quads of a stencil.
pub(super) const MAX_RIM: usize = 8;
pub(super) const MAX_INNER: usize = 4;
pub(super) const MAX_QUADS: usize = 5;

/// One class of stencils: rim nodes 0..n, inner nodes from n on.
#[derive(Debug)]
pub(super) struct Stencil {
    pub(super) n: u8,
    pub(super) inner: u8,
    pub(super) quads: &'static [[u8; 4]],
}

/// All classes with up to 4, 3 and 2 inner nodes of valence at least 3, for 4, 6 and 8 rim nodes (handbook 4.9).
/// More inner nodes belong to the splitter, which places them by size.
#[rustfmt::skip]
pub(super) const STENCILS: [Stencil; 14] = [
    Stencil { n: 4, inner: 0, quads: &[[0, 1, 2, 3]] },
    Stencil { n: 4, inner: 4, quads: &[[0, 1, 4, 5], [0, 5, 6, 3], [1, 2, 7, 4], [2, 3, 6, 7], [4, 7, 6, 5]] },
    Stencil { n: 6, inner: 0, quads: &[[0, 1, 2, 3], [0, 3, 4, 5]] },
    Stencil { n: 6, inner: 1, quads: &[[0, 1, 2, 6], [0, 6, 4, 5], [2, 3, 4, 6]] },
    Stencil { n: 6, inner: 2, quads: &[[0, 1, 2, 6], [0, 6, 7, 5], [2, 3, 7, 6], [3, 4, 5, 7]] },
    Stencil { n: 6, inner: 3, quads: &[[0, 1, 2, 6], [0, 6, 7, 5], [2, 3, 4, 8], [2, 8, 7, 6], [4, 5, 7, 8]] },
    Stencil { n: 8, inner: 0, quads: &[[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 7]] },
    Stencil { n: 8, inner: 0, quads: &[[0, 1, 2, 3], [0, 3, 4, 7], [4, 5, 6, 7]] },
    Stencil { n: 8, inner: 1, quads: &[[0, 1, 2, 3], [0, 3, 4, 8], [0, 8, 6, 7], [4, 5, 6, 8]] },
    Stencil { n: 8, inner: 1, quads: &[[0, 1, 2, 8], [0, 8, 6, 7], [2, 3, 4, 8], [4, 5, 6, 8]] },
    Stencil { n: 8, inner: 2, quads: &[[0, 1, 2, 3], [0, 3, 4, 8], [0, 8, 9, 7], [4, 5, 9, 8], [5, 6, 7, 9]] },
    Stencil { n: 8, inner: 2, quads: &[[0, 1, 2, 3], [0, 3, 8, 9], [0, 9, 6, 7], [3, 4, 5, 8], [5, 6, 9, 8]] },
    Stencil { n: 8, inner: 2, quads: &[[0, 1, 2, 8], [0, 8, 4, 9], [0, 9, 6, 7], [2, 3, 4, 8], [4, 5, 6, 9]] },
    Stencil { n: 8, inner: 2, quads: &[[0, 1, 2, 8], [0, 8, 6, 7], [2, 3, 9, 8], [3, 4, 5, 9], [5, 6, 8, 9]] },
];

/// A stencil turned or reflected, with all that its use needs.
#[derive(Clone, Debug)]
pub(super) struct Placement {
    pub(super) n: usize,
    pub(super) n_inner: usize,
    pub(super) n_quads: usize,
    pub(super) quads: [[u8; 4]; MAX_QUADS],
    /// Quads at each rim node.
    pub(super) valence: [f64; MAX_RIM],
    /// What its inner nodes cost: sum (d - 4)² + 0.15 per node (handbook 4.9).
    pub(super) cost: f64,
    /// Inner node k of the smoothed stencil is the sum over the rim nodes of `weight[k][i] * rim[i]`.
    pub(super) weight: [[f64; MAX_RIM]; MAX_INNER],
}

/// Cost of an inner node as such, so that of two equal stencils the simpler one is taken.
const INNER_COST: f64 = 0.15;

impl Placement {
    fn new(s: &Stencil, shift: u8, reflect: bool) -> Self {
        let to = |v: u8| match v {
            v if v >= s.n => v,
            v if reflect => (shift + s.n - v) % s.n,
            v => (shift + v) % s.n,
        };
        let (n, n_inner) = (s.n as usize, s.inner as usize);
        let mut quads = [[0; 4]; MAX_QUADS];
        let mut valence = [0.0; MAX_RIM];
        let mut inner_valence = [0.0; MAX_INNER];
        for (q, from) in quads.iter_mut().zip(s.quads) {
            *q = from.map(to);
            if reflect {
                q.reverse();
            }
            for &v in q.iter() {
                match (v as usize).checked_sub(n) {
                    Some(k) => inner_valence[k] += 1.0,
                    None => valence[v as usize] += 1.0,
                }
            }
        }
        let cost = inner_valence[..n_inner].iter().map(|d: &f64| (d - 4.0).powi(2) + INNER_COST).sum();
        let weight = harmonic(&quads[..s.quads.len()], n, n_inner);
        Self { n, n_inner, n_quads: s.quads.len(), quads, valence, cost, weight }
    }

    /// The quads with inner nodes unnamed, in order: equal for two placements of the same mesh.
    fn key(&self) -> Vec<[u8; 4]> {
        let mut key: Vec<[u8; 4]> = self.quads[..self.n_quads]
            .iter()
            .map(|q| {
                let mut q = q.map(|v| if (v as usize) < self.n { v } else { u8::MAX });
                let first = (0..4).min_by_key(|&k| (q[k], q[(k + 1) % 4], q[(k + 2) % 4])).unwrap_or(0);
                q.rotate_left(first);
                q
            })
            .collect();
        key.sort_unstable();
        key
    }

    /// The points of a local name.
    #[inline]
    pub(super) fn at(&self, rim: &[Point2], inner: &[Point2; MAX_INNER], v: u8) -> Point2 {
        let v = v as usize;
        if v < self.n { rim[v] } else { inner[v - self.n] }
    }
}

/// Weights of the limit of Laplace sweeps: every inner node is the mean of its neighbours. Gaussian elimination of a
/// weakly diagonally dominant matrix, every component of which touches the rim: no pivoting is needed.
fn harmonic(quads: &[[u8; 4]], n: usize, n_inner: usize) -> [[f64; MAX_RIM]; MAX_INNER] {
    let mut m = [[0.0f64; MAX_INNER]; MAX_INNER];
    let mut weight = [[0.0; MAX_RIM]; MAX_INNER];
    for q in quads {
        for c in 0..4 {
            let Some(k) = (q[c] as usize).checked_sub(n) else { continue };
            // Each neighbour of an inner node is the next corner in exactly one of its quads.
            let v = q[(c + 1) % 4] as usize;
            m[k][k] += 1.0;
            match v.checked_sub(n) {
                Some(j) => m[k][j] -= 1.0,
                None => weight[k][v] += 1.0,
            }
        }
    }
    for i in 0..n_inner {
        let (pivot, from) = (m[i], weight[i]);
        for j in (0..n_inner).filter(|&j| j != i) {
            let f = m[j][i] / pivot[i];
            if f != 0.0 {
                m[j].iter_mut().zip(pivot).for_each(|(a, b)| *a -= f * b);
                weight[j].iter_mut().zip(from).for_each(|(a, b)| *a -= f * b);
            }
        }
    }
    for k in 0..n_inner {
        weight[k] = weight[k].map(|w| w / m[k][k]);
    }
    weight
}

/// The distinct placements of all stencils with `n` rim nodes (4, 6 or 8; none otherwise).
pub(super) fn placements(n: usize) -> &'static [Placement] {
    static ALL: LazyLock<[Vec<Placement>; 3]> = LazyLock::new(|| [build(4), build(6), build(8)]);
    match n {
        4 => &ALL[0],
        6 => &ALL[1],
        8 => &ALL[2],
        _ => &[],
    }
}

fn build(n: u8) -> Vec<Placement> {
    let mut all: Vec<Placement> = Vec::new();
    let mut keys = Vec::new();
    for s in STENCILS.iter().filter(|s| s.n == n) {
        for reflect in [false, true] {
            for shift in 0..n {
                let p = Placement::new(s, shift, reflect);
                if !keys.contains(&p.key()) {
                    keys.push(p.key());
                    all.push(p);
                }
            }
        }
    }
    all
}
