//! Angles at the nodes of loops, in radians.

use crate::Point2;
use std::f64::consts::TAU;

/// Interior angle at `b` between the incoming segment `a → b` and the outgoing one `b → c`: the counter-clockwise
/// angle from `bc` to `ba`, in (0, 2π]. Equal directions give 2π, the angle of a slit tip; a needle of angle 0 must
/// be told from it by the ids of the neighbours, which are equal only at a tip.
#[inline]
pub fn interior_angle(a: Point2, b: Point2, c: Point2) -> f64 {
    let (u, v) = (c - b, a - b);
    let t = u.perp_dot(v).atan2(u.dot(v));
    if t <= 0.0 { t + TAU } else { t }
}

/// Counter-clockwise angle from direction `u` to direction `v`, in [0, 2π).
#[inline]
pub fn turn(u: Point2, v: Point2) -> f64 {
    let t = u.perp_dot(v).atan2(u.dot(v));
    if t < 0.0 { t + TAU } else { t }
}

/// `u` turned counter-clockwise by `angle` radians.
#[inline]
pub fn rotated(u: Point2, angle: f64) -> Point2 {
    let (s, c) = angle.sin_cos();
    Point2::new(c * u.x - s * u.y, s * u.x + c * u.y)
}

/// Number of quads wanted at a boundary node of interior angle `theta`: 1 to 4, `round(theta / 90°)`.
#[inline]
pub fn wanted_quads(theta: f64) -> u8 {
    ((theta / std::f64::consts::FRAC_PI_2 + 0.5) as u8).clamp(1, 4)
}

/// Direction of `d` as an angle in [-π, π], to within 2e-5 radians and about four times as fast as `atan2`: for
/// scores that rank many candidates, never for a decision on a side.
#[inline]
pub fn rough_direction(d: Point2) -> f64 {
    use std::f64::consts::{FRAC_PI_2, PI};
    let (ax, ay) = (d.x.abs(), d.y.abs());
    let swap = ay > ax;
    let (small, large) = if swap { (ax, ay) } else { (ay, ax) };
    if large == 0.0 {
        return 0.0;
    }
    let t = small / large;
    let s = t * t;
    // Odd polynomial, least squares over [0, 1].
    let p = -0.011_721_20;
    let p = 0.052_653_32 + s * p;
    let p = -0.116_432_87 + s * p;
    let p = 0.193_543_46 + s * p;
    let p = -0.332_623_47 + s * p;
    let mut a = t * (0.999_977_26 + s * p);
    if swap {
        a = FRAC_PI_2 - a;
    }
    if d.x < 0.0 {
        a = PI - a;
    }
    if d.y < 0.0 { -a } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rough_directions_are_close() {
        for i in 0..10_000 {
            let t = (i as f64 / 5000.0 - 1.0) * std::f64::consts::PI;
            let d = Point2::new(t.cos(), t.sin()) * (1.0 + i as f64);
            assert!((rough_direction(d) - d.y.atan2(d.x)).abs() < 2e-5, "at {t}");
        }
        assert_eq!(rough_direction(Point2::ZERO), 0.0);
    }

    #[test]
    fn interior_angles() {
        let p = Point2::new;
        let deg = |a, b, c| interior_angle(a, b, c).to_degrees();
        assert!((deg(p(-1., 0.), p(0., 0.), p(1., 0.)) - 180.0).abs() < 1e-12);
        assert!((deg(p(0., 1.), p(0., 0.), p(1., 0.)) - 90.0).abs() < 1e-12);
        assert!((deg(p(-1., 0.), p(0., 0.), p(0., -1.)) - 270.0).abs() < 1e-12);
        assert!((deg(p(1., 0.), p(0., 0.), p(1., 0.)) - 360.0).abs() < 1e-12);
    }
}
