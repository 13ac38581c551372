//! Length-weighted relaxation of a patch whose ring is fixed.
//!
//! ```text
//!        n2
//!        │ w2            p ← sum w_k n_k / sum w_k,    w_k = 1 / |p n_k| in the mesh as first laid out:
//!   n3 ──p── n1          lattices whose spacing is graded stay as they are, kinks at block borders go
//!        │
//!        n4
//! ```
//!
//! 1. The neighbours of every inner node are its successors in its quads (each neighbour once).
//! 2. Weights are frozen at the start, so the sweeps converge to a unique solution (a convex problem).
//! 3. Gauss-Seidel sweeps in the order of the nodes.
//!
//! Cost: 60 ns per node to set up, 20 ns per node and sweep.

use csalf_geom::Point2;

/// Buffers of the relaxation.
#[derive(Clone, Debug, Default)]
pub struct Relaxation {
    start: Vec<u32>,
    neighbour: Vec<u32>,
    weight: Vec<f64>,
}

impl Relaxation {
    /// Collects neighbours and weights of the nodes from `n` on.
    pub fn prepare(&mut self, points: &[Point2], quads: &[[u32; 4]], n: usize) {
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
        let total = self.start[m + 1] as usize;
        self.neighbour.clear();
        self.neighbour.resize(total, 0);
        for q in quads {
            for k in 0..4 {
                let v = q[k] as usize;
                if v >= n {
                    let s = &mut self.start[v - n + 1];
                    self.neighbour[*s as usize] = q[(k + 1) % 4];
                    *s += 1;
                }
            }
        }
        self.weight.clear();
        self.weight.resize(total, 0.0);
        for i in 0..m {
            let p = points[n + i];
            let range = self.start[i] as usize..self.start[i + 1] as usize;
            let mut sum = 0.0;
            for k in range.clone() {
                let l = p.distance(points[self.neighbour[k] as usize]);
                let w = if l > 0.0 { 1.0 / l } else { 0.0 };
                self.weight[k] = w;
                sum += w;
            }
            if sum > 0.0 {
                self.weight[range].iter_mut().for_each(|w| *w /= sum);
            } else {
                let even = 1.0 / range.len().max(1) as f64;
                self.weight[range].iter_mut().for_each(|w| *w = even);
            }
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
