//! The last rung: an all-quad mesh of **any** valid even contour, its boundary untouched.
//!
//! ```text
//!      b2 ────────── b1         b   the contour (occurrences of nodes)
//!      │ ╲   x3   ╱ │           o   one inner point per occurrence, close to it
//!      │  o2 ─t─ o1  │           t   middle of an inner edge
//!      │  │    ╱ │   │           x1  a point in the strip cell (b0, b1, o1, o0)
//!      │  t   c  t x1│          x2  middle of the spoke b1-o1 of a node of odd number
//!      │  │╱     │   │           c   middle of an inner triangle
//!      b3 o3 ─t─ o0  b0
//! ```
//!
//! 1. `corners`: constrained Delaunay triangulation of the contour nodes; the triangles inside are found by
//!    walking from the left sides of the contour segments, and each of their corners belongs to one occurrence.
//! 2. `ring`: pull the corners of occurrence i off the contour, to `o_i` in its angle, by a distance chosen per
//!    occurrence. The triangles keep their connectivity; a strip of four-sided cells remains along the contour.
//! 3. Split each triangle into three quads by its middle and the middles of its edges. Split each cell into three
//!    quads that match: the inner edge has a middle, of its two spokes only that at the odd occurrence has one. For
//!    an even number of occurrences this closes. No contour segment is split.
//! 4. Odd occurrences wider than 216° get two spokes and a wedge of three quads between them. Even
//!    ones have four quads each and need no care: even a slit tip (360°) at `b0` leaves a triangle
//!    (b1, o1, o0) with the three points b0, x2, t on its three sides.
//! 5. Every quad is checked by exact `orient2d` on the final coordinates. Where a check fails, the distances nearby
//!    are halved; as they go to zero all triangles go to those of the first step, which are exactly positive.
//!
//! Assumes: the contour is a closed walk, material on the left, weakly simple (it may touch itself at equal ids
//! only: bridges, slits, pinched nodes). Guarantees: all quads strictly convex; as the mesh is a disk whose elements
//! are all positive and whose rim is the contour, nothing overlaps.
//! Exceptions: [`FallbackError::NoRoom`] if the floating-point grid is too coarse at a place.
//!
//! Cost: O(n log n). Count without interior points: 6n - 6 quads plus 6 for each wedge.
//!
//! Source: handbook 12.2, with two changes. The offset polygon is not triangulated itself: it inherits the
//! triangulation of the contour, so that it needs no common distance and no test for crossings. Slit tips need no
//! extra ring.

mod corners;
mod odd;
mod ring;
#[cfg(test)]
mod tests;

pub use odd::{OddPatch, ear, fill_odd, without};

use crate::closure::{ClosureResult, close};
use csalf_geom::predicates::{Meeting, meeting, on_segment};
use csalf_geom::{Point2, Tolerance};
use csalf_mesh::{Appraisal, Contour, Patch, Refusal, RegionMesher, RegionTask};

/// Why a contour cannot be filled: it is not a valid even contour.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FallbackError {
    /// The number of occurrences is odd, so no all-quad mesh exists.
    #[error("the contour has an odd number of nodes: {n_nodes}")]
    Odd {
        /// How many it has.
        n_nodes: usize,
    },
    /// The number of occurrences is even where an odd one is asked for.
    #[error("the contour has an even number of nodes: {n_nodes}")]
    Even {
        /// How many it has.
        n_nodes: usize,
    },
    /// Fewer than four occurrences (three for [`fill_odd`]), or lists of different lengths.
    #[error("the contour has too few nodes: {n_nodes}")]
    TooFewNodes {
        /// How many it has.
        n_nodes: usize,
    },
    /// A coordinate is NaN, infinite or too large.
    #[error("node {at} has a coordinate that is not finite or too large")]
    NotFinite {
        /// The occurrence.
        at: usize,
    },
    /// Two nodes of different ids have the same coordinates, or one id has two places.
    #[error("nodes {a} and {b} have the same place and different ids, or the same id and different places")]
    Coincident {
        /// One occurrence.
        a: usize,
        /// The other one.
        b: usize,
    },
    /// A contour segment crosses another one, passes through a node, or is run along twice in one direction.
    #[error("segment {segment} crosses another segment, passes through a node or is doubled")]
    Crossing {
        /// The segment from this occurrence to the next.
        segment: usize,
    },
    /// The material is not on the left, or the contour crosses itself in a node.
    #[error("the contour does not bound material on its left at node {at}")]
    NotSimple {
        /// An occurrence where this shows.
        at: usize,
    },
    /// No strictly convex quads fit: neighbouring floating-point numbers are too far apart here.
    #[error("coordinates are too coarse for the gaps and angles at node {at}")]
    NoRoom {
        /// An occurrence close to the place.
        at: usize,
    },
}

/// Fills a contour with strictly convex quads; see the module's documentation.
///
/// Contours of up to eight nodes are closed by a stencil ([`crate::closure`]) if one is good enough. The tolerance
/// decides nothing: nodes closer than the merge length but distinct are meshed as they are.
///
/// # Errors
/// A [`FallbackError`] if the contour is not a valid even one.
pub fn fill(contour: &Contour, _tolerance: Tolerance) -> Result<Patch, FallbackError> {
    check(contour)?;
    // Spade compares some squared lengths with a constant: without this, the scale of a contour would matter.
    let unit = unit(&contour.points);
    let scaled = Contour {
        points: contour.points.iter().map(|&p| p * unit).collect(),
        sizes: contour.sizes.iter().map(|h| h * unit).collect(),
        ..contour.clone()
    };
    let mut patch = fill_scaled(&scaled)?;
    patch.points.iter_mut().for_each(|p| *p /= unit);
    Ok(patch)
}

/// The power of two that brings the largest coordinate to 1 to 2; multiplying by it rounds nothing.
fn unit(points: &[Point2]) -> f64 {
    const EXPONENT: i32 = 1023;
    let largest = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let exponent = (largest.to_bits() >> 52) as i32 - EXPONENT;
    2f64.powi((-exponent).min(EXPONENT))
}

/// [`fill`] of a checked contour with coordinates of about 1.
fn fill_scaled(contour: &Contour) -> Result<Patch, FallbackError> {
    if let Some(patch) = by_stencil(contour) {
        return Ok(patch);
    }
    let n = contour.len();
    // With inner points; without; and with the roles of odd and even nodes exchanged.
    let steiner = if n >= STEINER_FROM { ring::fill(contour, true, false).ok() } else { None };
    match steiner {
        Some(patch) => Ok(patch),
        None => {
            ring::fill(contour, false, false).or_else(|e| ring::fill(contour, false, true).map_err(|_| e))
        }
    }
}

/// Closes a contour of up to eight distinct nodes. Convex quads that fill its rim's turns once are a mesh of it only
/// if the contour is simple, so that is checked: the slow path finds and names the faults.
fn by_stencil(contour: &Contour) -> Option<Patch> {
    let n = contour.len();
    if n > 8 || !is_simple(&contour.points) {
        return None;
    }
    let wanted: Vec<f64> = (0..n).map(|i| contour.angle(i) / std::f64::consts::FRAC_PI_2).collect();
    let mut out = ClosureResult::default();
    close(&contour.points, &wanted, &mut out)?;
    let quads = out.quads().iter().map(|q| q.map(u32::from)).collect();
    Some(Patch { points: out.points().to_vec(), quads, ..Patch::default() })
}

/// Exact: no two segments meet but neighbours in their common node. Cost O(n²), for few nodes.
fn is_simple(p: &[Point2]) -> bool {
    let n = p.len();
    (0..n).all(|i| {
        let (a, b) = (p[i], p[(i + 1) % n]);
        let apart = |j: usize| meeting(a, b, p[j], p[(j + 1) % n]) == Meeting::Apart;
        let c = p[(i + 2) % n];
        a != b
            && !on_segment(a, b, c)
            && !on_segment(b, c, a)
            && (i + 2..n).all(|j| (j + 1) % n == i || apart(j))
    })
}

/// Contours with at least this many nodes are tried with inner points first. Smaller ones have no room for them.
const STEINER_FROM: usize = 8;

/// Checks the lists, not the geometry.
fn check(contour: &Contour) -> Result<(), FallbackError> {
    check_points(contour, 4)?;
    let n_nodes = contour.len();
    if n_nodes % 2 == 1 { Err(FallbackError::Odd { n_nodes }) } else { Ok(()) }
}

/// The checks that odd and even contours have in common.
fn check_points(contour: &Contour, least: usize) -> Result<(), FallbackError> {
    let n = contour.points.len();
    if n < least || contour.ids.len() != n {
        return Err(FallbackError::TooFewNodes { n_nodes: n });
    }
    match contour.points.iter().position(|p| !p.is_finite() || p.abs().max_element() > LARGEST) {
        Some(at) => Err(FallbackError::NotFinite { at }),
        None => Ok(()),
    }
}

/// Largest coordinate: products of four stay finite in the predicates.
const LARGEST: f64 = 1e60;

/// The fallback as a member of the triad: takes every valid even contour, at low quality.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fallback;

impl RegionMesher for Fallback {
    fn name(&self) -> &'static str {
        "fallback"
    }

    fn appraise(&self, task: &RegionTask<'_>) -> Option<Appraisal> {
        check(task.contour).ok()?;
        let n_quads = 6 * task.contour.len() as u32 - 6;
        Some(Appraisal {
            min_sj: 0.0,
            mean_sj: 0.4,
            n_irregular: n_quads / 2,
            n_quads,
            size_error: 2.0,
            worst_size_error: 10.0,
        })
    }

    fn mesh(&self, task: &RegionTask<'_>) -> Result<Patch, Refusal> {
        fill(task.contour, task.tolerance).map_err(|_| Refusal::NotApplicable)
    }
}
