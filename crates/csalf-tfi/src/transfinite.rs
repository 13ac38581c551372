//! The member of the triad that finishes contours: transfinite interpolation and its patterns.

use crate::fill::Filler;
use crate::plan::{Plan, given_plans, least_misfit, plans};
use crate::quality::{fit, shape};
use crate::rules::{TfiMode, TfiRules};
use csalf_mesh::{Appraisal, Contour, Patch, Recipe, Refusal, RegionMesher, RegionTask};
use csalf_sizemap::{Hint, esg::extremum_size_gradient};
use std::cell::RefCell;

/// Most quads whose size is checked on the finished patch.
const SIZE_SAMPLES: usize = 512;
/// Patches of more quads take the buffers with them, so that no thread keeps much memory.
const KEPT: usize = 4096;
/// Relaxation sweeps on a patch with irregular vertices. Measured: 4 beat 2, 8 and 16 in the smallest
/// scaled Jacobian of most shapes; more drift towards the Laplace solution, which crowds the 3-valent
/// vertices.
const SWEEPS: usize = 4;
/// How far (0 to 1) a forecast may fall short of the rules: the coarse trial is mostly worse than the
/// finished mesh.
const SLACK: f64 = 0.2;
/// Finished patches that are tried before the contour is refused.
const MAX_FILLS: usize = 3;
/// Of patches with more quads only the best plan is tried: where it fails, a split is better than the others
/// (a plate with a hole, 100,000 quads: smallest scaled Jacobian 0.67 to 0.77, time -12 %).
const LARGE: u32 = 4096;

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
        if self.rules.mode == TfiMode::Paper
            && extremum_size_gradient(&task.contour.points, task.size, &mut Hint::default()) > self.rules.esg
        {
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

    /// Fills a contour whose corners are given by the best of the first plans, whatever its quality.
    fn fill_given(&self, task: &RegionTask<'_>) -> Result<Patch, Refusal> {
        let c = task.contour;
        let n = c.len();
        if c.wanted.len() != n {
            return Err(Refusal::NotApplicable);
        }
        let list = given_plans(task, &self.rules);
        let mut best: Option<(f64, Patch)> = None;
        FILLER.with_borrow_mut(|filler| {
            for plan in list.iter().take(MAX_FILLS) {
                filler.fill(plan.pattern, &plan.x, c.points.iter().copied(), plan.start, task.size, &plan.x);
                if plan.pattern.n_irregular > 0 {
                    filler.relax(task.size, SWEEPS);
                }
                let s = shape(&filler.points, &filler.quads);
                let f = fit(&filler.points, &filler.quads, task.size, SIZE_SAMPLES, &[]);
                // As the score of a plan; irregular vertices are counted by the caller.
                let score = s.mean_sj + 0.5 * s.min_sj
                    - 0.1 * f.worst.ln()
                    - 0.3 * f.edges
                    - 0.02 * plan.pattern.n_irregular as f64;
                if best.as_ref().is_none_or(|b| score > b.0) && !has_double(c, &filler.quads) {
                    let points = filler.points[n..].to_vec();
                    best = Some((score, Patch { points, quads: filler.quads.clone(), ..Patch::default() }));
                }
            }
        });
        best.map(|b| b.1).ok_or(Refusal::NotApplicable)
    }

    fn fill_with(&self, task: &RegionTask<'_>, plan: &Plan, filler: &mut Filler) -> Result<Patch, Refusal> {
        let c = task.contour;
        let n = c.len();
        filler.fill(plan.pattern, &plan.x, c.points.iter().copied(), plan.start, task.size, &plan.x);
        if plan.pattern.n_irregular > 0 {
            filler.relax(task.size, SWEEPS);
        }
        let floor = self.rules.floor(n, plan.sharpest);
        let mut s = shape(&filler.points, &filler.quads);
        if s.min_sj < floor {
            filler.relax(task.size, 4 * SWEEPS);
            s = shape(&filler.points, &filler.quads);
        }
        if s.min_sj <= 0.0 || s.min_sj < floor || s.mean_sj < self.rules.mean_sj {
            return Err(Refusal::Quality);
        }
        let f = fit(&filler.points, &filler.quads, task.size, SIZE_SAMPLES, &[]);
        if f.mean > self.rules.size_error || f.worst > self.rules.worst_size_error {
            return Err(Refusal::Size);
        }
        if has_double(c, &filler.quads) {
            return Err(Refusal::NotApplicable);
        }
        // Big buffers go to the patch, small ones stay for the next contour.
        let (mut points, quads) = if filler.quads.len() > KEPT {
            (std::mem::take(&mut filler.points), std::mem::take(&mut filler.quads))
        } else {
            return Ok(Patch {
                points: filler.points[n..].to_vec(),
                quads: filler.quads.clone(),
                ..Patch::default()
            });
        };
        points.drain(..n);
        Ok(Patch { points, quads, ..Patch::default() })
    }
}

impl RegionMesher for Transfinite {
    fn name(&self) -> &'static str {
        "tfi"
    }

    /// The forecast of the best plan that the rules accept.
    fn appraise(&self, task: &RegionTask<'_>) -> Option<Appraisal> {
        let n = task.contour.len();
        self.plans(task).iter().find(|p| p.accepted(&self.rules, n, SLACK)).map(|p| p.appraisal)
    }

    fn glance(&self, task: &RegionTask<'_>) -> Option<f64> {
        if self.rules.mode == TfiMode::Paper {
            return self.appraise(task).map(|a| 1.0 - a.mean_sj);
        }
        least_misfit(task, &self.rules)
    }

    fn foresee(&self, task: &RegionTask<'_>) -> Option<(Appraisal, Recipe)> {
        let n = task.contour.len();
        let plans = self.plans(task);
        plans.iter().find(|p| p.accepted(&self.rules, n, SLACK)).map(|p| (p.appraisal, p.recipe()))
    }

    fn mesh_by(&self, task: &RegionTask<'_>, recipe: &Recipe) -> Result<Patch, Refusal> {
        match Plan::of_recipe(recipe) {
            Some(plan) if plan.fits(task.contour.len()) && task.contour.wanted.is_empty() => {
                let large = plan.appraisal.n_quads > LARGE;
                self.fill(task, &plan).or_else(|why| if large { Err(why) } else { self.mesh(task) })
            }
            _ => self.mesh(task),
        }
    }

    fn mesh(&self, task: &RegionTask<'_>) -> Result<Patch, Refusal> {
        let n = task.contour.len();
        if !task.contour.wanted.is_empty() {
            return self.fill_given(task);
        }
        let plans = self.plans(task);
        let mut why = Refusal::NotApplicable;
        // The coarse trial may be a little too hard on a patch: the finished one decides.
        for plan in plans.iter().filter(|p| p.accepted(&self.rules, n, SLACK)).take(MAX_FILLS) {
            match self.fill(task, plan) {
                Ok(patch) => return Ok(patch),
                Err(e) => why = e,
            }
            if plan.appraisal.n_quads > LARGE {
                break;
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

/// True if two occurrences of one node meet in a quad. Cost: a sort of the ids; the quads are looked at
/// only if a node occurs twice.
fn has_double(c: &Contour, quads: &[[u32; 4]]) -> bool {
    let mut sorted = c.ids.clone();
    sorted.sort_unstable();
    if sorted.windows(2).all(|w| w[0] != w[1]) {
        return false;
    }
    let id = |v: u32| c.ids.get(v as usize).copied();
    quads.iter().any(|q| (0..4).any(|i| (0..i).any(|j| id(q[i]).is_some() && id(q[i]) == id(q[j]))))
}
