//! The cone of material at a node of a contour, by exact predicates.

use crate::{Point2, predicates::orient2d};

/// Exact: direction `b → q` points strictly into the material at `b`, between the outgoing segment `b → next` and
/// (counter-clockwise) the incoming one seen from `b`, `b → prev`. At a slit tip (`prev` and `next` in the same
/// direction) everything but that direction is material.
pub fn in_cone(prev: Point2, b: Point2, next: Point2, q: Point2) -> bool {
    let turn = orient2d(prev, b, next);
    let (left_of_out, left_of_in) = (orient2d(b, next, q), orient2d(prev, b, q));
    if turn > 0.0 {
        left_of_out > 0.0 && left_of_in > 0.0
    } else if turn < 0.0 {
        left_of_out > 0.0 || left_of_in > 0.0
    } else if (next - b).dot(prev - b) < 0.0 {
        left_of_out > 0.0
    } else {
        !(left_of_out == 0.0 && (next - b).dot(q - b) > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cones_of_all_kinds() {
        let p = Point2::new;
        let b = p(0., 0.);
        // Convex corner: material in the first quadrant.
        assert!(in_cone(p(0., 1.), b, p(1., 0.), p(1., 1.)));
        assert!(!in_cone(p(0., 1.), b, p(1., 0.), p(1., 0.)));
        assert!(!in_cone(p(0., 1.), b, p(1., 0.), p(-1., 1.)));
        // Flat: material above.
        assert!(in_cone(p(-1., 0.), b, p(1., 0.), p(0., 1.)));
        assert!(!in_cone(p(-1., 0.), b, p(1., 0.), p(0., -1.)));
        assert!(!in_cone(p(-1., 0.), b, p(1., 0.), p(2., 0.)));
        // Reflex corner: all but the third quadrant... material everywhere but x < 0, y < 0.
        assert!(in_cone(p(-1., 0.), b, p(0., -1.), p(1., -1.)));
        assert!(in_cone(p(-1., 0.), b, p(0., -1.), p(-1., 1.)));
        assert!(!in_cone(p(-1., 0.), b, p(0., -1.), p(-1., -1.)));
        assert!(!in_cone(p(-1., 0.), b, p(0., -1.), p(0., -2.)));
        // Tip of a slit along -x.
        assert!(in_cone(p(-1., 0.), b, p(-1., 0.), p(-1., 1e-9)));
        assert!(!in_cone(p(-1., 0.), b, p(-1., 0.), p(-2., 0.)));
        assert!(in_cone(p(-1., 0.), b, p(-1., 0.), p(2., 0.)));
    }
}
