//! Algorithm III: the recursion over one contour, on flat buffers.
//!
//! ```text
//!   stack:  [ ... | right child | left child ]  ◀ top
//!                                   │ 4, 6, 8 nodes: a closure stencil
//!                                   │ a companion (transfinite interpolation) takes it whole
//!                                   └ else: best split line, push right, push left
//! ```
//!
//! 1. Pop the top contour.
//! 2. Four, six or eight nodes: a closure stencil ([`crate::closure`]), if it is good.
//! 3. Ask the companions in order; the first that does not refuse fills the contour.
//! 4. Split by the best line ([`crate::split`]), strict rules first, relaxed ones if nothing is found.
//! 5. If there is none: a closure stencil of any quality, then the guaranteed fallback ([`crate::fallback`]).
//!
//! With companions, step 4 looks one step ahead: of the best few splits, the one whose children the companions
//! appraise best is taken (handbook 4.6).

use crate::closure::{ClosureResult, close, close_loosely};
use crate::split::{LADDER, Split, SplitRules, Splitter, place};
use crate::view::{Nodes, View};
use csalf_geom::angle::interior_angle;
use csalf_geom::{Point2, Tolerance};
use csalf_mesh::{Appraisal, Contour, NodeFlags, Patch, Recipe, Refusal, RegionMesher, RegionTask};
use csalf_sizemap::{Hint, SizeField};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

/// What ended the contours of a recursion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Split lines drawn.
    pub splits: usize,
    /// Contours closed as a single quad or by a stencil.
    pub closures: usize,
    /// Contours taken by companions.
    pub companions: usize,
    /// Contours closed by a stencil of any shape ([`Subdivision::loose`]).
    pub loose: usize,
    /// Contours that went to the guaranteed fallback.
    pub fallbacks: usize,
}

/// Subdivision as a member of the triad.
///
/// Contours of more than [`Self::seam`] nodes are split once and given back as two children, so that the caller
/// can mesh them in parallel; smaller ones are finished inside, without an allocation per split.
#[derive(Clone, Debug)]
pub struct Subdivision {
    rules: SplitRules,
    companions: Vec<Arc<dyn RegionMesher>>,
    seam: usize,
    loose: bool,
    asked: bool,
}

/// Contours above this size go back to the driver as two children. Smaller: more parallel tasks; larger: fewer
/// allocations. Below 500 nodes the cost of the seam shows in the profile, above 4000 two threads run out of work.
pub const SEAM: usize = 1000;

/// Contour sizes for which the choice of a split looks one step ahead.
const LOOKAHEAD_SIZES: std::ops::RangeInclusive<usize> = 10..=2000;

/// Score of a child that no companion takes (handbook 4.6).
const NO_PATTERN: f64 = 1.2;

/// Splits that are fully appraised. More: better choices; an appraisal costs several times a glance.
const FINALISTS: usize = 3;

/// What even a good child costs: glances count from here on, to be comparable with full appraisals.
const GLANCE_BASE: f64 = 0.15;
/// What a unit of misfit at a glance counts: larger trusts glances more against Φ.
const GLANCE_WEIGHT: f64 = 0.5;

/// Scaled Jacobian of a closure stencil that is taken before anything else is tried.
const GOOD_CLOSURE: f64 = 0.3;

impl Subdivision {
    /// Subdivision alone (TriQuaMesh) with the given rules.
    pub fn new(rules: SplitRules) -> Self {
        Self { rules, companions: Vec::new(), seam: SEAM, loose: false, asked: false }
    }

    /// Adds a mesher that is asked before every split, after those added earlier.
    pub fn with_companion(mut self, companion: Arc<dyn RegionMesher>) -> Self {
        self.companions.push(companion);
        self
    }

    /// Contours of up to eight nodes that no good stencil closes are closed by the one that suits their angles best,
    /// though its quads may overlap and turn over: for callers that untangle the mesh. That gives far better quads than
    /// the guaranteed fallback, which is left with larger contours.
    pub fn loose(mut self, loose: bool) -> Self {
        self.loose = loose;
        self
    }

    /// For callers that ask the companions themselves before they come here: they are not asked for the whole contour
    /// again (large patches that fail are dear), only for its parts.
    pub fn behind_companions(mut self) -> Self {
        self.asked = true;
        self
    }

    /// Changes the seam size (mostly for tests); at least 16.
    pub fn with_seam(mut self, seam: usize) -> Self {
        self.seam = seam.max(16);
        self
    }

    /// Fills a contour, or splits it once if it is above the seam size.
    fn run(&self, task: &RegionTask<'_>) -> Result<(Patch, Tally), Refusal> {
        let n = task.contour.len();
        if n < 4 || n % 2 == 1 {
            return Err(Refusal::NotApplicable);
        }
        let mut r = Recursion::new(self, task);
        if n > self.seam {
            r.split_once()
        } else {
            if self.asked {
                r.frames.iter_mut().for_each(|whole| whole.forecast = Forecast::Nobody);
            }
            r.fill();
        }
        // Only a contour that is not valid comes back as it was; handing it out again would never end.
        if r.quads.is_empty() && r.children.len() == 1 && r.children[0].len() == n {
            return Err(Refusal::NotApplicable);
        }
        let tally = r.tally;
        Ok((r.into_patch(), tally))
    }

    /// As [`RegionMesher::mesh`], with the tally of what ended the contours.
    ///
    /// # Errors
    /// As [`RegionMesher::mesh`].
    pub fn mesh_with_tally(&self, task: &RegionTask<'_>) -> Result<(Patch, Tally), Refusal> {
        self.run(task)
    }
}

impl RegionMesher for Subdivision {
    fn name(&self) -> &'static str {
        "subdivision"
    }

    fn appraise(&self, _: &RegionTask<'_>) -> Option<Appraisal> {
        None // it takes everything, but cannot tell beforehand what will come out
    }

    fn mesh(&self, task: &RegionTask<'_>) -> Result<Patch, Refusal> {
        self.run(task).map(|(patch, _)| patch)
    }
}

/// What is known of a waiting contour.
#[derive(Clone, Copy, Debug)]
enum Forecast {
    Unknown,
    /// All companions refuse it.
    Nobody,
    /// This companion takes it.
    By(usize, Recipe),
}

/// A waiting contour: where it starts on the stack.
#[derive(Clone, Copy, Debug)]
struct Frame {
    start: usize,
    forecast: Forecast,
}

impl Frame {
    fn new(start: usize) -> Self {
        Self { start, forecast: Forecast::Unknown }
    }
}

/// One run over one task.
struct Recursion<'a> {
    rules: &'a SplitRules,
    loose: bool,
    companions: &'a [Arc<dyn RegionMesher>],
    size: &'a dyn SizeField,
    tolerance: Tolerance,
    /// Local patch name of each of the task's nodes: its first occurrence.
    names: Vec<u32>,
    n_ring: u32,
    nodes: Nodes,
    /// Contours waiting, the top one last, back to back.
    stack: Vec<u32>,
    frames: Vec<Frame>,
    quads: Vec<[u32; 4]>,
    children: Vec<Vec<u32>>,
    view: View,
    splitter: Splitter,
    scratch: Contour,
    line: Vec<u32>,
    child: Vec<u32>,
    /// Splits by glance.
    order: Vec<(f64, u32)>,
    /// What the lookahead knows of the children of the split that was chosen.
    forecast: [Forecast; 2],
    hint: Hint,
    tally: Tally,
}

impl<'a> Recursion<'a> {
    fn new(owner: &'a Subdivision, task: &RegionTask<'a>) -> Self {
        let c = task.contour;
        let n = c.len();
        // Occurrences of one node become one node here.
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.sort_unstable_by_key(|&i| (c.ids[i as usize], i));
        let mut node_of = vec![0u32; n];
        let mut nodes = Nodes::default();
        let mut names = Vec::new();
        for w in 0..n {
            let i = order[w] as usize;
            if w == 0 || c.ids[order[w - 1] as usize] != c.ids[i] {
                names.push(i as u32);
                nodes.push(c.points[i], c.sizes[i], c.flags[i]);
            }
            node_of[i] = names.len() as u32 - 1;
        }
        Self {
            rules: &owner.rules,
            loose: owner.loose,
            companions: &owner.companions,
            size: task.size,
            tolerance: task.tolerance,
            names,
            n_ring: n as u32,
            nodes,
            stack: node_of,
            frames: vec![Frame::new(0)],
            quads: Vec::new(),
            children: Vec::new(),
            view: View::default(),
            splitter: Splitter::default(),
            scratch: Contour::default(),
            line: Vec::new(),
            child: Vec::new(),
            order: Vec::new(),
            forecast: [Forecast::Unknown; 2],
            hint: Hint::default(),
            tally: Tally::default(),
        }
    }

    fn fill(&mut self) {
        let mut contour = Vec::new();
        while let Some(Frame { start, forecast }) = self.frames.pop() {
            contour.clear();
            contour.extend_from_slice(&self.stack[start..]);
            self.stack.truncate(start);
            self.fill_one(&contour, forecast);
        }
    }

    /// Steps 2 to 5 for one contour; children go onto the stack.
    fn fill_one(&mut self, contour: &[u32], forecast: Forecast) {
        let n = contour.len();
        if n <= 8 && self.close(contour, GOOD_CLOSURE) {
            return;
        }
        if n > 4 {
            if self.ask_companions(contour, forecast) {
                self.tally.companions += 1;
                return;
            }
            if self.split(contour) {
                return;
            }
        }
        if n <= 8 && (self.close(contour, 0.0) || self.loose && self.close_loosely(contour)) {
            return;
        }
        self.fall_back(contour);
    }

    /// Closes a contour of 4, 6 or 8 nodes by a stencil, if its worst quad is at least `least`.
    fn close(&mut self, contour: &[u32], least: f64) -> bool {
        let n = contour.len();
        let (rim, wanted) = self.angles(contour);
        let mut out = ClosureResult::default();
        if !close(&rim[..n], &wanted[..n], &mut out).is_some_and(|sj| sj >= least) {
            return false;
        }
        self.add_closure(contour, &out);
        self.tally.closures += 1;
        true
    }

    /// Closes it by the stencil that suits its angles best, whatever its quads.
    fn close_loosely(&mut self, contour: &[u32]) -> bool {
        let n = contour.len();
        let (rim, wanted) = self.angles(contour);
        let mut out = ClosureResult::default();
        if !close_loosely(&rim[..n], &wanted[..n], &mut out) {
            return false;
        }
        self.add_closure(contour, &out);
        self.tally.loose += 1;
        true
    }

    /// Points of up to eight nodes, and the number of quads that their angles ask for.
    fn angles(&self, contour: &[u32]) -> ([Point2; 8], [f64; 8]) {
        let n = contour.len();
        let mut rim = [Point2::ZERO; 8];
        let mut wanted = [0.0; 8];
        for (p, &v) in rim.iter_mut().zip(contour) {
            *p = self.nodes.points[v as usize];
        }
        for i in 0..n {
            let (a, c) = ((i + n - 1) % n, (i + 1) % n);
            let tip = contour[a] == contour[c];
            let theta = if tip { TAU } else { interior_angle(rim[a], rim[i], rim[c]) };
            wanted[i] = theta / FRAC_PI_2;
        }
        (rim, wanted)
    }

    fn add_closure(&mut self, contour: &[u32], out: &ClosureResult) {
        let n = contour.len();
        let base = self.nodes.points.len() as u32;
        for &p in out.points() {
            let h = self.size.h(p, &mut self.hint);
            self.nodes.push(p, h, NodeFlags::default());
        }
        let node = |name: u8| {
            if (name as usize) < n { contour[name as usize] } else { base + name as u32 - n as u32 }
        };
        self.quads.extend(out.quads().iter().map(|q| q.map(node)));
    }

    /// The contour as the seam's type, in `scratch`; ids are nodes.
    fn load_scratch(&mut self, contour: &[u32]) {
        load(&mut self.scratch, contour, &self.nodes);
    }

    fn ask_companions(&mut self, contour: &[u32], forecast: Forecast) -> bool {
        if self.companions.is_empty() || matches!(forecast, Forecast::Nobody) {
            return false;
        }
        self.load_scratch(contour);
        for (k, companion) in self.companions.iter().enumerate() {
            let task = RegionTask { contour: &self.scratch, size: self.size, tolerance: self.tolerance };
            let filled = match &forecast {
                Forecast::By(by, recipe) if *by == k => companion.mesh_by(&task, recipe),
                _ => companion.mesh(&task),
            };
            if let Ok(patch) = filled {
                self.take(contour, &patch);
                return true;
            }
        }
        false
    }

    /// Takes over a patch made for `contour`.
    fn take(&mut self, contour: &[u32], patch: &Patch) {
        self.tally.fallbacks += patch.n_fallbacks;
        let n = contour.len() as u32;
        let base = self.nodes.points.len() as u32;
        for &p in &patch.points {
            let h = self.size.h(p, &mut self.hint);
            self.nodes.push(p, h, Default::default());
        }
        let node = |name: u32| if name < n { contour[name as usize] } else { base + name - n };
        self.quads.extend(patch.quads.iter().map(|q| q.map(node)));
        for child in patch.children.iter().rev() {
            self.frames.push(Frame::new(self.stack.len()));
            self.stack.extend(child.iter().map(|&name| node(name)));
        }
    }

    /// Splits a contour by the best line and pushes both children, the left one on top.
    fn split(&mut self, contour: &[u32]) -> bool {
        self.view.load(contour, &self.nodes);
        let ahead = !self.companions.is_empty() && LOOKAHEAD_SIZES.contains(&contour.len());
        let wanted = if ahead { self.rules.lookahead } else { 1 };
        for strict in &LADDER {
            self.splitter.search(&self.view, self.size, &mut self.hint, self.rules, strict, wanted);
            let Some(best) = self.choose() else { continue };
            let mut line = std::mem::take(&mut self.line);
            place(&self.view, &best, &mut self.nodes, self.size, &mut self.hint, &mut line);
            self.tally.splits += 1;
            self.frames.push(Frame { start: self.stack.len(), forecast: self.forecast[1] });
            right_child(contour, &best, &line, &mut self.stack);
            self.frames.push(Frame { start: self.stack.len(), forecast: self.forecast[0] });
            left_child(contour, &best, &line, &mut self.stack);
            self.line = line;
            return true;
        }
        false
    }

    /// The best of the splits found, by lookahead if there are several; writes the lines of both children to
    /// `self.forecast`. First a glance at the children of all, then a full appraisal of the best few.
    fn choose(&mut self) -> Option<Split> {
        self.forecast = [Forecast::Unknown; 2];
        if self.splitter.found.len() < 2 {
            return self.splitter.found.first().copied();
        }
        let found = std::mem::take(&mut self.splitter.found);
        let contour = std::mem::take(&mut self.view.node);
        let mut order = std::mem::take(&mut self.order);
        order.clear();
        for (k, split) in found.iter().enumerate() {
            // Not a finalist: no need to look at the second child.
            let bar = if k < FINALISTS { f64::INFINITY } else { third(&order) };
            let glance = self.both(&contour, split, GLANCE_BASE, bar, &mut |r, child, _| r.glance(child));
            order.push((glance, k as u32));
        }
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<(f64, Split)> = None;
        for &(_, k) in order.iter().take(FINALISTS) {
            let split = &found[k as usize];
            let bar = best.map_or(f64::INFINITY, |b| b.0);
            let mut forecast = [Forecast::Unknown; 2];
            let score = self.both(&contour, split, 0.0, bar, &mut |r, child, side| {
                let (score, f) = r.outlook(child);
                forecast[side] = f;
                score
            });
            if score < bar {
                best = Some((score, *split));
                self.forecast = forecast;
            }
        }
        (self.splitter.found, self.view.node, self.order) = (found, contour, order);
        best.map(|b| b.1)
    }

    /// Φ of a split and what `judge` thinks of its children (left 0, right 1), by their share of nodes. `judge` thinks no
    /// better than `least` of a child of more than four nodes: as soon as the sum must reach `bar`, no more is judged.
    fn both(
        &mut self,
        contour: &[u32],
        split: &Split,
        least: f64,
        bar: f64,
        judge: &mut dyn FnMut(&mut Self, &[u32], usize) -> f64,
    ) -> f64 {
        let total = (contour.len() + 2 * split.segments) as f64;
        let n_left = split.k - split.j + split.segments;
        let n_right = contour.len() - (split.k - split.j) + split.segments;
        let share = [n_left, n_right].map(|n| n as f64 / total);
        let base = [n_left, n_right].map(|n| if n > 4 { least * n as f64 / total } else { 0.0 });
        // What is known, and what the children that are not judged yet will add at least.
        let (mut score, mut rest) = (split.phi, base[0] + base[1]);
        if score + rest >= bar {
            return score + rest;
        }
        let mark = self.nodes.points.len();
        let (mut line, mut child) = (std::mem::take(&mut self.line), std::mem::take(&mut self.child));
        place(&self.view, split, &mut self.nodes, self.size, &mut self.hint, &mut line);
        for (side, share) in share.into_iter().enumerate() {
            if score + rest >= bar {
                break;
            }
            child.clear();
            if side == 0 {
                left_child(contour, split, &line, &mut child);
            } else {
                right_child(contour, split, &line, &mut child);
            }
            debug_assert_eq!(child.len(), if side == 0 { n_left } else { n_right }, "the line has two sides");
            score += share * judge(self, &child, side);
            rest = if side == 0 { base[1] } else { 0.0 };
        }
        self.nodes.truncate(mark);
        (self.line, self.child) = (line, child);
        score + rest
    }

    /// A guess of [`Self::outlook`].
    fn glance(&mut self, contour: &[u32]) -> f64 {
        if contour.len() == 4 {
            return self.single_quad(contour);
        }
        self.load_scratch(contour);
        let task = RegionTask { contour: &self.scratch, size: self.size, tolerance: self.tolerance };
        let least = self.companions.iter().filter_map(|c| c.glance(&task)).fold(f64::INFINITY, f64::min);
        (GLANCE_BASE + GLANCE_WEIGHT * least).min(NO_PATTERN)
    }

    /// How badly a contour of four nodes is filled by the one quad.
    fn single_quad(&self, contour: &[u32]) -> f64 {
        let q = [0, 1, 2, 3].map(|i| self.nodes.points[contour[i] as usize]);
        1.3 * (1.0 - csalf_mesh::quality::scaled_jacobian::value(&q))
    }

    /// How badly a child is expected to be filled: 0 perfect, [`NO_PATTERN`] if no companion takes it; and by whom.
    fn outlook(&mut self, contour: &[u32]) -> (f64, Forecast) {
        if contour.len() == 4 {
            return (self.single_quad(contour), Forecast::Unknown);
        }
        self.load_scratch(contour);
        let task = RegionTask { contour: &self.scratch, size: self.size, tolerance: self.tolerance };
        let score =
            |a: Appraisal| 3.0 * ((1.0 - a.mean_sj) + 0.3 * (1.0 - a.min_sj) + 0.02 * a.n_irregular as f64);
        let mut best = (NO_PATTERN, Forecast::Nobody);
        // The first that does not refuse will fill it.
        for (k, c) in self.companions.iter().enumerate() {
            if let Some((appraisal, recipe)) = c.foresee(&task) {
                best = (score(appraisal).min(NO_PATTERN), Forecast::By(k, recipe));
                break;
            }
        }
        best
    }

    fn split_once(&mut self) {
        let contour = std::mem::take(&mut self.stack);
        self.frames.clear();
        if self.split(&contour) {
            let right = self.stack[..self.frames[1].start].to_vec();
            let left = self.stack[self.frames[1].start..].to_vec();
            self.children.extend([left, right]);
        } else {
            self.fall_back(&contour);
        }
    }

    /// Step 5.
    fn fall_back(&mut self, contour: &[u32]) {
        self.load_scratch(contour);
        tracing::debug!(n_nodes = contour.len(), at = ?self.scratch.points[0], "guaranteed fallback");
        match crate::fallback::fill(&self.scratch, self.tolerance) {
            Ok(patch) => self.take(contour, &patch),
            // Only a contour that is not valid can end here; the caller decides what that means.
            Err(_) => self.children.push(contour.to_vec()),
        }
    }

    /// Local names for everything.
    fn into_patch(self) -> Patch {
        let n_named = self.names.len() as u32;
        let name = |v: u32| if v < n_named { self.names[v as usize] } else { self.n_ring + v - n_named };
        Patch {
            quads: self.quads.iter().map(|q| q.map(name)).collect(),
            children: self.children.iter().map(|c| c.iter().map(|&v| name(v)).collect()).collect(),
            points: self.nodes.points[n_named as usize..].to_vec(),
            n_fallbacks: self.tally.fallbacks,
        }
    }
}

/// The [`FINALISTS`]-th smallest of the glances.
fn third(glances: &[(f64, u32)]) -> f64 {
    let mut least = [f64::INFINITY; FINALISTS];
    for &(mut g, _) in glances {
        for l in &mut least {
            if g < *l {
                std::mem::swap(&mut g, l);
            }
        }
    }
    least[FINALISTS - 1]
}

fn load(into: &mut Contour, contour: &[u32], nodes: &Nodes) {
    into.points.clear();
    into.ids.clear();
    into.sizes.clear();
    into.flags.clear();
    into.points.extend(contour.iter().map(|&v| nodes.points[v as usize]));
    into.ids.extend_from_slice(contour);
    into.sizes.extend(contour.iter().map(|&v| nodes.sizes[v as usize]));
    into.flags.extend(contour.iter().map(|&v| nodes.flags[v as usize]));
}

/// C_L = j .. k and the line backwards.
fn left_child(contour: &[u32], split: &Split, line: &[u32], into: &mut Vec<u32>) {
    into.extend_from_slice(&contour[split.j..=split.k]);
    into.extend(line.iter().rev());
}

/// C_R = k .. j and the line forwards.
fn right_child(contour: &[u32], split: &Split, line: &[u32], into: &mut Vec<u32>) {
    into.extend_from_slice(&contour[split.k..]);
    into.extend_from_slice(&contour[..=split.j]);
    into.extend_from_slice(line);
}

#[cfg(test)]
mod tests;
