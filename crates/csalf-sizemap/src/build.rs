//! From a [`SizeSpec`] and the loops of a domain to a size field.
//!
//! | spec | field |
//! |---|---|
//! | `Boundary` | [`Background`]: constrained Delaunay triangulation of the loop nodes alone, node size = mean of the two adjacent segments (handbook 8.1; the paper's background mesh) |
//! | `Uniform` | [`Uniform`] |
//! | `Sources` | [`Sources`], closed form |
//! | `Background` | [`Background`] on the caller's triangles |
//!
//! On top of any of them: hard points with a size are spots that grow at rate g, h(p) <= h_i + g |p - x_i|; one
//! that is larger than the field has no effect. g is [`Extras::gradation`], or [`DEFAULT_GRADATION`] for the hard
//! points alone if there is none.

use crate::error::check_size;
use crate::gradation::graded;
use crate::{Background, Hint, SizeError, SizeField, SizeSpec, Sources, Uniform};
use csalf_geom::{Point2, Tolerance, polygon::bounds};
use std::sync::Arc;

/// Growth of the wanted length per length, where hard points need one and none is given: neighbouring edges differ
/// by about 20 % (handbook 8.2). 0.1 is smooth, 0.3 fast.
pub const DEFAULT_GRADATION: f64 = 0.2;

/// What may be asked besides the [`SizeSpec`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Extras<'a> {
    /// Hard points that carry a size.
    pub hard_points: &'a [(Point2, f64)],
    /// Largest |grad h|; `None`: the field as specified.
    pub gradation: Option<f64>,
}

/// Builds the size field of a domain. `loops`: closed lists of nodes in any order and orientation. Cost O(n log n)
/// in the nodes for kinds `Boundary` and `Background`, constant for the others. `tol` is not needed yet: equal points
/// are merged exactly, coincident neighbours are an error.
///
/// # Errors
/// [`SizeError`], with the place of the fault.
pub fn build(
    spec: &SizeSpec,
    loops: &[Vec<Point2>],
    extras: &Extras<'_>,
    tol: Tolerance,
) -> Result<Arc<dyn SizeField>, SizeError> {
    let _ = tol;
    if let Some(g) = extras.gradation
        && !(g > 0.0 && g.is_finite())
    {
        return Err(SizeError::BadGradation(g));
    }
    let base: Arc<dyn SizeField> = match spec {
        SizeSpec::Boundary => limited(of_boundary(loops)?, loops, &[], extras.gradation)?,
        SizeSpec::Uniform { h } => {
            check_size("uniform size", 0, *h)?;
            Arc::new(Uniform(*h))
        }
        SizeSpec::Sources { far, sources } => Arc::new(Sources::new(*far, sources, extras.gradation)?),
        SizeSpec::Background { points, triangles, values } => {
            let base = Background::from_triangles(points, triangles, values)?;
            limited(base, loops, points, extras.gradation)?
        }
    };
    if extras.hard_points.is_empty() {
        return Ok(base);
    }
    let g = extras.gradation.unwrap_or(DEFAULT_GRADATION);
    Ok(Arc::new(Sources::hard_points(base, extras.hard_points, g)?))
}

/// `base` itself, or its gradation limit on a mesh of the loops and of the points that carry its features.
fn limited(
    base: Background,
    loops: &[Vec<Point2>],
    points: &[Point2],
    gradation: Option<f64>,
) -> Result<Arc<dyn SizeField>, SizeError> {
    let Some(g) = gradation else { return Ok(Arc::new(base)) };
    let mut all: Vec<Point2> = loops.iter().flatten().copied().collect();
    if let Some(index) = all.iter().position(|p| !p.is_finite()) {
        return Err(SizeError::BadPoint { what: "loop node", index });
    }
    let Some((low, high)) = bounds(all.iter().copied()) else { return Err(SizeError::NoArea) };
    all.extend(points.iter().filter(|p| p.cmpge(low).all() && p.cmple(high).all()));
    let mut hint = Hint::default();
    let values: Vec<f64> = all.iter().map(|&p| base.h(p, &mut hint)).collect();
    Ok(Arc::new(graded(&base, &all, &values, &loop_indices(loops), g)?))
}

/// The mean of the two adjacent segments, per node of a closed loop.
pub fn node_sizes(nodes: &[Point2]) -> Vec<f64> {
    let n = nodes.len();
    let length = |i: usize| nodes[i].distance(nodes[(i + 1) % n]);
    (0..n).map(|i| 0.5 * (length((i + n - 1) % n) + length(i))).collect()
}

/// The field of kind `Boundary`: linear on the constrained Delaunay triangulation of the loop nodes.
///
/// # Errors
/// [`SizeError`]: a node with coincident neighbours, a bad coordinate, loops without area.
pub fn of_boundary(loops: &[Vec<Point2>]) -> Result<Background, SizeError> {
    let points: Vec<Point2> = loops.iter().flatten().copied().collect();
    if let Some(index) = points.iter().position(|p| !p.is_finite()) {
        return Err(SizeError::BadPoint { what: "loop node", index });
    }
    let values: Vec<f64> = loops.iter().flat_map(|l| node_sizes(l)).collect();
    for (i, &h) in values.iter().enumerate() {
        check_size("loop node", i, h)?;
    }
    Background::from_points(&points, &values, &loop_indices(loops))
}

/// Indices of the nodes of each loop in the list of all of them.
pub(crate) fn loop_indices(loops: &[Vec<Point2>]) -> Vec<Vec<u32>> {
    let mut start = 0u32;
    loops
        .iter()
        .map(|l| {
            let ids = (start..start + l.len() as u32).collect();
            start += l.len() as u32;
            ids
        })
        .collect()
}

#[cfg(test)]
mod tests;
