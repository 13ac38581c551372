//! Untangling: makes all quads of tangled regions strictly convex, where their topology and rim allow it.
//!
//! ```text
//!   bad quads + rings, rim fixed ──▶ minimise E(eps) ──▶ eps smaller ──▶ ... ──▶ all positive: taken over
//!                                        ▲                   │        else: more rings, twice
//!                                        └───────────────────┘
//! ```
//!
//! 1. Free vertices within 3 rings of the bad quads; those that share quads make a region.
//! 2. Per region ([`solve`]), from the positions as they are: the regularised energy is finite anywhere;
//!    L-BFGS lowers it, eps follows the smallest corner Jacobian.
//! 3. A region is taken over when all its corners are positive, otherwise it keeps its old positions.
//! 4. What is still bad is tried again with 8 rings.
//!
//! Regions share no quad and are solved in parallel; the result does not depend on it.
//! Source: handbook 7.4; V. Garanzha et al., *Foldover-free maps in 50 lines of code*, ACM TOG 40 (2021).

use super::region::{Region, Scratch, components, grow};
use super::{SmoothOptions, bad_quads, energy, lbfgs};
use csalf_geom::Point2;
use csalf_mesh::{QuadMesh, QuadTopology, quality::FLAT};
use csalf_sizemap::SizeField;
use rayon::prelude::*;

/// Rings around the bad quads, per attempt. More: more room, more cost.
const RINGS: [usize; 2] = [3, 8];

/// Most reductions of eps in one attempt.
const OUTER: usize = 20;

/// A region that has not come closer by a tenth in so many reductions will not come free. Larger: some more regions do, at
/// the cost of all that do not. *Arbitrary.*
const PATIENCE: usize = 4;

/// Most L-BFGS iterations per eps (handbook 7.4: 100 to 300); half as many after each eps that has brought no progress.
const INNER: usize = 150;

/// L-BFGS ends when a step lowers the energy by less than this part of it. Smaller: work without effect, as eps
/// changes the energy next. *Arbitrary.*
const STOP: f64 = 1e-5;

/// Least square of eps, so that the energy is defined for a Jacobian of 0. (Handbook 7.4.)
const MIN_EPS_SQUARED: f64 = 1e-12;

/// What the untangler achieved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UntangleReport {
    /// Quads with a corner that is concave or flat, before.
    pub n_bad_before: usize,
    /// After. 0: the mesh is all positive.
    pub n_bad_after: usize,
    /// Regions solved, over all attempts.
    pub n_regions: usize,
    /// Most reductions of eps that a region took.
    pub outer_iterations: usize,
}

impl UntangleReport {
    /// True if no quad has a concave or flat corner any more.
    pub fn is_positive(&self) -> bool {
        self.n_bad_after == 0
    }
}

/// Makes tangled regions positive; see the file's head. Vertices on the boundary and those with `fixed` set
/// do not move; quads outside the regions keep their bytes. A positive corner never becomes non-positive.
/// Cost: one pass over the mesh, then about 0.1 us per quad of a region and L-BFGS iteration.
pub fn untangle(
    mesh: &mut QuadMesh,
    topology: &QuadTopology,
    fixed: &[bool],
    size: &dyn SizeField,
    options: &SmoothOptions,
) -> UntangleReport {
    let mut bad = bad_quads(mesh, FLAT);
    let mut report = UntangleReport { n_bad_before: bad.len(), n_bad_after: bad.len(), ..Default::default() };
    if bad.is_empty() {
        return report;
    }
    let mut scratch = Scratch::new(mesh);
    for rings in RINGS {
        let free = grow(mesh, topology, fixed, &bad, rings);
        let mut regions: Vec<Region> = components(mesh, topology, &free)
            .iter()
            .map(|free| Region::new(mesh, topology, free, &mut scratch))
            .filter(|r| r.min_scaled() <= FLAT)
            .collect();
        report.n_regions += regions.len();
        let solved: Vec<(bool, usize)> =
            regions.par_iter_mut().map(|r| solve(r, size, options.lambda)).collect();
        for (region, (positive, outer)) in regions.iter().zip(solved) {
            report.outer_iterations = report.outer_iterations.max(outer);
            if positive {
                region.write_back(mesh);
            }
        }
        bad = bad_quads(mesh, FLAT);
        report.n_bad_after = bad.len();
        if bad.is_empty() {
            break;
        }
    }
    report
}

/// Untangles one region: whether all corners are positive, and how many reductions of eps it took.
fn solve(region: &mut Region, size: &dyn SizeField, lambda: f64) -> (bool, usize) {
    region.set_sizes_to_fill(size);
    let length = region.inverse.iter().map(|i| 1.0 / i[0]).sum::<f64>() / region.inverse.len().max(1) as f64;
    let mut x: Vec<Point2> = region.points[..region.n_free].to_vec();
    let mut gradient = vec![Point2::ZERO; x.len()];
    let (_, mut min_d) = energy::regularised(region, &x, lambda, 1.0, &mut gradient);
    let mut eps = next_eps(min_d);
    let (mut best, mut since) = (min_d, 0);
    for outer in 1..=OUTER {
        // What comes no closer gets less and less.
        lbfgs::minimise(&mut x, INNER >> since, 0.1 * length, STOP, |x, g| {
            energy::regularised(region, x, lambda, eps, g).0
        });
        let before = min_d;
        min_d = energy::regularised(region, &x, lambda, eps, &mut gradient).1;
        if min_d > 0.0 {
            let old = region.points[..region.n_free].to_vec();
            region.points[..region.n_free].copy_from_slice(&x);
            if region.min_scaled() > FLAT {
                return (true, outer);
            }
            region.points[..region.n_free].copy_from_slice(&old);
        }
        since += 1;
        if min_d > 0.9 * best {
            (best, since) = (min_d, 0);
        }
        if since == PATIENCE {
            return (false, outer);
        }
        // Follow the smallest Jacobian; where it does not move, tighten all the same.
        eps = if min_d > before { next_eps(min_d).min(eps) } else { 0.5 * eps };
    }
    (false, OUTER)
}

/// The regularisation for a smallest Jacobian: a fifth of its depth below zero. (Handbook 7.4.)
fn next_eps(min_d: f64) -> f64 {
    (MIN_EPS_SQUARED + 0.04 * min_d.min(0.0).powi(2)).sqrt()
}
