//! Chooses corners, pattern, rotation and chord counts for a contour, by a ladder of ever dearer tests.
//!
//! ```text
//!   contour ─▶ survey ─▶ interpretations ─▶ pattern x rotation x chords ─▶ coarse trials ─▶ ranked plans
//!              5 ns/node   best few by angles   best few by forecast          ~10 us each
//! ```
//!
//! 1. [`Survey`] refuses most contours in one pass.
//! 2. The cheapest interpretations are matched with all patterns of their number of corners, in all
//!    rotations.
//! 3. Each solution of the chord system is forecast: Tutte positions of the inner pattern vertices, misfit
//!    of the edge lengths to x h, corner angles of the pattern quads.
//! 4. The best forecasts are tried with at most [`COARSE`] subdivisions per chord and measured (handbook
//!    5.6).

use crate::corners::{Interpretation, Survey, along};
use crate::fill::{Filler, tutte};
use crate::local_size::LocalSize;
use crate::pattern::{Chords, MAX_CHORDS, MAX_SIDES, MAX_VERTICES, Pattern};
use crate::quality::{fit, rough_ln, shape};
use crate::rules::{TfiMode, TfiRules};
use crate::table::patterns;
use csalf_geom::Point2;
use csalf_mesh::{Appraisal, Recipe, RegionTask};
use csalf_sizemap::Hint;

/// Subdivisions of a chord in a coarse trial, if its sides are straight; curved ones get more.
const COARSE: u32 = 3;
/// Most subdivisions of a chord in a coarse trial.
const COARSE_CURVED: u32 = 12;
/// A coarse edge bends by at most this (radians): coarser forecasts are far too bad on arcs (a full ring of
/// three segments is a triangle).
const COARSE_BEND: f64 = 0.45;
/// A contour without corners whose concave nodes bend by more than this (degrees) is no disk.
const MAX_CONCAVE: f64 = 60.0;
/// Interpretations that fit worse than the best by this much are not matched.
const COST_GAP: f64 = 0.8;
/// Most interpretations that are matched with patterns.
const MAX_INTERPRETATIONS: usize = 6;
/// Most coarse trials.
const MAX_TRIALS: usize = 3;
/// Most plans whose chords are improved by descent.
const MAX_DESCENTS: usize = 8;
/// A plan is not tried if a good one is better by this much in the forecast.
const GAP: f64 = 0.15;
/// Most chord solutions that are forecast per pattern and rotation.
const MAX_SOLUTIONS: usize = 24;

/// Drafts that most contours have at most: room for them is made at once.
const DRAFTS: usize = 48;

/// A way to fill the contour, with its forecast.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The pattern.
    pub pattern: &'static Pattern,
    /// Subdivisions per chord.
    pub x: Chords,
    /// Occurrence of the pattern's boundary vertex 0.
    pub start: u32,
    /// Smallest angle of a chosen corner, degrees.
    pub sharpest: f64,
    /// Forecast misfit: lower is better.
    pub misfit: f64,
    /// Root mean square of ln(edge length / h) in the coarse trial.
    pub edge_misfit: f64,
    /// Forecast from the coarse trial.
    pub appraisal: Appraisal,
}

impl Plan {
    /// The plan as a [`Recipe`].
    pub fn recipe(&self) -> Recipe {
        let mut words = [0; Recipe::WORDS];
        let k = patterns(self.pattern.n_corners).iter().position(|p| std::ptr::eq(p, self.pattern));
        words[0] = self.pattern.n_corners as u32;
        words[1] = k.map_or(u32::MAX, |k| k as u32);
        words[2] = self.start;
        words[3] = (self.sharpest as f32).to_bits();
        words[4..4 + MAX_CHORDS].copy_from_slice(&self.x);
        Recipe { words }
    }

    /// The plan of a recipe, without its forecast; `None` if the recipe was not made by [`Self::recipe`].
    pub fn of_recipe(recipe: &Recipe) -> Option<Self> {
        let w = &recipe.words;
        let pattern = patterns(w[0] as usize).get(w[1] as usize)?;
        let mut x = [0; MAX_CHORDS];
        x.copy_from_slice(&w[4..4 + MAX_CHORDS]);
        let unknown = Appraisal {
            min_sj: -1.0,
            mean_sj: -1.0,
            n_irregular: pattern.n_irregular as u32,
            n_quads: pattern.n_quads(&x) as u32,
            size_error: f64::MAX,
            worst_size_error: f64::MAX,
        };
        let sharpest = f64::from(f32::from_bits(w[3]));
        Some(Self {
            pattern,
            x,
            start: w[2],
            sharpest,
            misfit: 0.0,
            edge_misfit: f64::MAX,
            appraisal: unknown,
        })
    }

    /// Number of ring nodes that the plan fits.
    fn ring(&self) -> usize {
        let p = self.pattern;
        p.chord[..p.n_boundary].iter().map(|&c| self.x[c as usize] as usize).sum()
    }

    /// True if the plan fits a contour of `n` nodes.
    pub fn fits(&self, n: usize) -> bool {
        self.ring() == n
            && (self.start as usize) < n
            && self.x[..self.pattern.n_chords].iter().all(|&x| x > 0)
    }

    /// Handbook 5.6, with a term for the lengths of the edges, by which rings and splits are chosen:
    /// mean SJ + 0.5 min SJ - 0.1 ln(largest size error) - 0.3 rms ln(edge/h) - 0.02 per irregular vertex.
    pub fn score(&self) -> f64 {
        let a = &self.appraisal;
        let size = 0.1 * a.worst_size_error.ln() + 0.3 * self.edge_misfit;
        a.mean_sj + 0.5 * a.min_sj - size - 0.02 * f64::from(a.n_irregular)
    }

    /// True if no pattern with more irregular vertices could be much better.
    fn good(&self) -> bool {
        let a = &self.appraisal;
        let sharp = if self.sharpest < 90.0 { self.sharpest.to_radians().sin() } else { 1.0 };
        a.min_sj >= 0.65 * sharp && a.mean_sj >= 0.88 && a.worst_size_error <= 2.2 && self.edge_misfit <= 0.35
    }

    /// True if the rules accept a patch like the forecast. `slack` (0 to 1) weakens the thresholds of
    /// shape: the coarse trial is a forecast only.
    pub fn accepted(&self, rules: &TfiRules, n: usize, slack: f64) -> bool {
        let a = &self.appraisal;
        a.min_sj >= rules.floor(n, self.sharpest) * (1.0 - slack)
            && a.mean_sj >= rules.mean_sj * (1.0 - 0.5 * slack)
            && a.size_error <= rules.size_error
            && a.worst_size_error <= rules.worst_size_error
    }
}

/// Interpretations worth a match, best first.
type Choices = [Option<Interpretation>; MAX_INTERPRETATIONS];

/// A plan before its trial.
#[derive(Clone, Debug)]
struct Draft {
    plan: Plan,
    /// Side lengths in the order of the pattern.
    sides: [u32; MAX_SIDES],
    n_sides: usize,
    /// The chords may still be improved by descent.
    rough: bool,
    /// The part of the misfit that does not come from [`forecast`].
    fixed: f64,
    /// The misfit is `fixed` alone.
    flat: bool,
}

impl Draft {
    /// Improves the chords, if that was not done.
    fn descend(&mut self, task: &RegionTask<'_>) {
        if !std::mem::take(&mut self.rough) {
            return;
        }
        let longest = self.sides.iter().copied().max().unwrap_or(1);
        let (pattern, start) = (self.plan.pattern, self.plan.start);
        let cost = &mut |x: &Chords| forecast(task, pattern, x, start);
        let misfit = pattern.descend(&self.sides[..self.n_sides], &mut self.plan.x, longest / 16, cost);
        self.plan.misfit = if self.flat { self.fixed } else { self.fixed + misfit };
        self.plan.appraisal.n_quads = pattern.n_quads(&self.plan.x) as u32;
    }
}

fn choices(survey: &Survey, rules: &TfiRules, n: usize) -> Choices {
    let paper = rules.mode == TfiMode::Paper;
    let mut best: Choices = [None; MAX_INTERPRETATIONS];
    if paper && !survey.convex {
        return best;
    }
    survey.interpretations(n, &mut |i| {
        let ranked = |i: &Interpretation| i.cost + 0.25 * (i.n as f64 - 4.0).abs();
        if paper && i.n != 4 {
            return;
        }
        if let Some(k) = best.iter().position(|b| b.is_none_or(|b| ranked(&i) < ranked(&b))) {
            best[k..].rotate_right(1);
            best[k] = Some(i);
        }
    });
    // By cost the first is not always the best, as the rank also counts corners.
    let least = best.iter().flatten().map(|i| i.cost).fold(f64::MAX, f64::min);
    for b in &mut best {
        b.take_if(|i| i.cost > least + COST_GAP);
    }
    best
}

/// Step 3 for the patterns of one of the two stages.
fn drafts(
    task: &RegionTask<'_>,
    rules: &TfiRules,
    survey: &Survey,
    best: &Choices,
    extra: bool,
) -> Vec<Draft> {
    let mut found = Vec::with_capacity(DRAFTS);
    for i in best.iter().flatten() {
        if i.n > 0 {
            match_patterns(task, rules, i, extra, &mut found);
        } else if !extra && survey.concave < MAX_CONCAVE {
            disks(task, rules, i, &mut found);
        }
    }
    found
}

/// The task with a size field that is cheap to ask, if the contour allows.
macro_rules! with_local_size {
    ($task:ident) => {
        let local =
            if $task.size.constant().is_none() { LocalSize::of($task.contour, $task.size) } else { None };
        // Forecasts ask for many sizes: a parabola is enough where it fits.
        let $task = &match &local {
            Some(local) => RegionTask { size: local, ..*$task },
            None => *$task,
        };
    };
}

/// Smallest forecast misfit of a plan for the contour, without any trial; `None` if there is no plan.
pub fn least_misfit(task: &RegionTask<'_>, rules: &TfiRules) -> Option<f64> {
    let survey = Survey::new(task.contour, rules.reflex)?;
    with_local_size!(task);
    let best = choices(&survey, rules, task.contour.len());
    [false, true].into_iter().find_map(|extra| {
        let found = drafts(task, rules, &survey, &best, extra);
        found.iter().map(|d| d.plan.misfit).min_by(f64::total_cmp)
    })
}

/// All plans worth a thought, best first by score.
pub fn plans(task: &RegionTask<'_>, rules: &TfiRules, filler: &mut Filler) -> Vec<Plan> {
    let c = task.contour;
    let Some(survey) = Survey::new(c, rules.reflex) else { return Vec::new() };
    with_local_size!(task);
    let best = choices(&survey, rules, c.len());
    let bends = cumulative_bends(&c.points);
    let mut tried: Vec<Plan> = Vec::new();
    for extra in [false, true] {
        let mut found = drafts(task, rules, &survey, &best, extra);
        found.sort_by(|a, b| a.plan.misfit.total_cmp(&b.plan.misfit));
        found.truncate(MAX_DESCENTS);
        found.iter_mut().for_each(|d| d.descend(task));
        found.sort_by(|a, b| a.plan.misfit.total_cmp(&b.plan.misfit));
        found.truncate(MAX_TRIALS);
        for Draft { plan: mut p, .. } in found {
            // The forecast ranks well, but not within small differences.
            if tried.iter().any(|t| t.good() && t.misfit + GAP < p.misfit) {
                break;
            }
            try_coarse(task, &mut p, &bends, filler);
            tried.push(p);
        }
        if tried.iter().any(Plan::good) {
            break;
        }
    }
    tried.sort_by(|a, b| b.score().total_cmp(&a.score()));
    tried
}

/// The plans for a contour whose corners are given, best forecast first: without coarse trials, since the
/// nodes of the contour are moved afterwards.
pub fn given_plans(task: &RegionTask<'_>, rules: &TfiRules) -> Vec<Plan> {
    let mut found = Vec::new();
    let Some(i) = Interpretation::given(&task.contour.wanted) else { return Vec::new() };
    for extra in [false, true] {
        if i.n > 0 {
            match_patterns(task, rules, &i, extra, &mut found);
        } else if !extra {
            disks(task, rules, &i, &mut found);
        }
        if !found.is_empty() {
            break;
        }
    }
    found.iter_mut().for_each(|d| d.descend(task));
    let mut found: Vec<Plan> = found.into_iter().map(|d| d.plan).collect();
    found.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
    found
}

fn match_patterns(
    task: &RegionTask<'_>,
    rules: &TfiRules,
    i: &Interpretation,
    extra: bool,
    found: &mut Vec<Draft>,
) {
    let n = task.contour.len();
    let sides = i.sides(n);
    for pattern in patterns(i.n) {
        if rules.mode == TfiMode::Paper && pattern.n_irregular > 0 {
            continue;
        }
        if task.contour.most_irregular.is_some_and(|most| pattern.n_irregular > most as usize) {
            continue;
        }
        // Patterns with a 3-5 pair more than the number of corners asks for come second.
        if (pattern.n_irregular > i.n.abs_diff(4).max(if i.n == 4 { 2 } else { 0 })) != extra {
            continue;
        }
        let turns = if pattern.symmetric { 1 } else { i.n };
        for r in 0..turns {
            let mut s = [0; MAX_SIDES];
            (0..i.n).for_each(|k| s[k] = sides[(k + r) % i.n]);
            collect(task, rules, pattern, &s[..i.n], i.corners[r], 1, i, found);
        }
    }
}

/// The disk pattern has no corners: its centre block may be turned and have any proportion.
fn disks(task: &RegionTask<'_>, rules: &TfiRules, i: &Interpretation, found: &mut Vec<Draft>) {
    let n = task.contour.len() as u32;
    let most = task.contour.most_irregular.unwrap_or(u32::MAX);
    if n < 4 || rules.mode == TfiMode::Paper {
        return;
    }
    let half = n / 2;
    let rings = (f64::from(n) / 16.0).round().max(1.0) as u32;
    // The best rectangles among the virtual corners: right angles, and sides in proportion to their counts.
    let mut best = [(f64::MAX, 0u32, 0u32); 2];
    for a in [n / 4, half * 3 / 8, half / 3, half / 4] {
        if a < 1 || half <= a {
            continue;
        }
        let b = half - a;
        let period = if a == b { a } else { half };
        for o in (0..period).step_by((period / 24).max(1) as usize) {
            let p = [o, o + a, o + half, o + half + a].map(|k| task.contour.points[(k % n) as usize]);
            let e = [p[1] - p[0], p[2] - p[1], p[3] - p[2], p[0] - p[3]];
            let l = e.map(|e| e.length().max(f64::MIN_POSITIVE));
            let lack: f64 =
                (0..4).map(|k| (1.0 - e[k].perp_dot(e[(k + 1) % 4]) / (l[k] * l[(k + 1) % 4])).abs()).sum();
            let ratio = ((l[0] + l[2]) * f64::from(b) / ((l[1] + l[3]) * f64::from(a))).ln();
            let cost = lack + 0.5 * ratio * ratio;
            if let Some(k) = best.iter().position(|b| cost < b.0) {
                best[k..].rotate_right(1);
                best[k] = (cost, a, o);
            }
        }
    }
    for pattern in patterns(0).iter().filter(|p| p.n_irregular <= most as usize) {
        for &(cost, a, o) in best.iter().filter(|b| b.1 > 0 && b.0 < 2.0) {
            for m in [1, rings.div_ceil(2), rings] {
                let first = found.len();
                collect(task, rules, pattern, &[a, half - a, a, half - a], o, m, i, found);
                let misfit = i.cost + 0.4 + cost + 0.01 * f64::from(m);
                for d in &mut found[first..] {
                    (d.plan.misfit, d.fixed, d.flat) = (misfit, misfit, true);
                }
            }
        }
    }
}

/// Forecasts the solutions of one pattern in one rotation and keeps the best, and the best of
/// those with thick blocks: the forecast is rough.
#[expect(clippy::too_many_arguments, reason = "one call deep, all different")]
fn collect(
    task: &RegionTask<'_>,
    rules: &TfiRules,
    pattern: &'static Pattern,
    sides: &[u32],
    start: u32,
    closed: u32,
    i: &Interpretation,
    found: &mut Vec<Draft>,
) {
    let mut best: Option<(f64, Chords)> = None;
    let mut even: Option<(f64, f64, Chords)> = None;
    pattern.solve(sides, closed, MAX_SOLUTIONS, &mut |x| {
        let f = forecast(task, pattern, x, start);
        if best.is_none_or(|(c, _)| f < c) {
            best = Some((f, *x));
        }
        // The irregular vertices are farthest from each other and from the boundary.
        let spread = f + x[..pattern.n_chords].iter().map(|&x| 1.0 / f64::from(x)).sum::<f64>();
        if even.is_none_or(|(c, _, _)| spread < c) {
            even = Some((spread, f, *x));
        }
    });
    let (Some((misfit, x)), Some((_, even_misfit, even))) = (best, even) else { return };
    let second = (x != even).then_some((even, even_misfit, false));
    for (x, misfit, rough) in [Some((x, misfit, true)), second].into_iter().flatten() {
        let n_quads = pattern.n_quads(&x);
        if n_quads > rules.most_quads {
            continue;
        }
        let fixed = i.cost + 0.1 * pattern.n_irregular as f64;
        let mut list = [0; MAX_SIDES];
        list[..sides.len()].copy_from_slice(sides);
        found.push(Draft {
            plan: Plan {
                pattern,
                x,
                start,
                sharpest: i.sharpest,
                misfit: fixed + misfit,
                edge_misfit: f64::MAX,
                appraisal: Appraisal {
                    min_sj: -1.0,
                    mean_sj: -1.0,
                    n_irregular: pattern.n_irregular as u32,
                    n_quads: n_quads as u32,
                    size_error: f64::MAX,
                    worst_size_error: f64::MAX,
                },
            },
            sides: list,
            n_sides: sides.len(),
            rough,
            fixed,
            flat: false,
        });
    }
}

/// Misfit of one solution: mean squared log of (edge length / (x h)) over the inner pattern edges, and the
/// lack of scaled Jacobian of the pattern quads. 0 for a single block.
fn forecast(task: &RegionTask<'_>, pattern: &Pattern, x: &Chords, start: u32) -> f64 {
    let nb = pattern.n_boundary;
    if pattern.edges.len() == nb {
        return 0.0;
    }
    let p = &task.contour.points;
    let mut xy = [Point2::ZERO; MAX_VERTICES];
    let mut at = start as usize;
    for (k, v) in xy.iter_mut().enumerate().take(nb) {
        *v = p[at % p.len()];
        at += x[pattern.chord[k] as usize] as usize;
    }
    let mut hint = Hint::default();
    tutte(pattern, x, &mut xy, None, &mut hint);
    let mut sum = 0.0;
    let mut weight = 0.0;
    for e in nb..pattern.edges.len() {
        let [a, b] = pattern.edges[e].map(|v| xy[v as usize]);
        let m = f64::from(x[pattern.chord[e] as usize]);
        let h = task.size.h(a.midpoint(b), &mut hint);
        let r = rough_ln(a.distance(b).max(f64::MIN_POSITIVE) / (m * h));
        sum += r * r;
        weight += 1.0;
    }
    let (mut bad, mut cells) = (0.0, 0.0);
    for (q, s) in pattern.quads.iter().zip(&pattern.quad_edges) {
        let [a, b] = [0, 1].map(|k| f64::from(x[pattern.chord[s[k].0 as usize] as usize]));
        let mut lack = 0.0;
        let p = q.map(|v| xy[v as usize]);
        for k in 0..4 {
            let (u, v) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
            let ll = (u.length_squared() * v.length_squared()).sqrt();
            let s = if ll > 0.0 { u.perp_dot(v) / ll } else { 0.0 };
            lack += (1.0 - s) * (1.0 - s);
        }
        // The cells count, but so does every block.
        let m = (a * b).sqrt();
        bad += lack * m;
        cells += m;
    }
    sum / weight + 2.0 * bad / (4.0 * cells)
}

/// Sum of the absolute bends (radians, as chords of the unit circle) of the nodes before each; n + 1 entries.
fn cumulative_bends(p: &[Point2]) -> Vec<f64> {
    let n = p.len();
    let mut out = Vec::with_capacity(n + 1);
    let mut sum = 0.0;
    out.push(sum);
    let mut u = (p[0] - p[n - 1]).normalize_or_zero();
    for i in 0..n {
        let v = (p[(i + 1) % n] - p[i]).normalize_or_zero();
        sum += v.distance(u);
        out.push(sum);
        u = v;
    }
    out
}

/// The cumulative sum at index `i`, which may run once around.
fn at_wrapped(sums: &[f64], i: usize) -> f64 {
    let n = sums.len() - 1;
    if i <= n { sums[i] } else { sums[n] + sums[(i - n).min(n)] }
}

/// Fills a coarse copy and measures it.
fn try_coarse(task: &RegionTask<'_>, plan: &mut Plan, bends: &[f64], filler: &mut Filler) {
    let pattern = plan.pattern;
    let p = &task.contour.points;
    let mut x: Chords = [0; MAX_CHORDS];
    (0..pattern.n_chords).for_each(|c| x[c] = plan.x[c].min(COARSE));
    let mut from = plan.start as usize;
    for e in 0..pattern.n_boundary {
        let c = pattern.chord[e] as usize;
        let to = from + plan.x[c] as usize;
        // Bends of the nodes strictly between the ends of the edge; the ends are kept in any case.
        let bend = at_wrapped(bends, to) - at_wrapped(bends, from + 1);
        let wanted = (bend / COARSE_BEND).ceil().min(f64::from(COARSE_CURVED)) as u32;
        x[c] = x[c].max(wanted.min(plan.x[c]));
        from = to;
    }
    let mut at = f64::from(plan.start);
    let ring = (0..pattern.n_boundary).flat_map(|e| {
        let c = pattern.chord[e] as usize;
        let (from, step, m) = (at, f64::from(plan.x[c]) / f64::from(x[c]), x[c]);
        at += f64::from(plan.x[c]);
        (0..m).map(move |i| along(p, from + step * f64::from(i)))
    });
    filler.fill(pattern, &x, ring, 0, task.size, &plan.x);
    if pattern.n_irregular > 0 {
        filler.relax(task.size, 6);
    }
    let s = shape(&filler.points, &filler.quads);
    let f = fit(&filler.points, &filler.quads, task.size, usize::MAX, &filler.factor);
    plan.edge_misfit = f.edges;
    let a = &mut plan.appraisal;
    (a.min_sj, a.mean_sj, a.size_error, a.worst_size_error) = (s.min_sj, s.mean_sj, f.mean, f.worst);
}
