//! Algorithm I: layers around all loops of a region, one ring per loop and cycle, until they meet.
//!
//! ```text
//!   cycle:   holes by perimeter ──▶ scars and points ──▶ outer loop
//!   ring:    build aside ──▶ tests ──▶ commit whole, or drop and try thinner, then in part, then stop the loop
//! ```
//!
//! 1. [`wanted_layers`] decides how many layers each loop gets: as asked, or by its kind (handbook 3.3).
//! 2. Every cycle builds a ring for each loop that still wants one, aside (`build`).
//! 3. All fronts and proposed rings go into one index; the rings are tested in order, each against what stands by
//!    then, and committed. Inner loops come first, the outer loop last (paper, Algorithm I).
//! 4. Rings by rule are as thick as the room for all wanted rings allows. One that fails is tried again: as if nobody
//!    wanted more than one ring, then without
//!    the stretches where it failed (handbook 2.7). If that fails too, the loop has its last front.
//!
//! Guarantees: all quads strictly convex, all fronts simple and apart from each other, by exact predicates; the
//! parity of every loop is kept. What is left over is bounded by the fronts. Cost O(n log n) per cycle.
//! Source: paper, Algorithm I and section 4.3; handbook 3.

use crate::build::{Candidate, Failure, LoopState, NEW, Order, build, build_point};
use crate::evaluate::{self, Others, Stop};
use crate::index::{Index, Segment, distance};
use crate::laws::{Thickness, thickness};
use crate::{LayerLaw, LayerSpec, PavingRules};
use csalf_geom::{Point2, Tolerance, polygon};
use csalf_sizemap::{Hint, SizeField};

/// What a walk bounds.
#[derive(Clone, Copy, PartialEq, Eq, Debug, PartialOrd, Ord)]
pub enum WalkKind {
    /// The rim of a hole, clockwise.
    Hole,
    /// A scar that touches no loop: both sides, 2e occurrences of e + 1 nodes.
    Scar,
    /// An isolated point: one occurrence.
    Point,
    /// The outer loop, counter-clockwise, with all that is attached to it.
    Outer,
}

/// One boundary of the region, material on the left.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// Node ids, one per occurrence.
    pub nodes: Vec<u32>,
    /// What it bounds.
    pub kind: WalkKind,
    /// Layers that the user asked for; `None`: by rule.
    pub asked: Option<LayerSpec>,
}

/// A region and how it is to be layered.
#[derive(Clone, Copy, Debug)]
pub struct LayerTask<'a> {
    /// Nodes of the input.
    pub points: &'a [Point2],
    /// All boundaries of the region.
    pub walks: &'a [Walk],
    /// How large the quads shall be.
    pub size: &'a dyn SizeField,
    /// Length thresholds of the run.
    pub tolerance: Tolerance,
    /// Placement formulas.
    pub rules: PavingRules,
    /// Layers by rule on loops that nobody asked for.
    pub defaults: bool,
    /// Allow rings that leave stretches of a loop uncovered.
    pub partial: bool,
}

/// What became of the layers of one walk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WalkReport {
    /// Layers asked for, by the user or by rule.
    pub asked: usize,
    /// Layers made in full: all around, and as thick as asked to 2 %.
    pub made: usize,
    /// Further layers made in part or thinner.
    pub reduced: usize,
    /// Why there are not more, if there are fewer than asked.
    pub stopped: Option<Stop>,
    /// Largest relative thickness error of the layers made in full.
    pub thickness_error: f64,
}

/// All layers of a region.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// New points; their ids follow those of the input.
    pub points: Vec<Point2>,
    /// Quads: ids of the input's nodes, then of the new ones.
    pub quads: Vec<[u32; 4]>,
    /// Per quad: the walk and the number of the layer, from 0.
    pub quad_layer: Vec<(u32, u32)>,
    /// What is left to be meshed, one front per walk in the same order, material on the left.
    pub fronts: Vec<Vec<u32>>,
    /// Per walk.
    pub reports: Vec<WalkReport>,
    /// Nodes of the last rings, ascending, and the mean length of the front there: what the size field
    /// should know before the rest is meshed.
    pub ring_sizes: Vec<(u32, f64)>,
}

/// A walk on its way inward.
struct Path<'a> {
    state: LoopState,
    kind: WalkKind,
    spec: LayerSpec,
    user: bool,
    /// Mean segment length of the walk.
    mean: f64,
    /// Wanted length where its last layer will end.
    end: f64,
    done: usize,
    active: bool,
    /// Further rings are welcome where they follow the size field.
    more: bool,
    index: u32,
    report: WalkReport,
    /// Nodes of the walk itself, for point rings.
    walk: &'a Walk,
}

/// Rings by rule end where their edges would be this many wanted edges long.
const COARSEST: f64 = 1.6;
/// Rings by rule are not made thinner than this share of their edges for the sake of the size field.
const FLATTEST: f64 = 0.35;

/// Third and further rings by rule end where the edges of their front would be shorter than so many wanted edges: on a
/// plate with 320 nodes round its hole the third ring alone took the share of edges of the wanted size from 0.89 to
/// 0.78.
const FINEST: f64 = 0.7;
/// Layers that are counted to find where the last one ends.
const MOST_ASKED: usize = 1000;
/// The length of a front at a node is the mean over so many segments on each side.
const SPREAD: usize = 3;

/// Most layers by rule.
const MOST_LAYERS: usize = 16;

impl Path<'_> {
    /// Its rings are only as thick as the room between the fronts allows. Layers that the user asked for are as
    /// thick as asked, and the paper's are as they are.
    fn shares(&self, task: &LayerTask<'_>) -> bool {
        !self.user && task.rules == PavingRules::Corrected
    }

    /// Rings beyond those of the rule: round holes get more as long as they grow with the size field, an outer loop
    /// a second one where its front is far coarser than the field. Only nodes between two rings are regular for
    /// certain, and so many small quads meet such a front that its own would not be.
    fn extra(&self) -> bool {
        self.done >= self.spec.count
    }

    /// Rings that it still wants, at most `most`, as far as others have to leave room for them.
    fn wants(&self, most: usize) -> usize {
        if self.active { self.spec.count.saturating_sub(self.done).min(most) } else { 0 }
    }
}

/// Layers by rule: holes 2 (up to 3 if round and smaller than three wanted edges, see [`FINEST`]), scars 1, the outer loop 1, points none
/// (measured on a plate with twelve weld spots: 3.6 % irregular vertices against 7.8 % with a ring at each).
/// Handbook 3.3, 3.4.
pub fn wanted_layers(kind: WalkKind, points: &[Point2], far: f64) -> usize {
    match kind {
        WalkKind::Hole => {
            let (a, p) = (polygon::signed_area(points).abs(), polygon::perimeter(points));
            let round = 4.0 * std::f64::consts::PI * a > 0.9 * p * p;
            let diameter = 2.0 * (a / std::f64::consts::PI).sqrt();
            if round && diameter < 3.0 * far { 3 } else { 2 }
        }
        WalkKind::Scar | WalkKind::Outer => 1,
        // A ring of four quads prescribes a direction around the point; patches around it do better without.
        WalkKind::Point => 0,
    }
}

/// Lays rings around all walks of a region. Never fails: a walk that takes no ring keeps its nodes as front.
/// Walks must be simple and apart from each other; if they are not, rings are refused where they would meet.
pub fn pave_layers(task: &LayerTask<'_>) -> Layers {
    let mut out = Layers::default();
    let mut all = task.points.to_vec();
    let mut hint = Hint::default();
    let mut paths: Vec<Path<'_>> = task.walks.iter().enumerate().map(|(i, w)| path(task, i, w)).collect();
    let mut order: Vec<usize> = (0..paths.len()).collect();
    let rank = |p: &Path<'_>| match p.kind {
        WalkKind::Hole => 0,
        WalkKind::Scar | WalkKind::Point => 1,
        WalkKind::Outer => 1,
    };
    order.sort_by(|&i, &j| {
        let (a, b) = (&paths[i], &paths[j]);
        let length = |p: &Path<'_>| p.mean * p.state.nodes.len() as f64;
        rank(a).cmp(&rank(b)).then(length(a).total_cmp(&length(b))).then(i.cmp(&j))
    });
    while paths.iter().any(|p| p.active) {
        cycle(task, &mut paths, &order, &mut all, &mut out, &mut hint);
    }
    out.points = all.split_off(task.points.len());
    let mut sizes = Vec::new();
    for p in paths {
        let n = p.state.nodes.len();
        for k in 0..n {
            if p.state.nodes[k] as usize >= task.points.len() {
                let q = |i: usize| p.state.points[(k + n + i - SPREAD % n) % n];
                let l: f64 = (0..2 * SPREAD).map(|i| q(i).distance(q(i + 1))).sum();
                let l = l / (2 * SPREAD) as f64;
                sizes.push((p.state.nodes[k], l));
            }
        }
        out.fronts.push(p.state.nodes);
        out.reports.push(p.report);
    }
    sizes.sort_by_key(|s| s.0);
    sizes.dedup_by_key(|s| s.0);
    out.ring_sizes = sizes;
    out
}

fn path<'a>(task: &LayerTask<'_>, index: usize, walk: &'a Walk) -> Path<'a> {
    let n = walk.nodes.len();
    let sound = walk.nodes.iter().all(|&v| (v as usize) < task.points.len());
    let points: Vec<Point2> =
        walk.nodes.iter().map(|&v| task.points.get(v as usize).copied().unwrap_or_default()).collect();
    let mut hint = Hint::default();
    let mean = if n > 1 {
        polygon::perimeter(&points) / n as f64
    } else {
        points.first().map_or(1.0, |p| task.size.h(*p, &mut hint))
    };
    let user = walk.asked.is_some();
    let spec = walk.asked.clone().unwrap_or_else(|| {
        let count = if task.defaults { wanted_layers(walk.kind, &points, task.size.range().1) } else { 0 };
        LayerSpec { count, ..LayerSpec::default() }
    });
    let end = if sound { size_at_end(task, &points, &spec, mean) } else { mean };
    let usable = sound && mean.is_finite() && mean > task.tolerance.merge() && (n == 1 || n >= 4);
    Path {
        state: LoopState {
            nodes: walk.nodes.clone(),
            points,
            below: vec![0; n],
            open: vec![true; n],
            geometry: vec![true; n],
        },
        kind: walk.kind,
        more: !user
            && matches!(walk.kind, WalkKind::Hole | WalkKind::Outer)
            && task.rules == PavingRules::Corrected,
        user,
        mean,
        end,
        done: 0,
        active: spec.count > 0 && usable,
        index: index as u32,
        report: WalkReport {
            asked: spec.count,
            stopped: (spec.count > 0 && !usable).then_some(Stop::Short),
            ..WalkReport::default()
        },
        spec,
        walk,
    }
}

/// Mean wanted length where the last of the layers ends, for the law that asks for it (parabolic). How far that is
/// depends on it in turn: a few rounds from the loop itself.
fn size_at_end(task: &LayerTask<'_>, points: &[Point2], spec: &LayerSpec, mean: f64) -> f64 {
    let n = points.len();
    if spec.law != LayerLaw::Parabolic || n < 3 {
        return mean;
    }
    let mut hint = Hint::default();
    let mut at = |depth: f64| {
        let inward = |i: usize| (points[(i + 1) % n] - points[(i + n - 1) % n]).perp().normalize_or_zero();
        (0..n).map(|i| task.size.h(points[i] + inward(i) * depth, &mut hint)).sum::<f64>() / n as f64
    };
    let mut end = at(0.0);
    for _ in 0..4 {
        let layer = |i: usize| match thickness(spec, i, mean, end) {
            Thickness::Fixed(t) | Thickness::Isotropic(t) => t,
        };
        end = at((0..spec.count.min(MOST_ASKED)).map(layer).sum());
    }
    end
}

/// One ring for every loop that wants one.
fn cycle(
    task: &LayerTask<'_>,
    paths: &mut [Path<'_>],
    order: &[usize],
    all: &mut Vec<Point2>,
    out: &mut Layers,
    hint: &mut Hint,
) {
    let waits = |p: &Path<'_>| !p.user && p.kind == WalkKind::Outer && p.done > 0;
    let alone = paths.iter().all(|p| !p.active || waits(p));
    let mut tries: Vec<Try> = order
        .iter()
        .filter(|&&i| paths[i].active && (alone || !waits(&paths[i])))
        .map(|&path| Try { path, stage: Stage::Whole, banned: Vec::new(), first: None })
        .collect();
    // The first ring of a hard point looks for the nearest front, layers by rule for the room there is.
    let points = tries.iter().any(|t| {
        let p = &paths[t.path];
        p.shares(task) || (p.kind == WalkKind::Point && p.done == 0)
    });
    let mut standing = points.then(|| Index::new(&segments(paths, &[])));
    while !tries.is_empty() {
        let mut proposals: Vec<(usize, Candidate)> = Vec::new();
        let mut verdicts: Vec<Option<Failure>> = vec![None; tries.len()];
        for (k, t) in tries.iter().enumerate() {
            match propose(task, paths, t, standing.as_ref(), all, hint) {
                Ok(c) => proposals.push((k, c)),
                Err(f) => verdicts[k] = Some(f),
            }
        }
        let named: Vec<_> = proposals.iter().map(|(k, c)| (tries[*k].path as u32, c)).collect();
        let index = Index::new(&segments(paths, &named));
        let mut committed = vec![false; paths.len()];
        for (k, c) in proposals {
            let i = tries[k].path;
            let p = &mut paths[i];
            let others = Others { index: &index, own: p.index, committed: &committed, gap: corridor(p) };
            let corners = |q: usize| {
                c.quads[q].map(|v| if v >= NEW { c.points[(v - NEW) as usize] } else { all[v as usize] })
            };
            let mut verdict = evaluate::against(&c, &p.state, &others, corners);
            if verdict.is_ok() && !p.user && p.state.nodes.len() > 1 {
                verdict = evaluate::after(&p.state, &c, p.kind == WalkKind::Outer);
            }
            match verdict {
                Ok(()) => {
                    committed[i] = true;
                    commit(p, c, &tries[k], all, out);
                }
                Err(f) => verdicts[k] = Some(f),
            }
        }
        let mut again = Vec::new();
        for (mut t, verdict) in tries.into_iter().zip(verdicts) {
            let Some(failure) = verdict else { continue };
            let p = &mut paths[t.path];
            t.first.get_or_insert(failure.stop);
            tracing::debug!(walk = t.path, layer = p.done, stage = ?t.stage, stop = %failure.stop, at = ?failure.at.iter().take(6).map(|&i| p.state.points[i as usize]).collect::<Vec<_>>(), "ring refused");
            if p.extra() {
                p.active = false;
                continue;
            }
            match t.stage.after(&failure, p, task.partial, &mut t.banned) {
                Some(stage) => again.push(Try { stage, ..t }),
                None => {
                    p.active = false;
                    p.report.stopped = t.first;
                }
            }
        }
        tries = again;
        if !tries.is_empty() {
            standing = Some(Index::new(&segments(paths, &[])));
        }
    }
}

/// How a ring is tried.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    /// As wanted.
    Whole,
    /// As if nobody wanted more than one ring.
    Last,
    /// Without the stretches that failed so far; how often already, and whether as if the last.
    Part(u8, bool),
}

/// One path of a cycle that still looks for a ring.
struct Try {
    path: usize,
    stage: Stage,
    /// Edges to be left uncovered; empty: none.
    banned: Vec<bool>,
    /// Why the first attempt failed.
    first: Option<Stop>,
}

impl Stage {
    /// Most partial attempts: each adds the stretches where the last one failed.
    const PARTS: u8 = 12;

    /// What to try after this stage failed; `None`: give up. Marks the stretches to be left out.
    fn after(self, f: &Failure, p: &Path<'_>, partial: bool, banned: &mut Vec<bool>) -> Option<Self> {
        let n = p.state.nodes.len();
        let hopeless =
            matches!(f.stop, Stop::Short | Stop::UnevenFronts | Stop::FarFromSize | Stop::Thick | Stop::Fine);
        if n < 4 || hopeless {
            return None;
        }
        banned.resize(n, false);
        let capped = self == Self::Last && !f.at.is_empty();
        if capped {
            // Most of what failed at first does not when others want less.
            banned.fill(false);
        }
        for &i in &f.at {
            let i = i as usize;
            for k in [i + n - 2, i + n - 1, i, i + 1] {
                banned[k % n] = true;
            }
        }
        let next = match self {
            Self::Whole if !p.user => return Some(Self::Last),
            Self::Whole | Self::Last => Self::Part(1, capped),
            Self::Part(..) if f.stop == Stop::LittleLeft => return None,
            Self::Part(k, capped) => Self::Part(k + 1, capped),
        };
        // A second layer that nobody asked for is not worth a ragged end.
        let worth = p.user || p.done == 0;
        let known = banned.contains(&true) && !matches!(next, Self::Part(k, _) if k > Self::PARTS);
        (partial && n >= 12 && worth && known).then_some(next)
    }
}

/// Builds the next ring of a path, or says why there is none.
fn propose(
    task: &LayerTask<'_>,
    paths: &[Path<'_>],
    attempt: &Try,
    index: Option<&Index>,
    all: &[Point2],
    hint: &mut Hint,
) -> Result<Candidate, Failure> {
    let p = &paths[attempt.path];
    let t = thickness(&p.spec, p.done, p.mean, p.end);
    if p.walk.kind == WalkKind::Point && p.done == 0 {
        let (Some(&id), Some(&at)) = (p.state.nodes.first(), p.state.points.first()) else {
            return Err(Stop::Short.into());
        };
        let t = match t {
            Thickness::Fixed(t) => t,
            Thickness::Isotropic(f) => f * p.mean,
        };
        return Ok(build_point(id, at, t, tangent(at, t, p.index, index)));
    }
    if !p.user {
        evaluate::before(&p.state, task.size, task.rules, hint)?;
        let ratio = coarseness(&p.state.points, task, hint);
        let most = if p.done < 2 { 2.2 } else { 1.4 };
        let follows = match p.kind {
            WalkKind::Outer => ratio > 1.3,
            _ => ratio <= 1.2,
        };
        if p.extra() && !follows || p.done > 0 && ratio > most {
            return Err(Stop::Thick.into());
        }
    }
    let last = matches!(attempt.stage, Stage::Last | Stage::Part(_, true));
    let caps = match index {
        Some(index) if p.shares(task) => {
            let mut caps = room(p, paths, index, if last { 1 } else { 2 });
            fall(p, task, &mut caps, hint);
            Some(caps)
        }
        _ => None,
    };
    let order = Order {
        thickness: t,
        user: p.user,
        whole: p.extra() && p.kind == WalkKind::Hole,
        rules: task.rules,
        field: task.size,
        caps: caps.as_deref(),
        banned: matches!(attempt.stage, Stage::Part(..)).then_some(&attempt.banned),
    };
    let ring = build(&p.state, &order, all)?;
    // Beyond the second, the front of a ring by rule still follows the size field.
    let by_rule = p.shares(task) && p.kind == WalkKind::Hole && p.done >= 2;
    if by_rule && coarseness(&ring.next.points, task, hint) < FINEST {
        return Err(Stop::Fine.into());
    }
    Ok(ring)
}

/// Lowers `caps` where the wanted size falls fast from the front inward: rings, whose edges stay as long as those of
/// the loop, end where they would be longer than [`COARSEST`] wanted edges, and share the way there. They are
/// never made thinner than [`FLATTEST`] of their edges.
fn fall(p: &Path<'_>, task: &LayerTask<'_>, caps: &mut [f64], hint: &mut Hint) {
    let n = p.state.nodes.len();
    let q = &p.state.points;
    let rings = if p.kind == WalkKind::Outer { 2 } else { p.spec.count };
    let rings = rings.saturating_sub(p.done).clamp(1, 2) as f64;
    for i in 0..n {
        let (a, b, c) = (q[if i == 0 { n - 1 } else { i - 1 }], q[i], q[if i + 1 == n { 0 } else { i + 1 }]);
        let s = 0.5 * (b.distance(c) + b.distance(a));
        let inward = (c - a).perp().normalize_or_zero();
        let mut way = rings * s;
        for k in 1..=4 {
            let d = 0.25 * rings * s * f64::from(k);
            if COARSEST * task.size.h(b + inward * d, hint) < s {
                way = d - 0.125 * rings * s;
                break;
            }
        }
        if way < rings * s {
            caps[i] = caps[i].min((way / rings).max(FLATTEST * s));
        }
    }
}

/// Mean length of the fronts in wanted edges. Layers by rule stop above 1.4 (the second above 2.2),
/// further ones above 1.2, and from the
/// third on where their own front would be below [`FINEST`] (handbook 3.4).
fn coarseness(q: &[Point2], task: &LayerTask<'_>, hint: &mut Hint) -> f64 {
    let n = q.len();
    let sum: f64 = (0..n).map(|i| q[i].distance(q[(i + 1) % n]) / task.size.h(q[i], hint)).sum();
    sum / n as f64
}

/// Direction of the nearest front, for the first ray at a hard point; the x axis if there is none near.
fn tangent(p: Point2, t: f64, own: u32, index: Option<&Index>) -> Point2 {
    let Some(index) = index else { return Point2::X };
    let mut reach = 2.0 * t;
    for _ in 0..24 {
        let mut best = (f64::INFINITY, Point2::X);
        index.query(p - reach, p + reach, |s| {
            let d = distance(p, s.a, s.b);
            if s.owner != own && s.a != s.b && d < best.0 && d <= reach {
                best = (d, (s.b - s.a).normalize_or(Point2::X));
            }
        });
        if best.0.is_finite() {
            return best.1;
        }
        reach *= 2.0;
    }
    Point2::X
}

/// Gap that must remain to other fronts, in lengths of the fronts: asked layers take what they are given.
fn corridor(p: &Path<'_>) -> f64 {
    match (p.user, p.extra() && p.kind == WalkKind::Hole) {
        (true, _) => 0.5,
        (false, false) => 0.75,
        (false, true) => 2.0,
    }
}

/// Medial caps: what lies between a node and the nearest other front (or another stretch of its own), less the
/// corridor that must remain, shared among all rings that are still wanted there in proportion to the lengths of
/// the fronts (handbook 2.3).
fn room(p: &Path<'_>, paths: &[Path<'_>], index: &Index, most: usize) -> Vec<f64> {
    let n = p.state.nodes.len();
    let q = &p.state.points;
    let mine = p.wants(most).max(1) as f64;
    let mut along = vec![0.0; n + 1];
    for i in 0..n {
        along[i + 1] = along[i] + q[i].distance(q[if i + 1 == n { 0 } else { i + 1 }]);
    }
    let around = along[n];
    (0..n)
        .map(|i| {
            let (a, b, c) =
                (q[if i == 0 { n - 1 } else { i - 1 }], q[i], q[if i + 1 == n { 0 } else { i + 1 }]);
            let s = 0.5 * (b.distance(c) + b.distance(a));
            let inward = (c - a).perp();
            let reach = 1.5 * (mine + 3.0) * s;
            let mut cap = f64::INFINITY;
            index.query(b - reach, b + reach, |f| {
                let other = &paths[f.owner as usize];
                let length = s.min(f.a.distance(f.b));
                let d = distance(b, f.a, f.b);
                if f.owner == p.index {
                    // Another stretch of this loop counts if it is farther along the loop than across, and ahead.
                    let j = f.at as usize;
                    let way = (along[i] - along[j]).abs();
                    let way = way.min(around - way);
                    let ahead = (f.a.midpoint(f.b) - b).dot(inward);
                    let here = f.a == b || f.b == b; // the other side of a scar
                    if here || way < 3.0 * d + 2.0 * s || ahead < 0.5 * inward.length() * d {
                        return;
                    }
                }
                let keep = 1.1 * corridor(p) * 0.5 * (s + length);
                let theirs = other.wants(most) as f64 * length;
                cap = cap.min(s / (s * mine + theirs) * (d - keep));
            });
            cap.max(0.0)
        })
        .collect()
}

/// All standing fronts and all proposed rings.
fn segments(paths: &[Path<'_>], proposals: &[(u32, &Candidate)]) -> Vec<Segment> {
    let total = paths.iter().map(|p| p.state.nodes.len()).sum::<usize>()
        + proposals.iter().map(|c| c.1.next.nodes.len()).sum::<usize>();
    let mut out = Vec::with_capacity(total);
    let mut add = |points: &[Point2], owner: u32, proposed: bool| {
        let n = points.len();
        for i in 0..n {
            let (a, b) = (points[i], points[if i + 1 == n { 0 } else { i + 1 }]);
            out.push(Segment { a, b, owner, at: i as u32, proposed });
        }
    };
    for p in paths {
        add(&p.state.points, p.index, false);
    }
    for (i, c) in proposals {
        add(&c.next.points, *i, true);
    }
    out
}

fn commit(p: &mut Path<'_>, c: Candidate, made_by: &Try, all: &mut Vec<Point2>, out: &mut Layers) {
    let base = all.len() as u32;
    let id = |v: u32| if v >= NEW { base + (v - NEW) } else { v };
    all.extend_from_slice(&c.points);
    out.quads.extend(c.quads.iter().map(|q| q.map(id)));
    out.quad_layer.extend(c.quads.iter().map(|_| (p.index, p.done as u32)));
    p.state = c.next;
    for v in &mut p.state.nodes {
        *v = id(*v);
    }
    let exact = !matches!(thickness(&p.spec, p.done, p.mean, p.mean), Thickness::Fixed(_))
        || c.thickness_error <= 0.02;
    if c.full && exact && made_by.stage == Stage::Whole {
        p.report.made += 1;
        if p.user {
            p.report.thickness_error = p.report.thickness_error.max(c.thickness_error);
        }
    } else {
        p.report.reduced += 1;
        p.report.stopped.get_or_insert(made_by.first.unwrap_or(Stop::Reduced));
    }
    p.done += 1;
    let most = if p.kind == WalkKind::Outer { 2 } else { MOST_LAYERS };
    p.active = p.done < p.spec.count || (p.more && p.report.reduced == 0 && p.done < most);
}

#[cfg(test)]
mod tests;
