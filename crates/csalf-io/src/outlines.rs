//! From what a reader gives to jobs that can be meshed.
//!
//! | the input gives | without options | with `--size H` | with `--resample` |
//! |---|---|---|---|
//! | nodes (jobs, GeoJSON, ...) | its nodes | its nodes, quads of size H between them | new nodes on the lines |
//! | curves (DXF, SVG) | a size from the extent | nodes H apart | as without |
//!
//! One outline that cannot be given nodes does not lose the others.

use crate::{Input, NamedGeometry};
use csalf_core::Job;
use csalf_geom::curve::Curve;
use csalf_geom::geometry::{CurveLoop, CurveScar, Edge};
use csalf_geom::{Domain, Geometry, GeometryDefect, Point2, Tolerance};
use csalf_sizemap::{
    CurvatureLimit, DiscretizeOptions, Extras, SizeError, SizeField, SizeSpec, Uniform, build, discretize,
};
use std::sync::Arc;

/// Edges along the diagonal of an outline that is given no size. *Arbitrary*: a first mesh of about a thousand
/// quads, fine enough to look at and made at once.
const EDGES_PER_DIAGONAL: f64 = 40.0;

/// Largest turn along one segment of a bend where no size is given, radians: 16 segments on a full circle. Larger:
/// small holes look like nuts; smaller: quads that nobody asked for. *Arbitrary.*
const TURN: f64 = std::f64::consts::FRAC_PI_8;

/// Bends never get segments shorter than this part of the default size. Keeps a fillet of no importance from
/// taking most of the quads. *Arbitrary.*
const SHORTEST: f64 = 0.05;

/// What the caller asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wish {
    /// Wanted length everywhere, > 0.
    pub size: Option<f64>,
    /// Place new nodes on lines whose nodes are given.
    pub resample: bool,
}

/// One outline: its name, and the job or what is wrong with its curves.
#[derive(Debug)]
pub struct Outline {
    /// Name of the outline; the stem of the file (and a number) where it has none.
    pub name: String,
    /// The job, or the defects in words.
    pub job: Result<Job, Vec<String>>,
    /// The curves that the nodes were placed on, where there were any.
    pub geometry: Option<Geometry>,
}

/// Jobs of all outlines of an input. What was decided for the caller is added to `notes`.
pub fn jobs(input: Input, stem: &str, wish: Wish, notes: &mut Vec<String>) -> Vec<Outline> {
    let mut sizes = DefaultSizes::default();
    let mut out: Vec<Outline> = match input {
        Input::Jobs(jobs) => jobs.into_iter().map(|job| of_job(job, wish, &mut sizes)).collect(),
        Input::Curves(list) => {
            let job = |g: NamedGeometry| {
                let blank = Job { name: g.name, ..Job::default() };
                discretized(&g.geometry, blank, wish, &mut sizes)
            };
            list.into_iter().map(job).collect()
        }
    };
    let n = out.len();
    for (k, o) in out.iter_mut().enumerate().filter(|(_, o)| o.name.is_empty()) {
        o.name = if n == 1 { stem.to_owned() } else { format!("{stem}{k}") };
        if let Ok(job) = &mut o.job {
            job.name.clone_from(&o.name);
        }
    }
    notes.extend(sizes.note());
    out
}

/// Nodes as given, or with `--resample` anew.
fn of_job(mut job: Job, wish: Wish, sizes: &mut DefaultSizes) -> Outline {
    if wish.resample {
        let geometry = curves_of(&job);
        return discretized(&geometry, job, wish, sizes);
    }
    if let Some(h) = wish.size {
        job.size = SizeSpec::Uniform { h };
    }
    Outline { name: job.name.clone(), job: Ok(job), geometry: None }
}

/// The lines of a job without their nodes; corners stay.
pub fn curves_of(job: &Job) -> Geometry {
    let line = |points: Vec<Point2>| vec![Edge::from(Curve::Polyline(points))];
    let d = &job.domain;
    let loops = d.loops.iter().map(|l| {
        let closed = l.nodes.iter().chain(l.nodes.first()).copied().collect();
        CurveLoop { kind: l.kind, name: l.name.clone(), edges: line(closed) }
    });
    let scars = d.scars.iter().map(|s| CurveScar { name: s.name.clone(), edges: line(s.nodes.clone()) });
    Geometry { loops: loops.collect(), scars: scars.collect(), points: d.points.clone() }
}

/// The job of a geometry, all but its domain taken from `job`.
fn discretized(geometry: &Geometry, mut job: Job, wish: Wish, sizes: &mut DefaultSizes) -> Outline {
    let name = job.name.clone();
    if let Some(h) = wish.size {
        job.size = SizeSpec::Uniform { h };
    }
    let loops: Vec<Vec<Point2>> = job.domain.loops.iter().map(|l| l.nodes.clone()).collect();
    match place(geometry, &job.size, &loops) {
        Err(Unplaced::Size(e)) => Outline { name, job: Err(vec![e.to_string()]), geometry: None },
        Err(Unplaced::Curves(defects)) => {
            let defects = defects.iter().map(ToString::to_string).collect();
            if let (SizeSpec::Boundary, Some(h)) = (&job.size, default_size(geometry)) {
                sizes.add(h);
            }
            Outline { name, job: Err(defects), geometry: Some(geometry.clone()) }
        }
        Ok(placed) => {
            job.domain = placed.domain;
            placed.default_size.into_iter().for_each(|h| sizes.add(h));
            Outline { name, job: Ok(job), geometry: Some(geometry.clone()) }
        }
    }
}

/// Nodes on curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// The curves, discretised.
    pub domain: Domain,
    /// The length that was chosen because none is given.
    pub default_size: Option<f64>,
}

/// Why curves got no nodes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unplaced {
    /// What is wrong with the curves.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Curves(Vec<GeometryDefect>),
    /// The wanted sizes are invalid.
    #[error("the wanted sizes are invalid: {0}")]
    Size(#[from] SizeError),
}

/// Places nodes on curves as `size` says; `loops` are the nodes given so far, from which sizes may follow. Sizes of
/// the boundary say nothing about curves: then [`default_size`] is taken, less at bends. Cost O(number of nodes).
///
/// # Errors
/// [`Unplaced`].
pub fn place(geometry: &Geometry, size: &SizeSpec, loops: &[Vec<Point2>]) -> Result<Placed, Unplaced> {
    let mut options = DiscretizeOptions::default();
    let mut chosen = None;
    let field: Arc<dyn SizeField> = match size {
        SizeSpec::Uniform { h } => Arc::new(Uniform(*h)),
        SizeSpec::Boundary => {
            chosen = default_size(geometry);
            let floor = SHORTEST * chosen.unwrap_or_default();
            if chosen.is_some() {
                options.curvature = Some(CurvatureLimit { angle: TURN, chord: f64::INFINITY, floor });
            }
            Arc::new(Uniform(chosen.unwrap_or_default()))
        }
        spec => {
            let tolerance = Tolerance::of_points(loops.iter().flatten().copied());
            build(spec, loops, &Extras::default(), tolerance)?
        }
    };
    let domain = discretize(geometry, &*field, &options).map_err(Unplaced::Curves)?;
    Ok(Placed { domain, default_size: chosen })
}

/// The length that curves are given where nothing says one: 1/40 of the diagonal. `None` of curves without extent.
pub fn default_size(geometry: &Geometry) -> Option<f64> {
    Some(geometry.diagonal() / EDGES_PER_DIAGONAL).filter(|h| *h > 0.0 && h.is_finite())
}

/// Sizes that were chosen because none was given.
#[derive(Debug, Default)]
struct DefaultSizes {
    range: Option<(f64, f64)>,
}

impl DefaultSizes {
    fn add(&mut self, h: f64) {
        let (low, high) = self.range.unwrap_or((h, h));
        self.range = Some((low.min(h), high.max(h)));
    }

    /// Tells the sizes, in one sentence for all outlines.
    fn note(&self) -> Option<String> {
        let (low, high) = self.range?;
        let size = if low == high { format!("{low:.4}") } else { format!("{low:.4} to {high:.4}") };
        let share = EDGES_PER_DIAGONAL;
        Some(format!(
            "no size given: {size} is taken (1/{share} of the extent), less at bends; --size sets it"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disk(radius: f64) -> Geometry {
        Geometry::new(vec![Curve::circle(Point2::new(5.0, 5.0), radius)])
    }

    /// A square of side 12 with a hole of radius 1 and layers round it.
    fn plate() -> Job {
        let square = [(-6.0, -6.0), (6.0, -6.0), (6.0, 6.0), (-6.0, 6.0)].map(Point2::from);
        let rim = (0..64).map(|i| Point2::from_angle(-std::f64::consts::TAU * f64::from(i) / 64.0));
        let layers = vec![("hole0".to_owned(), csalf_pave::LayerSpec { count: 3, ..Default::default() })];
        Job { domain: Domain::new(square.to_vec()).with_hole(rim.collect()), layers, ..Job::default() }
    }

    fn one(input: Input, wish: Wish) -> (Job, Vec<String>) {
        let mut notes = Vec::new();
        let mut all = jobs(input, "file", wish, &mut notes);
        assert_eq!(all.len(), 1);
        (all.remove(0).job.unwrap(), notes)
    }

    #[test]
    fn curves_get_nodes_a_size_apart() {
        let curves = || Input::Curves(vec![NamedGeometry { name: String::new(), geometry: disk(1.0) }]);
        let (job, notes) = one(curves(), Wish { size: Some(0.1), resample: false });
        assert_eq!((job.name.as_str(), job.size.clone()), ("file", SizeSpec::Uniform { h: 0.1 }));
        // 2π / 0.1 = 62.8, made even.
        assert!([62, 64].contains(&job.domain.loops[0].nodes.len()));
        assert!(notes.is_empty());
        assert!(job.domain.check().is_empty());
    }

    #[test]
    fn without_a_size_one_is_chosen_that_scales_with_the_outline() {
        let count = |r: f64| {
            let g = NamedGeometry { name: "disk".into(), geometry: disk(r) };
            let (job, notes) = one(Input::Curves(vec![g]), Wish::default());
            assert!(notes.len() == 1 && notes[0].starts_with("no size given: "), "{notes:?}");
            assert_eq!(job.size, SizeSpec::Boundary);
            job.domain.loops[0].nodes.len()
        };
        assert_eq!(count(1.0), count(1024.0));
        assert!((80..100).contains(&count(1.0)), "{}", count(1.0));
    }

    #[test]
    fn given_nodes_stay_unless_they_shall_not() {
        let job = plate();
        let (kept, _) = one(Input::Jobs(vec![job.clone()]), Wish { size: Some(0.5), resample: false });
        assert_eq!(kept.domain, job.domain);
        assert_eq!(kept.size, SizeSpec::Uniform { h: 0.5 });
        let (new, _) = one(Input::Jobs(vec![job.clone()]), Wish { size: Some(0.5), resample: true });
        // Sides of 12; the corners stay, the rim has a circumference of 2π less the chords.
        assert_eq!(new.domain.loops[0].nodes.len(), 96);
        assert!([12, 14].contains(&new.domain.loops[1].nodes.len()));
        assert_eq!(new.layers, job.layers);
    }

    #[test]
    fn a_gap_does_not_lose_the_other_outlines() {
        let mut broken = disk(1.0);
        broken.loops[0].edges = vec![Edge::from(Curve::line(Point2::ZERO, Point2::new(1.0, 0.0)))];
        let named = |name: &str, geometry| NamedGeometry { name: name.into(), geometry };
        let input = Input::Curves(vec![named("a", broken), named("b", disk(2.0))]);
        let all = jobs(input, "file", Wish::default(), &mut Vec::new());
        assert!(all[0].job.as_ref().unwrap_err()[0].contains("gap"), "{all:?}");
        assert!(all[1].job.is_ok());
    }
}
