//! Where the nodes between the vertices of a finished mesh belong: on the curves and surfaces of its model.
//!
//! ```text
//!        ●────×────●   side of an edge set: the nearest point of the edge's curve
//!        │         │   other side of a face: the nearest point of the face's surface
//!        ×    ×    ×   centre of a quad: as well
//!        │         │   × from the middle of the chord (of the element) to the nearest point
//!        ●────×────●
//! ```
//!
//! Planes, straight edges and facets have nothing to say: there the chord is as good. Cost O(n log n), and an inversion
//! per side of a curved face.

use crate::brep::{Edge, FaceShape, Model};
use crate::geometry::{Curve, Inverter, Surface};
use crate::report::ModelMesh;
use csalf_geom::VertexId;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// A point farther from the middle of its chord than this share of the chord belongs elsewhere, and the chord is taken.
/// The arc over a chord of a third of a turn rises by 0.29 of it.
const FARTHEST: f64 = 0.35;

/// Curves and surfaces of a model, to put points on.
#[derive(Debug)]
pub struct Shapes<'a> {
    model: &'a Model,
    /// Per face, if its surface is curved: prepared when the first point is to be put on it.
    inverters: Vec<OnceLock<Inverter<'a>>>,
}

impl<'a> Shapes<'a> {
    /// Those of `model`.
    pub fn new(model: &'a Model) -> Self {
        Self { model, inverters: model.faces.iter().map(|_| OnceLock::new()).collect() }
    }

    /// The point of the surface of `face` nearest to `p`, if that is nearer than `reach`; `None` of planes and facets.
    pub fn on_face(&self, face: usize, p: DVec3, reach: f64) -> Option<DVec3> {
        let surface = match &self.model.faces.get(face)?.shape {
            FaceShape::Surface(Surface::Plane(_), _) | FaceShape::Facets(_) | FaceShape::Unread => {
                return None;
            }
            FaceShape::Surface(surface, _) => surface,
        };
        let inverter = self.inverters[face].get_or_init(|| Inverter::new(surface));
        let (uv, _) = inverter.invert(p, None, 0.0);
        let q = surface.eval(uv).point;
        (q.is_finite() && q.distance(p) <= reach).then_some(q)
    }

    /// Middles of the sides of `mesh`, which is one of this model, that have a better place than the middle of the
    /// chord; each side once, in ascending order.
    pub fn middles(&self, mesh: &ModelMesh) -> Vec<([VertexId; 2], DVec3)> {
        let points = &mesh.mesh.points;
        let chord = |[a, b]: [VertexId; 2]| {
            let (a, b) = (points[a.index()], points[b.index()]);
            (a.midpoint(b), FARTHEST * a.distance(b))
        };
        // Sides of edges: known by the names of their sets, which several edges may share.
        let mut edges: BTreeMap<&str, Vec<&Edge>> = BTreeMap::new();
        for e in &self.model.edges {
            edges.entry(&e.name).or_default().push(e);
        }
        let mut on_edges: BTreeMap<[VertexId; 2], Option<DVec3>> = BTreeMap::new();
        for (name, sides) in &mesh.sets.edges {
            let Some(candidates) = edges.get(name.as_str()) else { continue };
            for &side in sides {
                let (m, reach) = chord(side);
                let best = candidates
                    .iter()
                    .filter(|e| !matches!(e.curve, Curve::Line { .. } | Curve::Polyline(_)))
                    .map(|e| {
                        let [a, b] = e.range;
                        e.curve.eval(e.curve.nearest(m, [a.min(b), a.max(b)])).point
                    })
                    .filter(|q| q.distance(m) <= reach)
                    .min_by(|p, q| p.distance_squared(m).total_cmp(&q.distance_squared(m)));
                on_edges.insert(key(side), best);
            }
        }
        // All others: those of the first of their faces.
        let mut sides: Vec<([VertexId; 2], u32)> = mesh
            .mesh
            .quads
            .iter()
            .zip(&mesh.face_of_quad)
            .flat_map(|(q, &f)| (0..4).map(move |k| (key([q[k], q[(k + 1) & 3]]), f)))
            .collect();
        sides.par_sort_unstable();
        sides.dedup_by_key(|s| s.0);
        sides
            .par_iter()
            .filter_map(|&(side, face)| {
                let place = match on_edges.get(&side) {
                    Some(&known) => known,
                    None => {
                        let (m, reach) = chord(side);
                        self.on_face(face as usize, m, reach)
                    }
                };
                place.map(|p| (side, p))
            })
            .collect()
    }

    /// Where the centre of quad `q` of `mesh` belongs for which the element itself has `p`.
    pub fn centre(&self, mesh: &ModelMesh, q: usize, p: DVec3) -> DVec3 {
        let corners = mesh.mesh.quads[q].map(|v| mesh.mesh.points[v.index()]);
        let reach = FARTHEST * corners[0].distance(corners[2]).min(corners[1].distance(corners[3]));
        self.on_face(mesh.face_of_quad[q] as usize, p, reach).unwrap_or(p)
    }
}

/// The side with its smaller vertex first.
fn key([a, b]: [VertexId; 2]) -> [VertexId; 2] {
    [a.min(b), a.max(b)]
}
