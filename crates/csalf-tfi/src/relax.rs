//! Size-weighted relaxation of a patch whose ring is fixed.
//!
//! ```text
//!        n2
//!        │ w2            p ← sum w_k n_k / sum w_k,    w_k = 1 / h: in one dimension the fixed point has
//!   n3 ──p── n1          l_k proportional to h, so the patch follows the size field
//!        │
//!        n4
//! ```
//!
//! 1. The neighbours of every inner node are its successors in its quads (each neighbour once).
//! 2. Weights are frozen at the start, so the sweeps converge to a unique solution (a convex problem).
//! 3. Gauss-Seidel sweeps in the order of the nodes.
//!
//! Cost: 60 ns per node to set up (and a size query per quad, unless h is constant), 20 ns per node and
//! sweep.

use csalf_geom::Point2;
use csalf_sizemap::{Hint, SizeField};

/// Buffers of the relaxation.
#[derive(Clone, Debug, Default)]
pub struct Relaxation {
    start: Vec<u32>,
    neighbour: Vec<u32>,
    weight: Vec<f64>,
    slot: Vec<u32>,
}

/// Not an active node.
const NONE: u32 = u32::MAX;

impl Relaxation {
    /// Collects neighbours and weights of the `active` nodes, none of which is below `n`. `factor`: how
    /// many real edges an edge along sides 0 and 2, or 1 and 3, of each quad stands for; empty: one.
    pub fn prepare(
        &mut self,
        points: &[Point2],
        quads: &[[u32; 4]],
        n: usize,
        active: &[u32],
        size: &dyn SizeField,
        factor: &[[f64; 2]],
    ) {
        let m = active.len();
        self.slot.clear();
        self.slot.resize(points.len() - n, NONE);
        active.iter().zip(0..).for_each(|(&v, i)| self.slot[v as usize - n] = i);
        self.start.clear();
        self.start.resize(m + 2, 0);
        let slot = |v: u32| if (v as usize) < n { NONE } else { self.slot[v as usize - n] };
        for &v in quads.iter().flatten() {
            let i = slot(v);
            if i != NONE {
                self.start[i as usize + 2] += 1;
            }
        }
        for i in 2..m + 2 {
            self.start[i] += self.start[i - 1];
        }
        let total = self.start[m + 1] as usize;
        self.neighbour.clear();
        self.neighbour.resize(total, 0);
        self.weight.clear();
        self.weight.resize(total, 1.0);
        let plain = size.constant().is_some() && factor.is_empty();
        let mut hint = Hint::default();
        for (i, q) in quads.iter().enumerate() {
            let h = q.map(slot);
            if h == [NONE; 4] {
                continue;
            }
            // One size per quad: an edge gets the mean rate of its two quads by the two ways it is stored.
            let rate = if plain {
                1.0
            } else {
                let middle = q.iter().map(|&v| points[v as usize]).sum::<Point2>() * 0.25;
                1.0 / size.h(middle, &mut hint)
            };
            for k in 0..4 {
                if h[k] != NONE {
                    let s = &mut self.start[h[k] as usize + 1];
                    self.neighbour[*s as usize] = q[(k + 1) % 4];
                    self.weight[*s as usize] = rate / factor.get(i).map_or(1.0, |f| f[k % 2]);
                    *s += 1;
                }
            }
        }
        for i in 0..m {
            let range = self.start[i] as usize..self.start[i + 1] as usize;
            let scale = 1.0 / self.weight[range.clone()].iter().sum::<f64>();
            self.weight[range].iter_mut().for_each(|w| *w *= scale);
        }
    }

    /// One sweep over the active nodes.
    pub fn sweep(&self, points: &mut [Point2], active: &[u32]) {
        for (i, &v) in active.iter().enumerate() {
            let mut s = Point2::ZERO;
            for k in self.start[i] as usize..self.start[i + 1] as usize {
                s += points[self.neighbour[k] as usize] * self.weight[k];
            }
            points[v as usize] = s;
        }
    }
}
