//! A quad mesh as two flat arrays.

use csalf_geom::{Point2, QuadId, VertexId};

/// A mesh of quads (and, only where the caller allowed them, triangles).
///
/// The nodes of the input come first, in input order: loops, then scars, then hard points (each distinct node
/// once). Elements are counter-clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadMesh {
    /// Coordinates, one per vertex.
    pub points: Vec<Point2>,
    /// Four vertices per quad, counter-clockwise.
    pub quads: Vec<[VertexId; 4]>,
    /// Three vertices per triangle, counter-clockwise. Empty in an all-quad mesh.
    pub triangles: Vec<[VertexId; 3]>,
}

impl QuadMesh {
    /// Number of vertices.
    pub fn n_vertices(&self) -> usize {
        self.points.len()
    }
    /// Number of quads.
    pub fn n_quads(&self) -> usize {
        self.quads.len()
    }
    /// The four points of a quad.
    #[inline]
    pub fn corners(&self, q: QuadId) -> [Point2; 4] {
        self.quads[q.index()].map(|v| self.points[v.index()])
    }
}

/// Named groups of mesh entities: loops, scars, hard points, rings. Written as NSET/ELSET, physical groups and
/// the like by every format that has them. Lists are in the order of the curve, or ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedSets {
    /// Vertex sets, by name.
    pub nodes: Vec<(String, Vec<VertexId>)>,
    /// Edge sets (boundary loops, scars), each edge as its two vertices with the material on the left.
    pub edges: Vec<(String, Vec<[VertexId; 2]>)>,
    /// Quad sets (layers, faces of a model), by name.
    pub quads: Vec<(String, Vec<QuadId>)>,
}
