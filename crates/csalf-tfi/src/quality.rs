//! Scaled Jacobians and sizes of a patch.

use csalf_geom::{Point2, predicates::orient2d};
use csalf_sizemap::{Hint, SizeField};

/// Smallest and mean scaled Jacobian of a set of quads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Smallest over all quads.
    pub min_sj: f64,
    /// Mean over the quads of the smallest of each.
    pub mean_sj: f64,
}

/// Shape of the quads. A corner below 1e-8 is decided by the exact predicate: if it is not strictly convex,
/// the result's `min_sj` is at most 0. Cost: 15 ns per quad.
pub fn shape(points: &[Point2], quads: &[[u32; 4]]) -> Shape {
    let (mut min, mut sum) = (f64::INFINITY, 0.0);
    for q in quads {
        let p = q.map(|v| points[v as usize]);
        let e = [p[1] - p[0], p[2] - p[1], p[3] - p[2], p[0] - p[3]];
        let l = e.map(|e| e.length_squared());
        // Signed squares of the sines: one root per quad.
        let mut sj = f64::INFINITY;
        for k in 0..4 {
            let k1 = (k + 3) % 4;
            let det = e[k1].perp_dot(e[k]);
            let ll = l[k] * l[k1];
            sj = sj.min(det * det.abs() / ll);
        }
        // An edge of length zero makes 0/0, which min() passes over.
        let mut sj = if l.contains(&0.0) { -1.0 } else { sj.abs().sqrt().copysign(sj) };
        // Far above rounding the sign of the float is right; below, ask the exact predicate.
        if sj < NEARLY_FLAT && (0..4).any(|k| orient2d(p[(k + 3) % 4], p[k], p[(k + 1) % 4]) <= 0.0) {
            sj = sj.min(0.0);
        }
        min = min.min(sj);
        sum += sj;
    }
    if quads.is_empty() {
        return Shape { min_sj: -1.0, mean_sj: -1.0 };
    }
    Shape { min_sj: min, mean_sj: sum / quads.len() as f64 }
}

/// Scaled Jacobian below which rounding might matter: larger asks the exact predicate more often, smaller
/// would trust cancelled digits (coordinates are good to about 1e-16 of the domain, edges are above 1e-6 of
/// it).
const NEARLY_FLAT: f64 = 1e-8;

/// How well a patch follows the size field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Geometric mean over the cells of max(r, 1/r), r = sqrt(area) / h.
    pub mean: f64,
    /// Largest max(r, 1/r).
    pub worst: f64,
    /// Root mean square of ln(edge length / h).
    pub edges: f64,
}

/// Fit of at most about `most` quads, evenly chosen. `factor[q]`: how many real edges an edge along sides 0
/// and 2, or 1 and 3, of quad q stands for; empty: one. Cost: a size query per quad looked at.
pub fn fit(
    points: &[Point2],
    quads: &[[u32; 4]],
    size: &dyn SizeField,
    most: usize,
    factor: &[[f64; 2]],
) -> Fit {
    let step = quads.len().div_ceil(most.max(1)).max(1);
    let (mut sum, mut worst, mut edges, mut count) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    let mut hint = Hint::default();
    for (i, q) in quads.iter().enumerate().step_by(step) {
        let p = q.map(|v| points[v as usize]);
        let f = factor.get(i).map_or([1.0; 2], |f| *f);
        let area = 0.5 * (p[2] - p[0]).perp_dot(p[3] - p[1]) / (f[0] * f[1]);
        let h = match size.constant() {
            Some(h) => h,
            None => size.h((p[0] + p[1] + p[2] + p[3]) * 0.25, &mut hint),
        };
        let r = rough_ln(area.max(f64::MIN_POSITIVE) / (h * h)).abs() * 0.5;
        sum += r;
        worst = worst.max(r);
        for k in 0..2 {
            let l = p[k].distance(p[k + 1]) + p[k + 2].distance(p[(k + 3) % 4]);
            let e = rough_ln(l.max(f64::MIN_POSITIVE) / (2.0 * h * f[k]));
            edges += 0.5 * e * e;
        }
        count += 1.0;
    }
    if count == 0.0 {
        return Fit { mean: 1.0, worst: 1.0, edges: 0.0 };
    }
    Fit { mean: (sum / count).exp(), worst: worst.exp(), edges: (edges / count).sqrt() }
}

/// ln of a normal positive number to within 1e-7: several times as fast as a call of the library.
#[inline]
pub fn rough_ln(x: f64) -> f64 {
    use std::f64::consts::{LN_2, SQRT_2};
    let bits = x.to_bits();
    let exponent = (bits >> 52) as f64 - 1023.0;
    let m = f64::from_bits(bits & ((1 << 52) - 1) | 1023 << 52);
    // ln m = ln √2 + 2 artanh t, |t| <= 0.172.
    let t = (m - SQRT_2) / (m + SQRT_2);
    let s = t * t;
    exponent * LN_2 + 0.5 * LN_2 + 2.0 * t * (1.0 + s * (1.0 / 3.0 + s * (0.2 + s * (1.0 / 7.0))))
}

#[cfg(test)]
mod tests {
    use super::rough_ln;

    #[test]
    fn rough_logarithms_are_close() {
        for i in -3000..3000 {
            let x = (f64::from(i) * 0.05).exp();
            assert!((rough_ln(x) - x.ln()).abs() < 1e-7, "{x}");
        }
        assert!((rough_ln(f64::MIN_POSITIVE) - f64::MIN_POSITIVE.ln()).abs() < 1e-6);
    }
}
