//! Exact sign decisions: the only user of the `robust` crate.
//!
//! Source: J. R. Shewchuk, *Adaptive precision floating-point arithmetic and fast robust geometric predicates*,
//! Discrete & Computational Geometry 18 (1997) 305-363.

use crate::Point2;

/// Twice the signed area of triangle `abc`; its **sign is exact**, its value is approximate.
/// Positive: `c` lies left of `a → b`.
///
/// The first stage of the adaptive evaluation is here, to be inlined: about 2 ns where it decides, which is nearly
/// always; `robust` does the rest. Both give the same bits.
#[inline]
pub fn orient2d(a: Point2, b: Point2, c: Point2) -> f64 {
    let (u, v) = (a - c, b - c);
    let (left, right) = (u.x * v.y, u.y * v.x);
    let det = left - right;
    if det.abs() >= ORIENT_BOUND * (left.abs() + right.abs()) { det } else { orient2d_adapt(a, b, c) }
}

/// (3 + 16 u) u with u = 2^-53: Shewchuk's bound A of the rounding error of the determinant, relative to the sum of
/// its products.
const ORIENT_BOUND: f64 = (3.0 + 8.0 * f64::EPSILON) * 0.5 * f64::EPSILON;

#[cold]
#[inline(never)]
fn orient2d_adapt(a: Point2, b: Point2, c: Point2) -> f64 {
    let c2 = |p: Point2| robust::Coord { x: p.x, y: p.y };
    robust::orient2d(c2(a), c2(b), c2(c))
}

/// Exact: `c` lies strictly left of `a → b`.
#[inline]
pub fn is_left(a: Point2, b: Point2, c: Point2) -> bool {
    orient2d(a, b, c) > 0.0
}

/// Exact: `d` lies strictly inside the circle through the counter-clockwise triangle `abc`.
#[inline]
pub fn in_circle(a: Point2, b: Point2, c: Point2, d: Point2) -> bool {
    let c2 = |p: Point2| robust::Coord { x: p.x, y: p.y };
    robust::incircle(c2(a), c2(b), c2(c), c2(d)) > 0.0
}

/// Exact: `p`, known to be collinear with `a` and `b`, lies on the closed segment `ab`.
#[inline]
pub fn between(a: Point2, b: Point2, p: Point2) -> bool {
    if a.x == b.x {
        (a.y <= p.y && p.y <= b.y) || (b.y <= p.y && p.y <= a.y)
    } else {
        (a.x <= p.x && p.x <= b.x) || (b.x <= p.x && p.x <= a.x)
    }
}

/// Exact: `p` lies on the closed segment `ab`.
#[inline]
pub fn on_segment(a: Point2, b: Point2, p: Point2) -> bool {
    orient2d(a, b, p) == 0.0 && between(a, b, p)
}

/// How two closed segments meet.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Meeting {
    /// They have no point in common.
    Apart,
    /// They cross in a single point inside both.
    Cross,
    /// They have a point in common that is an end of at least one of them, or they overlap.
    Touch,
}

/// Exact: how the closed segments `ab` and `cd` meet. Shared ends count as [`Meeting::Touch`].
pub fn meeting(a: Point2, b: Point2, c: Point2, d: Point2) -> Meeting {
    if a.x.max(b.x) < c.x.min(d.x)
        || c.x.max(d.x) < a.x.min(b.x)
        || a.y.max(b.y) < c.y.min(d.y)
        || c.y.max(d.y) < a.y.min(b.y)
    {
        return Meeting::Apart;
    }
    let (o1, o2) = (orient2d(a, b, c), orient2d(a, b, d));
    if (o1 > 0.0 && o2 > 0.0) || (o1 < 0.0 && o2 < 0.0) {
        return Meeting::Apart;
    }
    let (o3, o4) = (orient2d(c, d, a), orient2d(c, d, b));
    if (o3 > 0.0 && o4 > 0.0) || (o3 < 0.0 && o4 < 0.0) {
        return Meeting::Apart;
    }
    if o1 != 0.0 && o2 != 0.0 && o3 != 0.0 && o4 != 0.0 {
        return Meeting::Cross;
    }
    let touch = (o1 == 0.0 && between(a, b, c))
        || (o2 == 0.0 && between(a, b, d))
        || (o3 == 0.0 && between(c, d, a))
        || (o4 == 0.0 && between(c, d, b));
    if touch { Meeting::Touch } else { Meeting::Apart }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meetings_of_segments() {
        let p = Point2::new;
        assert_eq!(meeting(p(0., 0.), p(2., 2.), p(0., 2.), p(2., 0.)), Meeting::Cross);
        assert_eq!(meeting(p(0., 0.), p(2., 0.), p(1., 0.), p(1., 1.)), Meeting::Touch);
        assert_eq!(meeting(p(0., 0.), p(2., 0.), p(1., 0.), p(3., 0.)), Meeting::Touch);
        assert_eq!(meeting(p(0., 0.), p(2., 0.), p(3., 0.), p(4., 0.)), Meeting::Apart);
        assert_eq!(meeting(p(0., 0.), p(2., 0.), p(1., 1e-300), p(1., 1.)), Meeting::Apart);
        assert_eq!(meeting(p(0., 0.), p(1., 1.), p(1., 1.), p(2., 0.)), Meeting::Touch);
    }

    /// The inlined stage decides as `robust` does, bit for bit, also at the bound, for zeros and for huge numbers.
    #[test]
    fn the_inlined_stage_is_that_of_robust() {
        let c2 = |p: Point2| robust::Coord { x: p.x, y: p.y };
        let mut seed = 0x9e37_79b9_7f4a_7c15u64;
        let mut random = || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            seed
        };
        for round in 0..20_000 {
            // A coarse lattice (many zeros), and points a few units in the last place off a line.
            let mut p = || {
                let k = (random() % 9) as f64 - 4.0;
                let noise = (random() % 5) as f64 * f64::EPSILON;
                if round % 2 == 0 {
                    Point2::new(k, noise * 1e17)
                } else {
                    Point2::new(k + noise, 0.3 * k) * 1e6
                }
            };
            let (a, b, c) = (p(), p(), p());
            let want = robust::orient2d(c2(a), c2(b), c2(c));
            assert_eq!(orient2d(a, b, c).to_bits(), want.to_bits(), "{a} {b} {c}");
        }
    }

    #[test]
    fn orientation_is_exact_where_floats_fail() {
        // Three points of y = x, moved by one unit in the last place.
        let e = f64::EPSILON;
        let (a, b) = (Point2::new(12.0, 12.0), Point2::new(24.0, 24.0));
        assert_eq!(orient2d(a, b, Point2::new(0.5, 0.5)), 0.0);
        assert!(orient2d(a, b, Point2::new(0.5, 0.5 + e)) > 0.0);
        assert!(orient2d(a, b, Point2::new(0.5 + e, 0.5)) < 0.0);
    }
}
