//! Moving inner vertices: sweeps, optimisation with a barrier, untangling.
//!
//! ```text
//!   finish:  any non-positive corner? ─ yes ─▶ Laplace sweeps there ─▶ untangle
//!                     │ no                                               │
//!                     ▼                                                  ▼
//!            smooth: quads below the threshold + rings ──▶ Laplace ──▶ Newton sweeps with barrier
//! ```
//!
//! All work is local: regular, well-shaped parts of the mesh cost one look per quad. Boundary vertices and
//! those marked fixed keep their bytes. The result does not depend on the number of threads. Source: handbook
//! 7.

mod energy;
mod lanes;
mod laplace;
mod lbfgs;
mod lift;
mod optimise;
mod region;
mod sweep;
#[cfg(test)]
mod tests;
mod untangle;

use csalf_geom::{Point2, QuadId, VertexId};
use csalf_mesh::{QuadMesh, QuadTopology, quality::FLAT};
use csalf_sizemap::SizeField;
use energy::Weights;
use rayon::prelude::*;
use region::{PARALLEL_FROM, Region, Scratch, grow};
use sweep::Sweeps;

pub use lift::lift;
pub(crate) use lift::{DOUBLINGS, TRIAL_ITERATIONS, least_sine, lift_by, worth};
pub use region::Boxes;
pub(crate) use untangle::{Effort, untangle_with};
pub use untangle::{UntangleReport, untangle};

/// How much is smoothed and to what end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothOptions {
    /// Quads with a scaled Jacobian below this are worked on, -1 to 1. Larger: better meshes, more work;
    /// above 1 the whole mesh is smoothed.
    pub threshold: f64,
    /// Rings of quads around them that take part.
    pub rings: usize,
    /// Most Laplace sweeps before the optimiser.
    pub laplace_sweeps: usize,
    /// Most optimiser sweeps.
    pub sweeps: usize,
    /// Weight of size against shape in the energy, 0 to 1. (Handbook 7.3: 0.1 to 0.5.)
    pub lambda: f64,
    /// Power of the energy of a corner, 2 to 8: the larger, the more the worst corners count against the mean.
    pub power: i32,
    /// A vertex that moves less than this share of the wanted length is settled.
    pub tolerance: f64,
    /// A corner may lose scaled Jacobian down to this (but never below the smallest of the region before),
    /// where the energy falls. Larger: better worst quads (0.6 to 0.8: 0.01 more in the smallest, 0.01 in the 1 %
    /// quantile), lengths that follow the field a little less.
    pub floor: f64,
}

impl SmoothOptions {
    /// What [`Self::default`] returns.
    pub const DEFAULT: Self = Self {
        threshold: 0.85,
        rings: 2,
        laplace_sweeps: 2,
        sweeps: 10,
        lambda: 0.2,
        power: 4,
        tolerance: 4e-3,
        floor: 0.8,
    };
}

impl Default for SmoothOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What [`smooth`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SmoothReport {
    /// Quads below the threshold, before.
    pub n_seeds: usize,
    /// Vertices that could move.
    pub n_free: usize,
    /// Optimiser sweeps made.
    pub sweeps: usize,
    /// Smallest scaled Jacobian of the quads worked on, before and after; 1 if there were none.
    pub min_sj: (f64, f64),
}

/// What [`finish`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FinishReport {
    /// The untangler; all zero if nothing was tangled.
    pub untangle: UntangleReport,
    /// The smoother.
    pub smooth: SmoothReport,
}

/// Smooths the parts of the mesh that need it. `fixed` has one entry per vertex (missing ones count as
/// false); boundary vertices are fixed anyhow. `topology` must be that of `mesh`.
///
/// Positive corners stay positive, and the smallest scaled Jacobian does not fall if it was positive.
/// Vertices with a non-positive corner around them are left alone by the optimiser: use [`finish`] or
/// [`untangle`].
///
/// Cost: about 10 ns per quad of the mesh, then per vertex worked on 0.2 us for the region and about 0.2 us
/// (Laplace) or 0.4 us (optimiser) per sweep until it is settled; one size query per quad worked on.
pub fn smooth(
    mesh: &mut QuadMesh,
    topology: &QuadTopology,
    fixed: &[bool],
    size: &dyn SizeField,
    options: &SmoothOptions,
) -> SmoothReport {
    smooth_boxed(mesh, topology, fixed, size, &|_| None, options)
}

/// [`smooth`], with quads that have target lengths of their own along and across (layers): `boxes` says
/// which.
pub fn smooth_boxed(
    mesh: &mut QuadMesh,
    topology: &QuadTopology,
    fixed: &[bool],
    size: &dyn SizeField,
    boxes: Boxes<'_>,
    options: &SmoothOptions,
) -> SmoothReport {
    let seeds = bad_quads(mesh, options.threshold);
    smooth_from(&seeds, mesh, topology, fixed, size, boxes, options)
}

/// [`smooth_boxed`] of the quads below the threshold, which are known.
fn smooth_from(
    seeds: &[u32],
    mesh: &mut QuadMesh,
    topology: &QuadTopology,
    fixed: &[bool],
    size: &dyn SizeField,
    boxes: Boxes<'_>,
    options: &SmoothOptions,
) -> SmoothReport {
    let mut report = SmoothReport { n_seeds: seeds.len(), min_sj: (1.0, 1.0), ..Default::default() };
    if seeds.is_empty() {
        return report;
    }
    let free = grow(mesh, topology, fixed, seeds, options.rings);
    report.n_free = free.len();
    if free.is_empty() {
        return report;
    }
    let mut region = Region::new(mesh, topology, &free, &mut Scratch::new(mesh));
    region.set_sizes(size);
    region.set_boxes(boxes);
    let before = region.min_scaled();
    // Squared, as the steps compare it. A positive minimum must not fall; below that there is nothing to
    // lose.
    let floor = options.floor.max(before).powi(2);
    let weights = Weights { lambda: options.lambda, power: options.power.clamp(1, 16) };
    let mut sweeps = Sweeps::new(&region, options.tolerance);
    for _ in 0..options.laplace_sweeps {
        if sweeps.run(&mut region, |r, v| laplace::step(r, v, floor)) == 0 {
            break;
        }
    }
    sweeps.unsettle();
    for _ in 0..options.sweeps {
        report.sweeps += 1;
        if sweeps.run(&mut region, |r, v| optimise::step(r, v, weights, floor, 0.25 * options.tolerance)) == 0
        {
            break;
        }
    }
    report.min_sj = (before, region.min_scaled());
    region.write_back(mesh);
    report
}

/// Untangles what is tangled, then smooths: the last step of every mesh. Arguments and guarantees as of
/// [`smooth`] and [`untangle`].
pub fn finish(
    mesh: &mut QuadMesh,
    topology: &QuadTopology,
    fixed: &[bool],
    size: &dyn SizeField,
    options: &SmoothOptions,
) -> FinishReport {
    // One look at every quad for both thresholds.
    let seeds = bad_quads(mesh, options.threshold.max(FLAT));
    let mut bad: Vec<u32> = seeds.iter().copied().filter(|&q| is_bad(mesh, q, FLAT)).collect();
    let mut report = FinishReport::default();
    if bad.is_empty() && options.threshold >= FLAT {
        report.smooth = smooth_from(&seeds, mesh, topology, fixed, size, &|_| None, options);
        return report;
    }
    if !bad.is_empty() {
        // Often a few sweeps suffice; they never make a positive corner worse than the floor.
        let n_bad_before = bad.len();
        let free = grow(mesh, topology, fixed, &bad, options.rings);
        if !free.is_empty() {
            let mut region = Region::new(mesh, topology, &free, &mut Scratch::new(mesh));
            region.set_sizes_to_fill(size);
            let mut sweeps = Sweeps::new(&region, options.tolerance);
            for _ in 0..3 {
                sweeps.run(&mut region, |r, v| laplace::step(r, v, options.floor.powi(2)));
            }
            let before = mesh.points.clone();
            region.write_back(mesh);
            let now = bad_quads(mesh, FLAT);
            if now.iter().all(|q| bad.binary_search(q).is_ok()) {
                bad = now;
            } else {
                // A quad that was sound is not any more.
                mesh.points = before;
            }
        }
        if !bad.is_empty() {
            report.untangle = untangle(mesh, topology, fixed, size, options);
        }
        report.untangle.n_bad_before = n_bad_before;
    }
    report.smooth = smooth(mesh, topology, fixed, size, options);
    report
}

/// True if quad `q` has a corner of a scaled Jacobian of at most `threshold`.
fn is_bad(mesh: &QuadMesh, q: u32, threshold: f64) -> bool {
    has_corner_below(&mesh.corners(QuadId(q)), threshold)
}

#[inline]
fn has_corner_below(p: &[Point2; 4], threshold: f64) -> bool {
    let e = [p[1] - p[0], p[2] - p[1], p[3] - p[2], p[0] - p[3]];
    let l = e.map(|e| e.length_squared());
    let signed_square = threshold * threshold.abs();
    (0..4).any(|k| {
        let j = e[(k + 3) & 3].perp_dot(e[k]);
        j * j.abs() <= signed_square * (l[(k + 3) & 3] * l[k])
    })
}

/// The quads with a corner of a scaled Jacobian of at most `threshold`, ascending. Cost about 10 ns per quad.
fn bad_quads(mesh: &QuadMesh, threshold: f64) -> Vec<u32> {
    quads_where(mesh, |vs| has_corner_below(&vs.map(|v| mesh.points[v.index()]), threshold))
}

/// The quads that satisfy `wanted`, ascending.
fn quads_where(mesh: &QuadMesh, wanted: impl Fn(&[VertexId; 4]) -> bool + Sync) -> Vec<u32> {
    let all = |from: usize, quads: &[[VertexId; 4]]| -> Vec<u32> {
        quads.iter().enumerate().filter(|(_, q)| wanted(q)).map(|(i, _)| (from + i) as u32).collect()
    };
    if mesh.n_quads() < 4 * PARALLEL_FROM {
        return all(0, &mesh.quads);
    }
    let parts: Vec<Vec<u32>> =
        mesh.quads.par_chunks(PARALLEL_FROM).enumerate().map(|(i, c)| all(i * PARALLEL_FROM, c)).collect();
    parts.concat()
}
