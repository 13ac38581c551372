//! What the page holds: a job whose loops and scars may be curves instead of nodes.
//!
//! ```json
//! {"job": {"loops": [{"kind": "outer", "nodes": []}], "size": {"kind": "uniform", "h": 0.5}},
//!  "curves": {"loops": [[{"arc": {"center": [0, 0], "radii": [2, 2], "rotation": 0, "start": 0, "sweep":
//! 6.28}}]]},
//!  "resample": false, "draft": false}
//! ```
//!
//! `job` is the job format of csalf; where `curves` has an entry, it stands for the nodes of that loop or
//! scar. Loops
//! with nodes keep them, unless `resample` is set. Curves get nodes as far apart as the sizes of the job say.

use crate::curve_file::CurveFile;
use csalf_core::{Job, Options, Preset};
use csalf_geom::curve::Curve;
use csalf_geom::geometry::{CurveLoop, CurveScar, Edge};
use csalf_geom::{Geometry, Point2};
use csalf_io::outlines::{self, Unplaced};
use csalf_io::{Input, IoError, JobInput, JobOptions, Place, json};
use csalf_sizemap::SizeSpec;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

const FORMAT: &str = "studio document";

/// A drawing with everything that is wanted of its mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Document {
    /// The job; loops and scars that are curves have no nodes in it.
    pub job: Job,
    /// Options of the mesher, as the job asks for them.
    pub options: JobOptions,
    /// Per loop of the job: its curves, or `None` if its nodes are given.
    pub loops: Vec<Option<Vec<Curve>>>,
    /// The same of the scars.
    pub scars: Vec<Option<Vec<Curve>>>,
    /// New nodes also on loops and scars whose nodes are given.
    pub resample: bool,
    /// A mesh for a moment, while something is dragged: less work on quality.
    pub draft: bool,
    /// What was left out when it was read.
    pub notes: Vec<String>,
}

/// A job that can be meshed, and what was decided for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Ready {
    /// The job, with nodes on all curves.
    pub job: Job,
    /// The length between nodes that was chosen because none is given.
    pub default_size: Option<f64>,
}

#[derive(Deserialize)]
struct FileIn<'a> {
    #[serde(borrow)]
    job: &'a RawValue,
    #[serde(default)]
    curves: CurvesFile,
    #[serde(default)]
    resample: bool,
    #[serde(default)]
    draft: bool,
}

#[derive(Serialize)]
struct FileOut {
    job: Box<RawValue>,
    curves: CurvesFile,
    resample: bool,
}

#[derive(Default, Serialize, Deserialize)]
struct CurvesFile {
    #[serde(default)]
    loops: Vec<Option<Vec<CurveFile>>>,
    #[serde(default)]
    scars: Vec<Option<Vec<CurveFile>>>,
}

impl Document {
    /// Reads a document.
    ///
    /// # Errors
    /// [`IoError::Syntax`].
    pub fn read(bytes: &[u8]) -> Result<Self, IoError> {
        let file: FileIn<'_> = serde_json::from_slice(bytes)
            .map_err(|e| IoError::syntax(FORMAT, Place::Line(e.line()), e.to_string()))?;
        let read = json::read(file.job.get().as_bytes())?;
        let chains = |name: &str, list: Vec<Option<Vec<CurveFile>>>, n: usize| {
            let chain = |(k, chain): (usize, Option<Vec<CurveFile>>)| {
                let curves = chain.map(|c| c.into_iter().map(Curve::try_from).collect::<Result<Vec<_>, _>>());
                let at = || Place::Path(format!("curves.{name}[{k}]"));
                curves.transpose().map_err(|e| IoError::syntax(FORMAT, at(), e.to_string()))
            };
            let mut out = list.into_iter().enumerate().map(chain).collect::<Result<Vec<_>, _>>()?;
            out.resize(n, None);
            Ok::<_, IoError>(out)
        };
        Ok(Self {
            loops: chains("loops", file.curves.loops, read.job.domain.loops.len())?,
            scars: chains("scars", file.curves.scars, read.job.domain.scars.len())?,
            job: read.job,
            options: read.options,
            resample: file.resample,
            draft: file.draft,
            notes: read.notes,
        })
    }

    /// The document as JSON.
    ///
    /// # Errors
    /// [`IoError::Unsupported`] for numbers that JSON does not have.
    pub fn write(&self) -> Result<Box<RawValue>, IoError> {
        let fail = |e: serde_json::Error| IoError::unsupported(FORMAT, Place::Whole, e.to_string());
        let mut text = Vec::new();
        json::write(&self.job, &self.options, &mut text)?;
        let job = serde_json::from_slice(&text).map_err(fail)?;
        let chains = |list: &[Option<Vec<Curve>>]| {
            let chain = |c: &Vec<Curve>| c.iter().map(CurveFile::from).collect();
            list.iter().map(|c| c.as_ref().map(chain)).collect()
        };
        let curves = CurvesFile { loops: chains(&self.loops), scars: chains(&self.scars) };
        serde_json::value::to_raw_value(&FileOut { job, curves, resample: self.resample }).map_err(fail)
    }

    /// The documents of what a reader gave, one per outline. `stem` is the name of those that have none.
    pub fn of_input(read: JobInput, stem: &str) -> Vec<Self> {
        let mut out: Vec<Self> = match read.input {
            Input::Jobs(jobs) => jobs.into_iter().map(Self::of_job).collect(),
            Input::Curves(list) => list.into_iter().map(|g| Self::of_geometry(g.name, g.geometry)).collect(),
            _ => Vec::new(),
        };
        let n = out.len();
        for (k, d) in out.iter_mut().enumerate() {
            d.options = read.options.clone();
            if d.job.name.is_empty() {
                d.job.name = if n == 1 { stem.to_owned() } else { format!("{stem}{k}") };
            }
        }
        out
    }

    /// A document of given nodes.
    pub fn of_job(job: Job) -> Self {
        let (loops, scars) = (vec![None; job.domain.loops.len()], vec![None; job.domain.scars.len()]);
        Self { job, loops, scars, ..Self::default() }
    }

    /// A document of curves.
    pub fn of_geometry(name: String, geometry: Geometry) -> Self {
        let curves = |edges: Vec<Edge>| Some(edges.into_iter().map(|e| e.curve).collect());
        let mut out = Self { job: Job { name, ..Job::default() }, ..Self::default() };
        for l in geometry.loops {
            out.job.domain.loops.push(csalf_geom::Loop { kind: l.kind, name: l.name, nodes: Vec::new() });
            out.loops.push(curves(l.edges));
        }
        for s in geometry.scars {
            out.job.domain.scars.push(csalf_geom::Scar { name: s.name, nodes: Vec::new() });
            out.scars.push(curves(s.edges));
        }
        out.job.domain.points = geometry.points;
        out
    }

    /// The options of a run.
    pub fn run_options(&self) -> Options {
        let mut options = Options::default();
        self.options.apply(&mut options);
        if self.draft {
            options.preset = Preset::Fast;
        }
        options
    }

    /// The loops and scars that get new nodes, with their places in the job.
    fn free(&self) -> (Geometry, Vec<usize>, Vec<usize>) {
        let d = &self.job.domain;
        let edges = |curves: Option<&Vec<Curve>>, nodes: &[Point2], closed: bool| -> Option<Vec<Edge>> {
            match curves {
                Some(c) => Some(c.iter().cloned().map(Edge::from).collect()),
                None if self.resample => {
                    let back = nodes.first().filter(|_| closed);
                    Some(vec![Curve::Polyline(nodes.iter().chain(back).copied().collect()).into()])
                }
                None => None,
            }
        };
        let mut out = (Geometry::default(), Vec::new(), Vec::new());
        for (k, l) in d.loops.iter().enumerate() {
            if let Some(edges) = edges(self.loops.get(k).and_then(Option::as_ref), &l.nodes, true) {
                out.0.loops.push(CurveLoop { kind: l.kind, name: l.name.clone(), edges });
                out.1.push(k);
            }
        }
        for (k, s) in d.scars.iter().enumerate() {
            if let Some(edges) = edges(self.scars.get(k).and_then(Option::as_ref), &s.nodes, false) {
                out.0.scars.push(CurveScar { name: s.name.clone(), edges });
                out.2.push(k);
            }
        }
        out
    }

    /// The job with nodes on all curves. Cost O(number of nodes).
    ///
    /// # Errors
    /// [`Unplaced`]: what is wrong with curves or sizes.
    pub fn ready(&self) -> Result<Ready, Unplaced> {
        let (mut geometry, loops, scars) = self.free();
        let mut job = self.job.clone();
        if loops.is_empty() && scars.is_empty() {
            return Ok(Ready { job, default_size: None });
        }
        let given: Vec<Vec<Point2>> = job.domain.loops.iter().map(|l| l.nodes.clone()).collect();
        // A curve beside given nodes gets segments like theirs.
        let kept: Vec<&csalf_geom::Loop> =
            job.domain.loops.iter().enumerate().filter(|(k, _)| !loops.contains(k)).map(|(_, l)| l).collect();
        let n: usize = kept.iter().map(|l| l.nodes.len()).sum();
        let length: f64 = kept.iter().map(|l| csalf_geom::polygon::perimeter(&l.nodes)).sum();
        let size = match &job.size {
            SizeSpec::Boundary if n > 0 && length > 0.0 => SizeSpec::Uniform { h: length / n as f64 },
            size => size.clone(),
        };
        // If the given nodes are odd in number, those of curves must be: one odd loop stands in for all.
        if n % 2 == 1
            && let Some(odd) = kept.iter().find(|l| l.nodes.len() % 2 == 1)
        {
            geometry.loops.push(counted(odd));
        }
        let placed = outlines::place(&geometry, &size, &given)?;
        for (k, l) in loops.into_iter().zip(placed.domain.loops) {
            job.domain.loops[k] = l;
        }
        for (k, s) in scars.into_iter().zip(placed.domain.scars) {
            job.domain.scars[k] = s;
        }
        Ok(Ready { job, default_size: placed.default_size })
    }

    /// The job without nodes of its own making: curves as polylines for the eye. For domains that got no
    /// nodes.
    pub fn sketch(&self) -> Job {
        let mut job = self.job.clone();
        let loops = job.domain.loops.iter_mut().map(|l| &mut l.nodes).zip(&self.loops);
        let scars = job.domain.scars.iter_mut().map(|s| &mut s.nodes).zip(&self.scars);
        for (nodes, curves) in loops.chain(scars) {
            nodes.extend(curves.iter().flatten().flat_map(samples));
        }
        job
    }
}

/// A loop as curves that keep its nodes.
fn counted(l: &csalf_geom::Loop) -> CurveLoop {
    let edges = l.nodes.iter().zip(l.nodes.iter().cycle().skip(1));
    let edges = edges.map(|(a, b)| Edge { curve: Curve::line(*a, *b), corner: true, count: Some(1) });
    CurveLoop { kind: l.kind, name: l.name.clone(), edges: edges.collect() }
}

/// Points along a curve, near enough to draw it.
fn samples(curve: &Curve) -> Vec<Point2> {
    /// Points per curve or span of it. *Arbitrary.*
    const SAMPLES: u32 = 24;
    if !curve.is_finite() {
        return Vec::new();
    }
    if let Curve::Polyline(p) = curve {
        return p.clone();
    }
    let (t0, t1) = curve.range();
    let even = (0..=SAMPLES).map(|k| t0 + (t1 - t0) * f64::from(k) / f64::from(SAMPLES));
    let mut t: Vec<f64> = even.chain(curve.breaks()).collect();
    t.sort_by(f64::total_cmp);
    t.into_iter().map(|t| curve.eval(t).point).filter(|p| p.is_finite()).collect()
}
