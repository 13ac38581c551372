//! The member of the triad that finishes contours: transfinite interpolation and its patterns.

use crate::fill::Filler;
use crate::plan::{Plan, plans};
use crate::quality::{shape, size_errors};
use crate::rules::{TfiMode, TfiRules};
use csalf_geom::Point2;
use csalf_mesh::{Appraisal, Patch, Refusal, RegionMesher, RegionTask};
use csalf_sizemap::Hint;
use std::cell::RefCell;

/// Most quads whose size is checked on the finished patch.
const SIZE_SAMPLES: usize = 512;
/// Relaxation sweeps on a patch with irregular vertices.
const SWEEPS: usize = 8;
/// Finished patches that are tried before the contour is refused.
const MAX_FILLS: usize = 3;

/// Fills a contour in one step with quads, by one block or an N-sided pattern of blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Transfinite {
    /// When a patch is good enough.
    pub rules: TfiRules,
}

thread_local! {
    static FILLER: RefCell<Filler> = RefCell::default();
}

impl Transfinite {
    /// A mesher with these rules.
    pub fn new(rules: TfiRules) -> Self {
        Self { rules }
    }

    /// The ranked plans for a contour: for pictures, tests and lookahead.
    pub fn plans(&self, task: &RegionTask<'_>) -> Vec<Plan> {
        if self.rules.mode == TfiMode::Paper && esg(task) > self.rules.esg {
            return Vec::new();
        }
        FILLER.with_borrow_mut(|f| plans(task, &self.rules, f))
    }

    /// Fills the contour by a plan, whatever its quality, if all quads are strictly convex.
    ///
    /// # Errors
    /// [`Refusal::Quality`] or [`Refusal::Size`] by the rules.
    pub fn fill(&self, task: &RegionTask<'_>, plan: &Plan) -> Result<Patch, Refusal> {
        FILLER.with_borrow_mut(|f| self.fill_with(task, plan, f))
    }

    fn fill_with(&self, task: &RegionTask<'_>, plan: &Plan, filler: &mut Filler) -> Result<Patch, Refusal> {
        let c = task.contour;
        let n = c.len();
        let start = plan.start as usize;
        let ring = c.points[start..].iter().chain(&c.points[..start]).copied();
        filler.fill(plan.pattern, &plan.x, ring, task.size, &plan.x);
        if plan.pattern.n_irregular > 0 {
            filler.relax(n, task.size, SWEEPS);
        }
        let floor = self.rules.floor(n, plan.sharpest);
        let mut s = shape(&filler.points, &filler.quads);
        if s.min_sj < floor {
            filler.relax(n, task.size, 4 * SWEEPS);
            s = shape(&filler.points, &filler.quads);
        }
        if s.min_sj <= 0.0 || s.min_sj < floor || s.mean_sj < self.rules.mean_sj {
            return Err(Refusal::Quality);
        }
        let (mean, worst) = size_errors(&filler.points, &filler.quads, task.size, SIZE_SAMPLES, |_| 1.0);
        if mean > self.rules.size_error || worst > self.rules.worst_size_error {
            return Err(Refusal::Size);
        }
        let name = |v: u32| if (v as usize) < n { ((v as usize + start) % n) as u32 } else { v };
        // Two occurrences of one node must not meet in a quad.
        let double = |q: &[u32; 4]| {
            let id = |k: usize| ((q[k] as usize) < n).then(|| c.ids[q[k] as usize]);
            (0..4).any(|i| (i + 1..4).any(|j| id(i).is_some() && id(i) == id(j)))
        };
        let quads: Vec<[u32; 4]> = filler.quads.iter().map(|q| q.map(name)).collect();
        if quads.iter().any(double) {
            return Err(Refusal::NotApplicable);
        }
        Ok(Patch { points: filler.points[n..].to_vec(), quads, children: Vec::new() })
    }
}

impl RegionMesher for Transfinite {
    fn name(&self) -> &'static str {
        "tfi"
    }

    /// The forecast of the best plan that the rules accept.
    fn appraise(&self, task: &RegionTask<'_>) -> Option<Appraisal> {
        let n = task.contour.len();
        self.plans(task).iter().find(|p| p.accepted(&self.rules, n, 0.0)).map(|p| p.appraisal)
    }

    fn mesh(&self, task: &RegionTask<'_>) -> Result<Patch, Refusal> {
        let n = task.contour.len();
        let plans = self.plans(task);
        let mut why = Refusal::NotApplicable;
        // The coarse trial may be a little too hard on a patch: the finished one decides.
        for plan in plans.iter().filter(|p| p.accepted(&self.rules, n, 0.2)).take(MAX_FILLS) {
            match self.fill(task, plan) {
                Ok(patch) => return Ok(patch),
                Err(e) => why = e,
            }
        }
        if why == Refusal::NotApplicable && !plans.is_empty() {
            let a = &plans[0].appraisal;
            let size =
                a.size_error > self.rules.size_error || a.worst_size_error > self.rules.worst_size_error;
            why = if size { Refusal::Size } else { Refusal::Quality };
        }
        Err(why)
    }
}

/// Extremum size gradient (paper eq. 20 as read in handbook 1.11): the 95 % over the 5 % quantile of h, at the nodes
/// and on a 5 x 5 lattice between them and the centroid. 1 for a constant field. Cost O(n log n).
pub fn esg(task: &RegionTask<'_>) -> f64 {
    if task.size.constant().is_some() {
        return 1.0;
    }
    let c = task.contour;
    let n = c.len();
    if n == 0 {
        return 1.0;
    }
    let mut h = c.sizes.clone();
    let centre = c.points.iter().copied().sum::<Point2>() / n as f64;
    let mut hint = Hint::default();
    for i in 0..5 {
        for j in 0..5 {
            let p = c.points[(i * n) / 5];
            h.push(task.size.h(centre.lerp(p, f64::from(j) / 5.0), &mut hint));
        }
    }
    h.sort_by(f64::total_cmp);
    let at = |f: f64| h[((h.len() - 1) as f64 * f).round() as usize];
    at(0.95) / at(0.05)
}
