//! Corner Jacobians and edge vectors of one element: the raw material of all metrics.
//!
//! ```text
//!    3 ←── e2 ── 2      e_k = p[k+1] - p[k]
//!    │           ↑      J_k = e_k × (p[k-1] - p[k]) = e_{k-1} × e_k : twice the area of the corner triangle
//!   e3           e1
//!    ↓           │      For a bilinear quad det J at corner k is J_k; its extrema are at the corners.
//!    0 ── e0 ──→ 1
//! ```

use csalf_geom::Point2;

/// Corner data of an element with `K` corners (4 or 3), counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corners<const K: usize> {
    /// Corner Jacobians, in length².
    pub jacobian: [f64; K],
    /// Length of side k, from corner k to corner k + 1.
    pub length: [f64; K],
    /// Scaled Jacobian of each corner, the sine of its angle, -1 to 1; -1 where a side has no length.
    pub scaled: [f64; K],
    /// Signed area.
    pub area: f64,
}

impl<const K: usize> Corners<K> {
    /// Computes the corner data of `p`. Costs K square roots.
    #[inline]
    pub fn new(p: &[Point2; K]) -> Self {
        let mut jacobian = [0.0; K];
        let mut length = [0.0; K];
        let mut scaled = [0.0; K];
        for k in 0..K {
            let (u, v) = (p[(k + 1) % K] - p[k], p[(k + K - 1) % K] - p[k]);
            jacobian[k] = u.perp_dot(v);
            length[k] = u.length();
        }
        for k in 0..K {
            let l = length[k] * length[(k + K - 1) % K];
            scaled[k] = if l > 0.0 { jacobian[k] / l } else { -1.0 };
        }
        let mut area = 0.0;
        for k in 1..K - 1 {
            area += 0.5 * (p[k] - p[0]).perp_dot(p[k + 1] - p[0]);
        }
        Self { jacobian, length, scaled, area }
    }

    /// Smallest scaled Jacobian of the corners.
    #[inline]
    pub fn min_scaled(&self) -> f64 {
        self.scaled.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// True if a corner is concave, or straight up to rounding ([`super::FLAT`]).
    #[inline]
    pub fn is_flat(&self) -> bool {
        self.min_scaled() <= super::FLAT
    }
}
