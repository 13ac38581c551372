//! Areas, perimeters and containment of closed polygons given by their nodes.

use crate::{Point2, predicates::orient2d};

/// Signed area of a closed polygon, positive counter-clockwise. Summed about the first node, so that it keeps its
/// digits far from the origin. Cost O(n).
pub fn signed_area(p: &[Point2]) -> f64 {
    let Some(&o) = p.first() else { return 0.0 };
    let mut twice = 0.0;
    for w in p.windows(2) {
        twice += (w[0] - o).perp_dot(w[1] - o);
    }
    0.5 * twice
}

/// Length of the closed polygon. Cost O(n).
pub fn perimeter(p: &[Point2]) -> f64 {
    (0..p.len()).map(|i| p[i].distance(p[(i + 1) % p.len()])).sum()
}

/// Bounding box `(low, high)`; `None` of an empty list.
pub fn bounds(p: impl IntoIterator<Item = Point2>) -> Option<(Point2, Point2)> {
    p.into_iter().fold(None, |b, q| match b {
        None => Some((q, q)),
        Some((lo, hi)) => Some((lo.min(q), hi.max(q))),
    })
}

/// Where a point lies with respect to a closed polygon.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Side {
    /// Strictly inside.
    Inside,
    /// On a segment or a node.
    Boundary,
    /// Strictly outside.
    Outside,
}

/// Exact point location by crossing parity. Cost O(n).
pub fn locate(poly: &[Point2], q: Point2) -> Side {
    let mut inside = false;
    for i in 0..poly.len() {
        let (a, b) = (poly[i], poly[(i + 1) % poly.len()]);
        if (a.y > q.y) == (b.y > q.y) {
            if a.y == q.y && b.y == q.y && crate::predicates::between(a, b, q) || a == q {
                return Side::Boundary;
            }
            continue;
        }
        let o = orient2d(a, b, q);
        if o == 0.0 {
            return Side::Boundary;
        }
        if (b.y > a.y) == (o > 0.0) {
            inside = !inside;
        }
    }
    if inside { Side::Inside } else { Side::Outside }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_area_and_location() {
        let p = Point2::new;
        let sq = [p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)];
        assert_eq!(signed_area(&sq), 1.0);
        assert_eq!(perimeter(&sq), 4.0);
        assert_eq!(locate(&sq, p(0.5, 0.5)), Side::Inside);
        assert_eq!(locate(&sq, p(0.5, 0.0)), Side::Boundary);
        assert_eq!(locate(&sq, p(0.5, 1.0)), Side::Boundary);
        assert_eq!(locate(&sq, p(1.0, 0.5)), Side::Boundary);
        assert_eq!(locate(&sq, p(0.0, 0.0)), Side::Boundary);
        assert_eq!(locate(&sq, p(1.0, 1.0)), Side::Boundary);
        assert_eq!(locate(&sq, p(1.5, 0.0)), Side::Outside);
        assert_eq!(locate(&sq, p(-0.5, 1.0)), Side::Outside);
    }
}
