//! Wanted sizes and layers for a finished domain.

use super::{Draft, Recipe};
use crate::Rng;
use csalf_core::{Job, Options};
use csalf_geom::arrangement::{Arrangement, CheckOptions};
use csalf_geom::polygon::{Side, bounds, locate};
use csalf_geom::{Domain, Point2};
use csalf_pave::{LayerLaw, LayerSpec};
use csalf_sizemap::{Extras, Hint, SizeSpec, Source};

/// Adds sizes and layers; `None` if they would ask for too many quads.
pub(super) fn finish(
    draft: Draft,
    rng: &mut Rng,
    recipe: &Recipe,
    most_quads: f64,
) -> Option<(Job, Options)> {
    let Draft { domain, h, nasty } = draft;
    let size = spec(&domain, h, nasty, rng);
    let gradation = rng.chance(0.3).then(|| rng.log(0.05, 1.0));
    let layers = if recipe.layers { layers(h, rng) } else { Vec::new() };
    let mut job = Job { domain, size, layers, ..Job::default() };
    let mut options = Options { gradation, ..Options::default() };
    // Coarser sizes before giving up; hard points' own sizes and gradation go first.
    for step in 0..4 {
        if expected_quads(&job, &options, rng)? <= most_quads {
            return Some((job, options));
        }
        match step {
            0 => {
                options.gradation = None;
                job.domain.points.iter_mut().for_each(|p| p.size = None);
            }
            1 => job.size = SizeSpec::Boundary,
            _ => job.size = SizeSpec::Uniform { h: h * rng.real(1.0, 4.0) },
        }
    }
    None
}

fn spec(domain: &Domain, h: f64, nasty: bool, rng: &mut Rng) -> SizeSpec {
    let Some((lo, hi)) = bounds(domain.loops.iter().flat_map(|l| l.nodes.iter().copied())) else {
        return SizeSpec::Boundary;
    };
    let anywhere = |rng: &mut Rng| Point2::new(rng.real(lo.x, hi.x), rng.real(lo.y, hi.y));
    match rng.int(0, 19) {
        0..=11 => SizeSpec::Boundary,
        12..=14 => SizeSpec::Uniform { h: h * rng.log(0.3, 5.0) },
        15..=18 => {
            let far = h * rng.log(0.7, 4.0);
            let least = if nasty { 0.003 } else { 0.1 };
            let sources = (0..if rng.chance(0.8) { rng.int(1, 4) } else { 20 }).map(|_| {
                let h = far * rng.log(least, 1.2);
                let slope = rng.log(0.1, if nasty { 5.0 } else { 0.5 });
                let falloff = (far - h).abs().max(0.1 * far) / slope;
                Source { xy: anywhere(rng), h, radius: h * rng.real(0.0, 12.0), falloff }
            });
            SizeSpec::Sources { far, sources: sources.collect() }
        }
        _ => {
            let wide = 0.01 * (hi - lo);
            let (lo, hi) = (lo - wide, hi + wide);
            let points = [(lo.x, lo.y), (hi.x, lo.y), (hi.x, hi.y), (lo.x, hi.y)].map(Point2::from).to_vec();
            let values = points.iter().map(|_| h * rng.log(0.3, 3.0)).collect();
            SizeSpec::Background { points, triangles: vec![[0, 1, 2], [0, 2, 3]], values }
        }
    }
}

fn layers(h: f64, rng: &mut Rng) -> Vec<(String, LayerSpec)> {
    let patterns = ["*", "outer", "hole*", "hole0", "scar*", "scar0", "hole1", "point*"];
    let n = rng.int(1, 3);
    (0..n)
        .map(|_| {
            let count = rng.int(0, 6);
            let law = match rng.int(0, 6) {
                0 => LayerLaw::Auto,
                1 => LayerLaw::Constant,
                2 => LayerLaw::Ramp,
                3 => LayerLaw::Parabolic,
                4 => LayerLaw::Fibonacci,
                5 => LayerLaw::Geometric(rng.real(0.7, 2.0)),
                _ => LayerLaw::Explicit((0..count.max(1)).map(|_| h * rng.log(0.05, 1.5)).collect()),
            };
            let first = rng.chance(0.5).then(|| h * rng.log(0.02, 1.5));
            ((*rng.pick(&patterns)).to_owned(), LayerSpec { count, law, first })
        })
        .collect()
}

/// How many quads the sizes ask for, by random points; `None` if no field can be built.
fn expected_quads(job: &Job, options: &Options, rng: &mut Rng) -> Option<f64> {
    const SAMPLES: usize = 1500;
    let a = Arrangement::new(&job.domain, &CheckOptions::default()).ok()?;
    let loops: Vec<Vec<Point2>> = job.domain.loops.iter().map(|l| l.nodes.clone()).collect();
    let hard: Vec<_> = job.domain.points.iter().filter_map(|p| p.size.map(|h| (p.xy, h))).collect();
    let extras = Extras { hard_points: &hard, gradation: options.gradation };
    let field = csalf_sizemap::build(&job.size, &loops, &extras, a.tolerance).ok()?;
    let (lo, hi) = bounds(loops.iter().flatten().copied())?;
    let mut hint = Hint::default();
    let mut sum = 0.0;
    for _ in 0..SAMPLES {
        let p = Point2::new(rng.real(lo.x, hi.x), rng.real(lo.y, hi.y));
        let n_around = loops.iter().filter(|l| locate(l, p) == Side::Inside).count();
        // Inside the outer loop alone: not in a hole.
        if n_around == 1 {
            sum += field.h(p, &mut hint).powi(-2);
        }
    }
    let box_area = (hi.x - lo.x) * (hi.y - lo.y);
    let rim: usize = loops.iter().map(Vec::len).sum();
    Some(sum * box_area / SAMPLES as f64 + rim as f64)
}
