//! tau: the paper's global quality.
//!
//! Equation (21) as printed, N / sum of Jmin/Jmax, is at least 1, while the paper's results lie in 0.68 to
//! 0.98: what is meant is the harmonic mean of Jmin/Jmax, N / sum(Jmax/Jmin) (handbook 1.12). Quads with a
//! concave or flat corner are left out; they are counted elsewhere.
//!
//! Two warnings: every parallelogram has Jmin/Jmax = 1, and a graded mesh cannot reach 1 (a ring of n
//! squarish quads reaches (n - pi)/(n + pi), handbook 1.14). Read tau beside the scaled Jacobian and the size
//! figures.

use super::{Corners, jacobian_ratio};

/// Sums towards tau; add the quads, then ask for [`Tau::mean`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tau {
    n: usize,
    sum: f64,
}

impl Tau {
    /// Adds one quad, unless it has a concave or flat corner.
    #[inline]
    pub fn add(&mut self, c: &Corners<4>) {
        if !c.is_flat() {
            self.n += 1;
            self.sum += 1.0 / jacobian_ratio::of_corners(c);
        }
    }

    /// The harmonic mean of Jmin/Jmax, in (0, 1]; `None` of no quads.
    pub fn mean(&self) -> Option<f64> {
        (self.n > 0).then(|| self.n as f64 / self.sum)
    }
}
