//! Loops that the tests of several modules mesh.

use csalf_geom::Point2;

/// A square from the origin, counter-clockwise from there; `n` segments on each of its sides.
pub(crate) fn square(side: f64, n: [usize; 4]) -> Vec<Point2> {
    let corners = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)].map(Point2::from);
    let nodes = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        (0..n[k]).map(move |i| a.lerp(b, i as f64 / n[k] as f64))
    };
    (0..4).flat_map(nodes).collect()
}
