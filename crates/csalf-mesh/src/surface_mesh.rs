//! A quad mesh in space.

use crate::QuadMesh;
use csalf_geom::{QuadId, VertexId};
use glam::DVec3;

/// A mesh of quads in space: of a face, or of a whole model, conforming.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    /// Coordinates, one per vertex, in model units.
    pub points: Vec<DVec3>,
    /// Four vertices per quad, counter-clockwise seen from outside.
    pub quads: Vec<[VertexId; 4]>,
}

impl SurfaceMesh {
    /// The four points of a quad.
    pub fn corners(&self, q: QuadId) -> [DVec3; 4] {
        self.quads[q.index()].map(|v| self.points[v.index()])
    }

    /// The mesh seen from above, and the heights of its vertices: what writers of files take.
    pub fn split(&self) -> (QuadMesh, Vec<f64>) {
        let points = self.points.iter().map(|p| p.truncate()).collect();
        let mesh = QuadMesh { points, quads: self.quads.clone(), triangles: Vec::new() };
        (mesh, self.points.iter().map(|p| p.z).collect())
    }
}
