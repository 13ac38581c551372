//! Quad measures that the paver decides by.

use csalf_geom::Point2;
use csalf_geom::predicates::orient2d;

/// Smallest sine of the four corner angles, signed: 1 for a rectangle, <= 0 for a quad that is not strictly convex.
/// Coincident corners give -1.
#[inline]
pub fn scaled_jacobian(q: &[Point2; 4]) -> f64 {
    let e = [q[1] - q[0], q[2] - q[1], q[3] - q[2], q[0] - q[3]];
    let l = e.map(|v| v.length());
    let mut worst = f64::INFINITY;
    for k in 0..4 {
        let j = (k + 3) & 3;
        worst = worst.min(e[j].perp_dot(e[k]) / (l[j] * l[k]));
    }
    if worst.is_nan() { -1.0 } else { worst }
}

/// Exact: all four corners turn left, so the quad is strictly convex and counter-clockwise.
#[inline]
pub fn strictly_convex(q: &[Point2; 4]) -> bool {
    (0..4).all(|k| orient2d(q[k], q[(k + 1) & 3], q[(k + 2) & 3]) > 0.0)
}
