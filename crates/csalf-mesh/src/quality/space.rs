//! Elements in space, laid into their mean planes, where the metrics of the plane can be taken.
//!
//! ```text
//!      n = (p2 - p0) × (p3 - p1): of the mean plane        warpage: how far the corners are from it
//!   p3 ●─────● p2    ● above, ○ below by the same height     in mean side lengths; 0 of a plane quad
//!      │     │
//!   p0 ○─────● p1
//! ```

use super::Card;
use crate::QuadMesh;
use csalf_geom::{Point2, VertexId};
use glam::DVec3;

/// Metric card.
pub const CARD: Card = Card {
    name: "warpage",
    dimension: "1",
    acceptable: (0.0, 0.05),
    normal: (0.0, f64::MAX),
    full: (0.0, f64::MAX),
    unit_square: 0.0,
    source: "own; Nastran's Q4_WARP has the mean diagonal in place of the mean side, 1.4 times as long in a square",
};

/// Distance of the corners from the mean plane, over the mean side length: 0 of a plane quad.
pub fn warpage(p: [DVec3; 4]) -> f64 {
    let n = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
    let side = 0.25 * (0..4).map(|k| p[k].distance(p[(k + 1) & 3])).sum::<f64>();
    // The corners are alternately above and below by the same height.
    let height = 0.25 * (p[0] - p[1] + p[2] - p[3]).dot(n).abs();
    if side > 0.0 { height / side } else { 0.0 }
}

/// Scaled Jacobian: the least over the corners, against the quad's mean normal. (Verdict's, in space.)
pub fn scaled_jacobian(p: [DVec3; 4]) -> f64 {
    let n = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
    let corner = |k: usize| {
        let (a, b) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
        a.cross(b).dot(n) / (a.length() * b.length())
    };
    (0..4).map(corner).fold(1.0, f64::min)
}

/// The place of a vertex; without heights in the plane z = 0.
pub(crate) fn place(mesh: &QuadMesh, heights: &[f64], v: VertexId) -> DVec3 {
    mesh.points[v.index()].extend(heights.get(v.index()).copied().unwrap_or(0.0))
}

/// A mesh seen from above, with the heights of its vertices, as elements that each lie in their own mean plane, with
/// corners of their own: element k has those from 4 k on (triangles after the quads, 3 each). Cost O(n).
pub fn laid_flat(mesh: &QuadMesh, heights: &[f64]) -> QuadMesh {
    let mut flat = QuadMesh { points: Vec::with_capacity(4 * mesh.quads.len()), ..QuadMesh::default() };
    for q in &mesh.quads {
        let p = q.map(|v| place(mesh, heights, v));
        let first = flat.points.len();
        flat.points.extend(laid(&p, (p[2] - p[0]).cross(p[3] - p[1])));
        flat.quads.push(std::array::from_fn(|k| VertexId::new(first + k)));
    }
    for t in &mesh.triangles {
        let p = t.map(|v| place(mesh, heights, v));
        let first = flat.points.len();
        flat.points.extend(laid(&p, (p[1] - p[0]).cross(p[2] - p[0])));
        flat.triangles.push(std::array::from_fn(|k| VertexId::new(first + k)));
    }
    flat
}

/// Points in the plane across `normal`, the first in its origin, the way from it to the second along x.
pub fn laid<const N: usize>(p: &[DVec3; N], normal: DVec3) -> [Point2; N] {
    let normal = normal.normalize_or_zero();
    let along = (p[1] - p[0]).reject_from_normalized(normal).normalize_or_zero();
    let across = normal.cross(along);
    p.map(|c| Point2::new((c - p[0]).dot(along), (c - p[0]).dot(across)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warped_square_by_hand() {
        let h = 0.1;
        let p = [[0., 0., h], [1., 0., -h], [1., 1., h], [0., 1., -h]].map(DVec3::from_array);
        let side = (1.0f64 + 4.0 * h * h).sqrt();
        assert!((warpage(p) - h / side).abs() < 1e-15);
        // (e1 × e2) · z = 1 at every corner.
        assert!((scaled_jacobian(p) - 1.0 / (side * side)).abs() < 1e-15);
        let mesh = QuadMesh {
            points: p.map(DVec3::truncate).to_vec(),
            quads: vec![[0, 1, 2, 3].map(VertexId)],
            ..QuadMesh::default()
        };
        let flat = laid_flat(&mesh, &[h, -h, h, -h]);
        for (a, b) in flat.points.iter().zip(&mesh.points) {
            assert!(a.distance(*b) < 1e-15, "seen along its normal it is the unit square");
        }
    }

    #[test]
    fn a_turned_triangle_keeps_its_sides() {
        let p = [[0., 0., 0.], [3., 0., 4.], [0., 2., 0.]].map(DVec3::from_array);
        let mesh = QuadMesh {
            points: p.map(DVec3::truncate).to_vec(),
            triangles: vec![[0, 1, 2].map(VertexId)],
            ..QuadMesh::default()
        };
        let flat = laid_flat(&mesh, &[0.0, 4.0, 0.0]).points;
        assert!(flat[1].distance(Point2::new(5.0, 0.0)) < 1e-12);
        assert!(flat[2].distance(Point2::new(0.0, 2.0)) < 1e-12);
    }
}
