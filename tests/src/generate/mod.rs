//! Random valid jobs from a seed.
//!
//! ```text
//!   seed ─▶ outline ─▶ nodes ─▶ holes ─▶ scars ─▶ points ─▶ even total ─▶ turned, moved, scaled ─▶ sizes, layers
//!             └──────────┴─────────┴────────┴───────┴── each step is kept only if `Domain::check` accepts it
//! ```
//!
//! Guarantees: the domain is valid by `Domain::check`; the expected number of quads is below the recipe's limit; the
//! same seed and recipe give the same job.

pub mod add;
pub mod outline;
pub mod sample;
mod sizes;

use crate::Rng;
use csalf_core::{Job, Options};
use csalf_geom::{Domain, Point2};
use outline::{Outline, SHAPES, Shape};
use sample::{Spacing, sample};

/// What kind of jobs to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Always or never nasty; `None`: half of them.
    pub nasty: Option<bool>,
    /// Ask for 0 to 6 layers of random laws.
    pub layers: bool,
    /// Most nodes on all loops.
    pub most_nodes: usize,
    /// Most quads that the sizes may ask for.
    pub most_quads: f64,
}

impl Default for Recipe {
    fn default() -> Self {
        Self { nasty: None, layers: false, most_nodes: 3000, most_quads: 30_000.0 }
    }
}

/// The job of a seed, and options that belong to it (gradation).
pub fn job(seed: u64, recipe: &Recipe) -> (Job, Options) {
    // Rarely more than a few attempts; the last resort is a plain square.
    for attempt in 0..200 {
        let mut rng = Rng::new(seed ^ (attempt << 48));
        if let Some(found) = attempt_at(&mut rng, recipe) {
            return finish(found, seed);
        }
    }
    let square = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(Point2::from).to_vec();
    finish((Job { domain: Domain::new(square), ..Job::default() }, Options::default()), seed)
}

fn finish((mut job, options): (Job, Options), seed: u64) -> (Job, Options) {
    job.name = format!("seed{seed}");
    job.about = format!("random job of seed {seed}");
    (job, options)
}

/// What the steps share.
#[derive(Debug)]
pub struct Draft {
    /// What there is so far.
    pub domain: Domain,
    /// Base segment length.
    pub h: f64,
    /// Gaps, angles and ratios at their worst.
    pub nasty: bool,
}

impl Draft {
    /// Applies `change`; takes it back if the domain is then invalid (an odd total aside). True if it was kept.
    pub fn keep_if_valid(&mut self, change: impl FnOnce(&mut Domain)) -> bool {
        let before = self.domain.clone();
        change(&mut self.domain);
        let ok = is_sound(&self.domain);
        if !ok {
            self.domain = before;
        }
        ok
    }

    /// Segments of all loops together.
    pub fn n_nodes(&self) -> usize {
        self.domain.loops.iter().map(|l| l.nodes.len()).sum()
    }
}

/// True if nothing is wrong but an odd total.
fn is_sound(domain: &Domain) -> bool {
    domain.check().iter().all(|d| matches!(d, csalf_geom::Defect::OddTotal { .. }))
}

fn attempt_at(rng: &mut Rng, recipe: &Recipe) -> Option<(Job, Options)> {
    let nasty = recipe.nasty.unwrap_or_else(|| rng.chance(0.5));
    let most_quads = match rng.int(0, 19) {
        0..=13 => 2000.0,
        14..=18 => 8000.0,
        _ => recipe.most_quads,
    }
    .min(recipe.most_quads);
    let mut draft = outer(rng, nasty, recipe.most_nodes)?;
    let room = recipe.most_nodes - draft.n_nodes();
    if rng.chance(0.7) {
        add::holes(&mut draft, rng, room);
    }
    if rng.chance(0.4) {
        add::scars(&mut draft, rng);
    }
    if rng.chance(0.35) {
        add::points(&mut draft, rng);
    }
    make_even(&mut draft, rng)?;
    shuffle(&mut draft.domain, rng);
    place(&mut draft, rng);
    if !draft.domain.check().is_empty() {
        return None;
    }
    sizes::finish(draft, rng, recipe, most_quads)
}

/// The outer loop, discretised.
fn outer(rng: &mut Rng, nasty: bool, most: usize) -> Option<Draft> {
    let shape = *rng.pick(&SHAPES);
    let mut outline = Outline::random(shape, rng, nasty);
    for _ in 0..if nasty && shape != Shape::Coast { rng.int(0, 2) } else { 0 } {
        outline = outline.with_needle(rng);
    }
    let wanted = match rng.int(0, 9) {
        0..=1 => rng.log(8.0, 20.0),
        2..=7 => rng.log(16.0, 200.0),
        _ => rng.log(100.0, most as f64),
    };
    let h = csalf_geom::polygon::perimeter(&outline.points) / wanted;
    let ratio = if rng.chance(0.4) { 1.0 } else { rng.log(1.0, if nasty { 1000.0 } else { 30.0 }) };
    let spacing = Spacing::random(rng, ratio);
    let nodes = sample(&outline, h, &spacing, most, rng)?;
    let draft = Draft { domain: Domain::new(nodes), h, nasty };
    is_sound(&draft.domain).then_some(draft)
}

/// Adds one node to the longest segment of a random loop if the total is odd.
fn make_even(draft: &mut Draft, rng: &mut Rng) -> Option<()> {
    for _ in 0..8 {
        if draft.n_nodes().is_multiple_of(2) {
            return Some(());
        }
        let k = rng.int(0, draft.domain.loops.len() - 1);
        draft.keep_if_valid(|d| {
            let nodes = &mut d.loops[k].nodes;
            let n = nodes.len();
            let length = |i: usize| nodes[i].distance(nodes[(i + 1) % n]);
            let i = (0..n).max_by(|&i, &j| length(i).total_cmp(&length(j))).unwrap_or(0);
            nodes.insert(i + 1, nodes[i].midpoint(nodes[(i + 1) % n]));
        });
    }
    None
}

/// Random start nodes and orientations, random order of loops.
fn shuffle(domain: &mut Domain, rng: &mut Rng) {
    for l in &mut domain.loops {
        let n = l.nodes.len();
        l.nodes.rotate_left(rng.int(0, n - 1));
        if rng.chance(0.3) {
            l.nodes.reverse();
        }
    }
    for s in &mut domain.scars {
        if rng.chance(0.3) {
            s.nodes.reverse();
        }
    }
    if rng.chance(0.2) {
        let n = domain.loops.len();
        domain.loops.rotate_left(rng.int(0, n - 1));
    }
}

/// Turns, moves and scales everything.
fn place(draft: &mut Draft, rng: &mut Rng) {
    let angle = if rng.chance(0.3) { 0.0 } else { rng.angle() };
    let scale = if rng.chance(0.5) { 1.0 } else { rng.log(1e-6, 1e6) };
    let far = if rng.chance(0.5) { 0.0 } else { rng.log(1.0, if draft.nasty { 1e4 } else { 10.0 }) };
    let shift = Point2::new(rng.real(-far, far), rng.real(-far, far));
    let turn = Point2::from_angle(angle);
    let map = |p: &mut Point2| *p = scale * (if angle == 0.0 { *p } else { turn.rotate(*p) } + shift);
    draft.h *= scale;
    draft.domain.loops.iter_mut().for_each(|l| l.nodes.iter_mut().for_each(map));
    draft.domain.scars.iter_mut().for_each(|s| s.nodes.iter_mut().for_each(map));
    draft.domain.points.iter_mut().for_each(|p| {
        map(&mut p.xy);
        p.size = p.size.map(|s| s * scale);
    });
}
