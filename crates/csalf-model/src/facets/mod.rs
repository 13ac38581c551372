//! Faceted models: triangles of a `.stl`, `.obj` or `.ply` file become faces and edges.

mod segment;
#[cfg(test)]
mod tests;
mod weld;

use crate::brep::Model;
use glam::DVec3;

/// Triangles of one face of a faceted model, with the vertices along each edge of its loops.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Patch {
    /// Vertices.
    pub points: Vec<DVec3>,
    /// Three vertices per triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// For each loop and each edge use of it, the vertices along it in the direction of the loop, both ends included.
    pub chains: Vec<Vec<Vec<u32>>>,
}

impl Patch {
    /// The patch with every vertex moved.
    pub fn mapped(&self, f: impl Fn(DVec3) -> DVec3) -> Self {
        Self {
            points: self.points.iter().map(|p| f(*p)).collect(),
            triangles: self.triangles.clone(),
            chains: self.chains.clone(),
        }
    }
}

/// How facets become faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetOptions {
    /// Points closer than this share of the diagonal are one.
    pub weld: f64,
    /// Sides at which the normal turns by more than this are edges, degrees.
    pub feature_angle: f64,
    /// Points at which an edge turns by more than this are vertices, degrees.
    pub corner_angle: f64,
}

/// Points closer than this share of the diagonal are welded: single precision files carry seven digits.
const WELD: f64 = 1e-7;

impl Default for FacetOptions {
    fn default() -> Self {
        // The angles are those of most tools.
        Self { weld: WELD, feature_angle: 40.0, corner_angle: 40.0 }
    }
}

/// A model of facets. What was dropped or turned over is said in its notes. Cost O(n log n).
pub fn model_of_triangles(points: &[DVec3], triangles: &[[u32; 3]], options: &FacetOptions) -> Model {
    let mut model = Model::default();
    let n = points.len() as u32;
    let usable = |t: &[u32; 3]| t.iter().all(|&v| v < n && points[v as usize].is_finite());
    let kept: Vec<[u32; 3]> = triangles.iter().copied().filter(usable).collect();
    if kept.len() < triangles.len() {
        model
            .notes
            .push(format!("{} triangles without finite points were left out", triangles.len() - kept.len()));
    }
    let used = kept.iter().flatten().map(|&v| points[v as usize]);
    let (lo, hi) = used.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let diagonal = if kept.is_empty() { 0.0 } else { lo.distance(hi) };
    let finite: Vec<DVec3> = points.iter().map(|p| if p.is_finite() { *p } else { DVec3::ZERO }).collect();
    let welded = weld::weld(&finite, &kept, options.weld * diagonal);
    if welded.n_dropped > 0 {
        model
            .notes
            .push(format!("{} triangles without area, or there twice, were left out", welded.n_dropped));
    }
    if welded.n_turned > 0 {
        model
            .notes
            .push(format!("{} triangles were turned over to agree with their neighbours", welded.n_turned));
    }
    segment::segment(&welded, options, &mut model);
    model
}
