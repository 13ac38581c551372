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
//! Cost: 60 ns per node to set up (and a size query per node, unless h is constant), 20 ns per node and sweep.

use csalf_geom::Point2;
use csalf_sizemap::{Hint, SizeField};

/// Buffers of the relaxation.
#[derive(Clone, Debug, Default)]
pub struct Relaxation {
    start: Vec<u32>,
    neighbour: Vec<u32>,
    weight: Vec<f64>,
    h: Vec<f64>,
}

impl Relaxation {
    /// Collects neighbours and weights of the nodes from `n` on. `factor`: how many real edges an edge along sides
    /// 0 and 2, or 1 and 3, of each quad stands for; empty: one.
    pub fn prepare(
        &mut self,
        points: &[Point2],
        quads: &[[u32; 4]],
        n: usize,
        size: &dyn SizeField,
        factor: &[[f64; 2]],
    ) {
        let m = points.len() - n;
        self.start.clear();
        self.start.resize(m + 2, 0);
        for &v in quads.iter().flatten() {
            if v as usize >= n {
                self.start[v as usize - n + 2] += 1;
            }
        }
        for i in 2..m + 2 {
            self.start[i] += self.start[i - 1];
        }
        self.h.clear();
        if size.constant().is_none() {
            let mut hint = Hint::default();
            self.h.extend(points.iter().map(|&p| size.h(p, &mut hint)));
        }
        let total = self.start[m + 1] as usize;
        self.neighbour.clear();
        self.neighbour.resize(total, 0);
        self.weight.clear();
        self.weight.resize(total, 1.0);
        let plain = self.h.is_empty() && factor.is_empty();
        for (i, q) in quads.iter().enumerate() {
            for k in 0..4 {
                let v = q[k] as usize;
                if v >= n {
                    let u = q[(k + 1) % 4] as usize;
                    let s = &mut self.start[v - n + 1];
                    self.neighbour[*s as usize] = u as u32;
                    if !plain {
                        let h = if self.h.is_empty() { 1.0 } else { 0.5 * (self.h[u] + self.h[v]) };
                        self.weight[*s as usize] = 1.0 / (h * factor.get(i).map_or(1.0, |f| f[k % 2]));
                    }
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

    /// One sweep over the nodes from `n` on.
    pub fn sweep(&self, points: &mut [Point2], n: usize) {
        for i in 0..points.len() - n {
            let mut s = Point2::ZERO;
            for k in self.start[i] as usize..self.start[i + 1] as usize {
                s += points[self.neighbour[k] as usize] * self.weight[k];
            }
            points[n + i] = s;
        }
    }
}
