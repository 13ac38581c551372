//! The boundary representation: vertices, edges, faces, bodies.
//!
//! ```text
//!   Body "bracket"
//!    └─ Face "F3"  surface + sense           the loop has the material on its left, seen against the normal
//!        └─ Loop   EdgeUse E7+, E8+, E2-     + along the edge, - against it
//!            └─ Edge  curve + range, from vertex to vertex, tolerance
//!                └─ Vertex  point
//! ```

mod check;
mod features;
mod sew;
#[cfg(test)]
mod tests;
mod turn;

pub use check::{CheckReport, check_and_snap};
pub(crate) use features::outer_loop;
pub use features::{HoleShape, LoopFeature, loop_features};
pub use sew::{Sewn, sew, sew_closed};
pub use turn::turn_alike;

use crate::geometry::{Curve, Motion, Surface};
use glam::DVec3;

/// Index of a vertex of a model.
pub type VertexIndex = usize;
/// Index of an edge of a model.
pub type EdgeIndex = usize;
/// Index of a face of a model.
pub type FaceIndex = usize;

/// Where edges end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Where.
    pub point: DVec3,
}

/// A piece of a curve between two vertices (one, if it is closed).
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Name in the file, or one of ours.
    pub name: String,
    /// Where it runs.
    pub curve: Curve,
    /// Parameters at start and end; descending if the edge runs against its curve.
    pub range: [f64; 2],
    /// Start and end.
    pub ends: [VertexIndex; 2],
    /// How far the curve's ends may be from the vertices and the curve from its faces, length.
    pub tolerance: f64,
}

impl Edge {
    /// The parameter at share `s` (0 to 1) of the range.
    pub fn parameter(&self, s: f64) -> f64 {
        self.range[0] + (self.range[1] - self.range[0]) * s
    }

    /// The point at share `s` (0 to 1) of the range.
    pub fn at(&self, s: f64) -> crate::geometry::CurvePoint {
        self.curve.eval(self.parameter(s))
    }

    /// True if it starts and ends at one vertex.
    pub const fn is_closed(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// Length, by the chords of 64 pieces (each piece between breaks of a polyline is exact).
    pub fn length(&self) -> f64 {
        const PIECES: u32 = 64;
        match &self.curve {
            Curve::Line { .. } | Curve::Polyline(_) => (self.range[1] - self.range[0]).abs(),
            Curve::Ellipse { a, b, .. } if a == b => (self.range[1] - self.range[0]).abs() * a,
            _ => {
                let points = (0..=PIECES).map(|k| self.at(f64::from(k) / f64::from(PIECES)).point);
                let mut last = None;
                points.fold(0.0, |sum, p| sum + last.replace(p).map_or(0.0, |q: DVec3| q.distance(p)))
            }
        }
    }
}

/// An edge in a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EdgeUse {
    /// Which edge.
    pub edge: EdgeIndex,
    /// True if the loop runs along the edge, false if against it.
    pub forward: bool,
}

/// A closed chain of edges.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Loop {
    /// The edges in order.
    pub uses: Vec<EdgeUse>,
    /// The vertex of a loop without edges: the apex of a cone.
    pub vertex: Option<VertexIndex>,
}

/// What a face lies on.
#[derive(Clone, Debug, PartialEq)]
pub enum FaceShape {
    /// A surface in closed form or a NURBS; true if the face's normal is the surface's.
    Surface(Surface, bool),
    /// A patch of triangles of the model's facets.
    Facets(crate::facets::Patch),
    /// A kind of surface that the file's reader does not know: the face has its place and its edges, but no mesh.
    Unread,
}

impl FaceShape {
    /// In a word: plane, cylinder, ..., facets, unread.
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Surface(s, _) => s.kind(),
            Self::Facets(_) => "facets",
            Self::Unread => "unread",
        }
    }
}

/// A face: a part of a surface within loops.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Name in the file, or one of ours.
    pub name: String,
    /// What it lies on.
    pub shape: FaceShape,
    /// Loops with the material on their left, seen against the face's normal; the outer one first, where it is known.
    pub loops: Vec<Loop>,
    /// Colour, if the file has one: red, green, blue in 0..=1.
    pub color: Option<[f64; 3]>,
}

/// A solid or a sheet.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Body {
    /// Name in the file, or one of ours.
    pub name: String,
    /// Its faces.
    pub faces: Vec<FaceIndex>,
    /// True if its faces are to enclose a volume.
    pub solid: bool,
}

/// A whole model, instances of parts placed.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Model {
    /// Name.
    pub name: String,
    /// Name of the unit of length, e.g. `millimetre`; empty if unknown.
    pub unit: String,
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Edges.
    pub edges: Vec<Edge>,
    /// Faces.
    pub faces: Vec<Face>,
    /// Bodies.
    pub bodies: Vec<Body>,
    /// What was left out or repaired on import, in words.
    pub notes: Vec<String>,
}

impl Model {
    /// Adds a vertex.
    pub fn add_vertex(&mut self, point: DVec3) -> VertexIndex {
        self.vertices.push(Vertex { point });
        self.vertices.len() - 1
    }

    /// Adds an edge, named `edgeK` if it has no name.
    pub fn add_edge(&mut self, mut edge: Edge) -> EdgeIndex {
        if edge.name.is_empty() {
            edge.name = format!("edge{}", self.edges.len() + 1);
        }
        self.edges.push(edge);
        self.edges.len() - 1
    }

    /// Adds the straight edge between two vertices; `None` if they are one point.
    pub fn add_line(&mut self, a: VertexIndex, b: VertexIndex) -> Option<EdgeIndex> {
        let (curve, range) = Curve::segment(self.vertices[a].point, self.vertices[b].point)?;
        Some(self.add_edge(Edge { name: String::new(), curve, range, ends: [a, b], tolerance: 0.0 }))
    }

    /// Adds a face, named `faceK` if it has no name.
    pub fn add_face(&mut self, mut face: Face) -> FaceIndex {
        if face.name.is_empty() {
            face.name = format!("face{}", self.faces.len() + 1);
        }
        self.faces.push(face);
        self.faces.len() - 1
    }

    /// Adds all of `part`, moved, with the bodies' names prefixed.
    pub fn add_instance(&mut self, part: &Self, motion: &Motion, prefix: &str) {
        let (nv, ne, nf) = (self.vertices.len(), self.edges.len(), self.faces.len());
        self.vertices.extend(part.vertices.iter().map(|v| Vertex { point: motion.point(v.point) }));
        self.edges.extend(part.edges.iter().map(|e| Edge {
            name: format!("{prefix}{}", e.name),
            curve: e.curve.moved(motion),
            range: e.range,
            ends: e.ends.map(|v| v + nv),
            tolerance: e.tolerance,
        }));
        let use_of = |u: &EdgeUse| EdgeUse { edge: u.edge + ne, forward: u.forward };
        self.faces.extend(part.faces.iter().map(|f| {
            Face {
                name: format!("{prefix}{}", f.name),
                shape: match &f.shape {
                    FaceShape::Surface(s, sense) => FaceShape::Surface(s.moved(motion), *sense),
                    FaceShape::Facets(p) => FaceShape::Facets(p.mapped(|q| motion.point(q))),
                    FaceShape::Unread => FaceShape::Unread,
                },
                loops: f
                    .loops
                    .iter()
                    .map(|l| Loop {
                        uses: l.uses.iter().map(use_of).collect(),
                        vertex: l.vertex.map(|v| v + nv),
                    })
                    .collect(),
                color: f.color,
            }
        }));
        self.bodies.extend(part.bodies.iter().map(|b| Body {
            name: format!("{prefix}{}", b.name),
            faces: b.faces.iter().map(|f| f + nf).collect(),
            solid: b.solid,
        }));
        self.notes.extend(part.notes.iter().cloned());
    }

    /// For each edge, its uses: face, loop and place in it; in the order of the faces.
    pub fn edge_uses(&self) -> Vec<Vec<(FaceIndex, EdgeUse)>> {
        let mut uses = vec![Vec::new(); self.edges.len()];
        for (f, face) in self.faces.iter().enumerate() {
            for u in face.loops.iter().flat_map(|l| &l.uses) {
                if let Some(list) = uses.get_mut(u.edge) {
                    list.push((f, *u));
                }
            }
        }
        uses
    }

    /// The edges that bound one face only, and that once. A model without any is closed.
    pub fn free_edges(&self) -> impl Iterator<Item = EdgeIndex> {
        let uses = self.edge_uses();
        (0..uses.len()).filter(move |&i| uses[i].len() == 1)
    }

    /// Corners of a box around all vertices and samples of all edges and of surfaces without edges; `None` of an
    /// empty model.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        const SAMPLES: u32 = 8;
        let on_edges = self
            .edges
            .iter()
            .flat_map(|e| (0..=SAMPLES).map(move |k| e.at(f64::from(k) / f64::from(SAMPLES)).point));
        let vertices = self.vertices.iter().map(|v| v.point);
        let whole = self.faces.iter().filter(|f| f.loops.iter().all(|l| l.uses.is_empty())).flat_map(|f| {
            let (centre, reach) = match &f.shape {
                FaceShape::Surface(Surface::Sphere { frame, radius }, _) => (frame.origin, *radius),
                FaceShape::Surface(Surface::Torus { frame, major, minor }, _) => {
                    (frame.origin, major + minor)
                }
                _ => return Vec::new(),
            };
            vec![centre - DVec3::splat(reach), centre + DVec3::splat(reach)]
        });
        let facets = self.faces.iter().flat_map(|f| match &f.shape {
            FaceShape::Facets(p) => p.points.as_slice(),
            FaceShape::Surface(..) | FaceShape::Unread => &[],
        });
        vertices
            .chain(on_edges)
            .chain(whole)
            .chain(facets.copied())
            .filter(|p| p.is_finite())
            .fold(None, |b, p| Some(b.map_or((p, p), |(lo, hi): (DVec3, DVec3)| (lo.min(p), hi.max(p)))))
    }

    /// Diagonal of the box around the model; zero of an empty one.
    pub fn diagonal(&self) -> f64 {
        self.bounds().map_or(0.0, |(lo, hi)| lo.distance(hi))
    }
}
