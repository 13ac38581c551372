//! Untangling: makes all quads of tangled regions strictly convex, where their topology and rim allow it.
//!
//! ```text
//!   bad quads + rings, rim fixed ──▶ minimise E(eps) ──▶ eps smaller ──▶ ... ──▶ all positive: taken over
//!                                        ▲                   │        else: more rings, twice
//!                                        └───────────────────┘
//! ```
//!
//! 1. Free vertices within 3 rings ([`Effort::FULL`]) of the bad quads; those that share quads make a region.
//! 2. Per region ([`solve`]), from the positions as they are: the regularised energy is finite anywhere;
//!    L-BFGS lowers it, eps follows the smallest corner Jacobian.
//! 3. A region is taken over when fewer of its quads are bad and none that was not before; otherwise it keeps its old
//!    positions.
//! 4. What is still bad is tried again with 8 rings. Regions that are too large for the budget are left to mending.
//!
//! Regions share no quad and are solved in parallel; the result does not depend on it.
//! Source: handbook 7.4; V. Garanzha et al., *Foldover-free maps in 50 lines of code*, ACM TOG 40 (2021).

use super::region::{Region, Scratch, components, grow};
use super::{SmoothOptions, bad_quads, energy, lbfgs};
use csalf_geom::Point2;
use csalf_mesh::{QuadMesh, QuadTopology, quality::FLAT};
use csalf_sizemap::SizeField;
use rayon::prelude::*;

/// How hard it is tried.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Rings around the bad quads, per attempt. More: more room, more cost.
    rings: &'static [usize],
    /// Most reductions of eps in one attempt.
    outer: usize,
    /// A region that has not come closer by a tenth in so many reductions will not come free. Larger: some more regions
    /// do, at the cost of all that do not. *Arbitrary.*
    patience: usize,
    /// Most L-BFGS iterations per eps (handbook 7.4: 100 to 300); half as many after each eps that has brought no
    /// progress.
    inner: usize,
}

impl Effort {
    /// For meshes that must come out positive.
    pub(crate) const FULL: Self = Self { rings: &[3, 8], outer: 20, patience: 4, inner: 150 };
    /// For one of many candidates, in a small copy of its surroundings: those that come free nearly all do so soon.
    pub(crate) const TRIAL: Self = Self { rings: &[8], outer: 8, patience: 2, inner: 40 };
}

/// Most evaluations of the energy of a region, times its quads: some tenths of a second. See [`LEAST`];
/// smaller regions end by [`Effort`]. Larger: some more of them come free.
const WORK: usize = 4_000_000;

/// Regions that [`WORK`] gives fewer evaluations are not tried. Smaller: time for regions that are cut short long
/// before they come free. *Arbitrary.*
const LEAST: usize = 1000;

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
/// do not move; quads outside the regions keep their bytes. A quad that is not bad stays so.
/// Cost: one pass over the mesh, then about 0.1 us per quad of a region and L-BFGS iteration.
pub fn untangle(
    mesh: &mut QuadMesh,
    topology: &QuadTopology,
    fixed: &[bool],
    size: &dyn SizeField,
    options: &SmoothOptions,
) -> UntangleReport {
    untangle_with(mesh, topology, fixed, size, options, &Effort::FULL)
}

/// [`untangle`], as hard as asked.
pub(crate) fn untangle_with(
    mesh: &mut QuadMesh,
    topology: &QuadTopology,
    fixed: &[bool],
    size: &dyn SizeField,
    options: &SmoothOptions,
    effort: &Effort,
) -> UntangleReport {
    let mut bad = bad_quads(mesh, FLAT);
    let mut report = UntangleReport { n_bad_before: bad.len(), n_bad_after: bad.len(), ..Default::default() };
    if bad.is_empty() {
        return report;
    }
    let mut scratch = Scratch::new(mesh);
    for &rings in effort.rings {
        let free = grow(mesh, topology, fixed, &bad, rings);
        let mut regions: Vec<Region> = components(mesh, topology, &free)
            .iter()
            .map(|free| Region::new(mesh, topology, free, &mut scratch))
            .filter(|r| r.quads.len() * LEAST <= WORK && r.min_scaled() <= FLAT)
            .collect();
        report.n_regions += regions.len();
        let solved: Vec<Solved> =
            regions.par_iter_mut().map(|r| solve(r, size, options.lambda, effort)).collect();
        for (region, solved) in regions.iter().zip(solved) {
            report.outer_iterations = report.outer_iterations.max(solved.outer);
            if solved.better {
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

/// What came of a region.
struct Solved {
    /// Its points are to be taken over: no quad is bad that was not before, and fewer are.
    better: bool,
    /// Reductions of eps that it took.
    outer: usize,
}

/// Untangles one region.
fn solve(region: &mut Region, size: &dyn SizeField, lambda: f64, effort: &Effort) -> Solved {
    region.set_sizes_to_fill(size);
    let length = region.inverse.iter().map(|i| 1.0 / i[0]).sum::<f64>() / region.inverse.len().max(1) as f64;
    let n = region.n_free;
    let was_bad: Vec<bool> = (0..region.quads.len()).map(|q| region.is_bad(q)).collect();
    let n_bad = was_bad.iter().filter(|&&bad| bad).count();
    let mut kept: (usize, Vec<Point2>) = (n_bad, region.points[..n].to_vec());
    let mut x = kept.1.clone();
    let mut gradient = vec![Point2::ZERO; n];
    let (_, mut min_d) = energy::regularised(region, &x, lambda, 1.0, &mut gradient);
    let mut eps = next_eps(min_d);
    let (mut best, mut since) = (min_d, 0);
    let mut left = WORK / region.quads.len().max(1);
    let mut outer = 0;
    while outer < effort.outer && since < effort.patience && left > 0 && kept.0 > 0 {
        outer += 1;
        // What comes no closer gets less and less.
        lbfgs::minimise(&mut x, (effort.inner >> since).min(left), 0.1 * length, STOP, |x, g| {
            left = left.saturating_sub(1);
            energy::regularised(region, x, lambda, eps, g).0
        });
        let before = min_d;
        min_d = energy::regularised(region, &x, lambda, eps, &mut gradient).1;
        region.points[..n].copy_from_slice(&x);
        let now = (0..was_bad.len()).filter(|&q| region.is_bad(q)).map(|q| was_bad[q]);
        let count = now.map(|old| if old { 1 } else { n_bad }).sum::<usize>();
        if count < kept.0 {
            kept = (count, x.clone());
        }
        since += 1;
        if min_d > 0.9 * best {
            (best, since) = (min_d, 0);
        }
        // Follow the smallest Jacobian; where it does not move, tighten all the same.
        eps = if min_d > before { next_eps(min_d).min(eps) } else { 0.5 * eps };
    }
    region.points[..n].copy_from_slice(&kept.1);
    Solved { better: kept.0 < n_bad, outer }
}

/// The regularisation for a smallest Jacobian: a fifth of its depth below zero. (Handbook 7.4.)
fn next_eps(min_d: f64) -> f64 {
    (MIN_EPS_SQUARED + 0.04 * min_d.min(0.0).powi(2)).sqrt()
}
