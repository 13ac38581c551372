//! The program's own job format, JSON (`docs/job-format.md`).
//!
//! 1. [`read`] parses with serde; an error says where in the file (`loops[1].nodes[7]`).
//! 2. Keys that are not known become notes, not errors, so that old programs read newer files.
//! 3. What serde cannot see (a law without its ratio, a length that is not positive) is checked here. Geometry is
//!    not: that is `Domain::check`.
//!
//! [`write()`] writes what [`read`] reads; numbers survive bit for bit. [`schema`] is the published JSON Schema.

mod schema;
#[cfg(test)]
mod tests;

use crate::{IoError, error::Place};
use csalf_core::{Job, Method, Options, Preset};
use csalf_geom::{Domain, HardPoint, Loop, LoopKind, Point2, Scar};
use csalf_pave::{LayerLaw, LayerSpec};
use csalf_sizemap::{SizeSpec, Source};
use schema::{
    JobFile, KindFile, LawFile, LayerFile, LoopFile, MethodFile, OptionsFile, OrderedMap, PointFile,
    PresetFile, RegionFile, ScarFile, SizeFile, SizeKind, SourceFile,
};
use std::io::Write;

const FORMAT: &str = "JSON job";

/// The options that a job file may carry; `None` where it says nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobOptions {
    /// Method.
    pub method: Option<Method>,
    /// Preset.
    pub preset: Option<Preset>,
    /// Worker threads.
    pub threads: Option<usize>,
    /// Largest growth of the size field.
    pub gradation: Option<f64>,
    /// Allow triangles.
    pub allow_triangles: Option<bool>,
    /// Allow a node to be added to a scar.
    pub repair_parity: Option<bool>,
}

impl JobOptions {
    /// Puts what the file says over `options`.
    pub fn apply(&self, options: &mut Options) {
        /// Overwrites `to` where there is something to overwrite it with.
        fn put<T: Clone>(to: &mut T, from: &Option<T>) {
            if let Some(v) = from {
                *to = v.clone();
            }
        }
        put(&mut options.method, &self.method);
        put(&mut options.preset, &self.preset);
        put(&mut options.threads, &self.threads);
        put(&mut options.allow_triangles, &self.allow_triangles);
        put(&mut options.repair_parity, &self.repair_parity);
        if self.gradation.is_some() {
            options.gradation = self.gradation;
        }
    }

    /// True if the file says nothing.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A job file as read.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct JobDocument {
    /// The job.
    pub job: Job,
    /// Options that it asks for.
    pub options: JobOptions,
    /// Unknown keys and the like, one sentence each.
    pub notes: Vec<String>,
}

/// Reads a job.
///
/// # Errors
/// [`IoError::Syntax`] with line or path, for anything that is not this format.
pub fn read(bytes: &[u8]) -> Result<JobDocument, IoError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut notes = Vec::new();
    let mut de = serde_json::Deserializer::from_slice(bytes);
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(&mut de, &mut track);
    let parsed: Result<JobFile, serde_json::Error> = serde_ignored::deserialize(tracked, |path| {
        notes.push(format!("unknown key `{path}` ignored"));
    });
    let file = match parsed.and_then(|f| de.end().map(|()| f)) {
        Ok(f) => f,
        Err(e) => {
            let path = track.path().to_string();
            let place = if path == "." || e.is_syntax() || e.is_eof() {
                Place::Line(e.line())
            } else {
                Place::Path(path)
            };
            return Err(IoError::syntax(FORMAT, place, e.to_string()));
        }
    };
    let options = options_from(&file.options)?;
    let job = job_from(file)?;
    note_repeated_names(&job.domain, &mut notes);
    Ok(JobDocument { job, options, notes })
}

/// Writes a job (and options, if it shall carry any) as pretty JSON, one node a line.
///
/// # Errors
/// [`IoError::Write`], or [`IoError::Unsupported`] for numbers that JSON does not have (NaN, infinity).
pub fn write(job: &Job, options: &JobOptions, w: &mut dyn Write) -> Result<(), IoError> {
    let d = &job.domain;
    let nodes = d.loops.iter().flat_map(|l| &l.nodes).chain(d.scars.iter().flat_map(|s| &s.nodes));
    if !nodes.chain(d.points.iter().map(|p| &p.xy)).all(|p| p.is_finite()) {
        return Err(IoError::unsupported(FORMAT, Place::Whole, "a coordinate is not a finite number"));
    }
    let mut text = serde_json::to_string_pretty(&file_from(job, options))
        .map_err(|e| IoError::unsupported(FORMAT, Place::Whole, e.to_string()))?;
    text.push('\n');
    Ok(w.write_all(text.as_bytes())?)
}

/// The JSON Schema of the format (draft 2020-12).
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(JobFile).to_value()
}

/// Path of a field, for errors.
fn at(path: impl Into<String>) -> Place {
    Place::Path(path.into())
}

/// Fails unless `x` is finite and positive.
fn positive(x: f64, path: impl Into<String>) -> Result<f64, IoError> {
    if x.is_finite() && x > 0.0 {
        Ok(x)
    } else {
        Err(IoError::syntax(FORMAT, at(path), format!("must be positive, is {x}")))
    }
}

fn xy(p: [f64; 2]) -> Point2 {
    Point2::from_array(p)
}

fn job_from(file: JobFile) -> Result<Job, IoError> {
    let mut n_holes = 0;
    let mut domain = Domain::default();
    for l in file.loops {
        let (kind, standard) = match l.kind {
            KindFile::Outer => (LoopKind::Outer, "outer".to_owned()),
            KindFile::Hole => {
                n_holes += 1;
                (LoopKind::Hole, format!("hole{}", n_holes - 1))
            }
        };
        let nodes = l.nodes.into_iter().map(xy).collect();
        domain.loops.push(Loop { kind, name: l.name.unwrap_or(standard), nodes });
    }
    for (k, s) in file.scars.into_iter().enumerate() {
        let name = s.name.unwrap_or_else(|| format!("scar{k}"));
        domain.scars.push(Scar { name, nodes: s.nodes.into_iter().map(xy).collect() });
    }
    for (k, p) in file.points.into_iter().enumerate() {
        let size = p.size.map(|h| positive(h, format!("points[{k}].size"))).transpose()?;
        let name = p.name.unwrap_or_else(|| format!("point{k}"));
        domain.points.push(HardPoint { name, xy: xy(p.xy), size });
    }
    let size = size_from(file.size)?;
    let mut layers: Vec<(String, LayerSpec)> = Vec::new();
    for (pattern, l) in file.layers.0 {
        let spec = layer_from(l, &format!("layers.{pattern}"))?;
        layers.push((pattern, spec));
    }
    let local_region = file.local_region.map(|r| r.circle);
    if let Some([_, _, r]) = local_region {
        positive(r, "local_region.circle[2]")?;
    }
    Ok(Job { name: file.name, about: file.about, domain, size, layers, local_region })
}

fn size_from(s: SizeFile) -> Result<SizeSpec, IoError> {
    let missing = |key: &str| IoError::syntax(FORMAT, at("size"), format!("this kind of size needs `{key}`"));
    Ok(match s.kind {
        SizeKind::Boundary => SizeSpec::Boundary,
        SizeKind::Uniform => SizeSpec::Uniform { h: positive(s.h.ok_or_else(|| missing("h"))?, "size.h")? },
        SizeKind::Sources => {
            let far = positive(s.far.ok_or_else(|| missing("far"))?, "size.far")?;
            let mut sources = Vec::new();
            for (k, f) in s.sources.ok_or_else(|| missing("sources"))?.into_iter().enumerate() {
                let path = |key: &str| format!("size.sources[{k}].{key}");
                if !(f.radius >= 0.0 && f.radius.is_finite()) {
                    let message = format!("must not be negative, is {}", f.radius);
                    return Err(IoError::syntax(FORMAT, at(path("radius")), message));
                }
                sources.push(Source {
                    xy: xy(f.xy),
                    h: positive(f.h, path("h"))?,
                    radius: f.radius,
                    falloff: positive(f.falloff, path("falloff"))?,
                });
            }
            SizeSpec::Sources { far, sources }
        }
        SizeKind::Background => {
            let points: Vec<Point2> =
                s.points.ok_or_else(|| missing("points"))?.into_iter().map(xy).collect();
            let triangles = s.triangles.ok_or_else(|| missing("triangles"))?;
            let values = s.values.ok_or_else(|| missing("values"))?;
            if values.len() != points.len() {
                let message = format!("{} values for {} points", values.len(), points.len());
                return Err(IoError::syntax(FORMAT, at("size.values"), message));
            }
            for (k, &h) in values.iter().enumerate() {
                positive(h, format!("size.values[{k}]"))?;
            }
            if let Some(k) = triangles.iter().position(|t| t.iter().any(|&i| i as usize >= points.len())) {
                let message = format!("there are {} points only, numbered from 0", points.len());
                return Err(IoError::syntax(FORMAT, at(format!("size.triangles[{k}]")), message));
            }
            SizeSpec::Background { points, triangles, values }
        }
    })
}

fn layer_from(l: LayerFile, path: &str) -> Result<LayerSpec, IoError> {
    let bad = |message: &str| IoError::syntax(FORMAT, at(path), message);
    let law = l.law.unwrap_or(match (&l.thicknesses, l.ratio) {
        (Some(_), _) => LawFile::Explicit,
        (None, Some(_)) => LawFile::Geometric,
        (None, None) => LawFile::Auto,
    });
    let mut explicit_count = None;
    let law = match law {
        LawFile::Auto => LayerLaw::Auto,
        LawFile::Constant => LayerLaw::Constant,
        LawFile::Ramp => LayerLaw::Ramp,
        LawFile::Parabolic => LayerLaw::Parabolic,
        LawFile::Fibonacci => LayerLaw::Fibonacci,
        LawFile::Geometric => {
            let q = l.ratio.ok_or_else(|| bad("law `geometric` needs `ratio`"))?;
            LayerLaw::Geometric(positive(q, format!("{path}.ratio"))?)
        }
        LawFile::Explicit => {
            let t = l.thicknesses.ok_or_else(|| bad("law `explicit` needs `thicknesses`"))?;
            for (k, &x) in t.iter().enumerate() {
                positive(x, format!("{path}.thicknesses[{k}]"))?;
            }
            explicit_count = Some(t.len());
            LayerLaw::Explicit(t)
        }
    };
    let count = l.count.or(explicit_count).ok_or_else(|| bad("needs `count`"))?;
    if explicit_count.is_some_and(|n| count > n) {
        return Err(bad("`count` is more than there are `thicknesses`"));
    }
    let first = l.first.map(|t| positive(t, format!("{path}.first"))).transpose()?;
    Ok(LayerSpec { count, law, first })
}

fn options_from(file: &Option<OptionsFile>) -> Result<JobOptions, IoError> {
    let Some(o) = file else { return Ok(JobOptions::default()) };
    Ok(JobOptions {
        method: o.method.map(|m| match m {
            MethodFile::Csalf => Method::Csalf,
            MethodFile::Paper => Method::Paper,
            MethodFile::Tqm => Method::Tqm,
        }),
        preset: o.preset.map(|p| match p {
            PresetFile::Quality => Preset::Quality,
            PresetFile::Fast => Preset::Fast,
        }),
        threads: o.threads,
        gradation: o.gradation.map(|g| positive(g, "options.gradation")).transpose()?,
        allow_triangles: o.allow_triangles,
        repair_parity: o.repair_parity,
    })
}

/// Notes names that stand for more than one curve or point: sets and layer patterns would mean all of them.
fn note_repeated_names(domain: &Domain, notes: &mut Vec<String>) {
    let loops = domain.loops.iter().map(|l| &l.name);
    let scars = domain.scars.iter().map(|s| &s.name);
    let mut names: Vec<&String> = loops.chain(scars).chain(domain.points.iter().map(|p| &p.name)).collect();
    names.sort();
    for run in names.chunk_by(|a, b| a == b).filter(|run| run.len() > 1) {
        notes.push(format!("the name `{}` is used {} times", run[0], run.len()));
    }
}

fn file_from(job: &Job, options: &JobOptions) -> JobFile {
    let arrays = |p: &[Point2]| p.iter().map(|q| q.to_array()).collect();
    // A name is written only where it is not the one that reading would give.
    let unless = |name: &String, standard: String| (*name != standard).then(|| name.clone());
    let mut n_holes = 0;
    let loops = job.domain.loops.iter().map(|l| {
        let (kind, standard) = match l.kind {
            LoopKind::Outer => (KindFile::Outer, "outer".to_owned()),
            LoopKind::Hole => {
                n_holes += 1;
                (KindFile::Hole, format!("hole{}", n_holes - 1))
            }
        };
        LoopFile { kind, name: unless(&l.name, standard), nodes: arrays(&l.nodes) }
    });
    let loops = loops.collect();
    let scar = |(k, s): (usize, &Scar)| ScarFile {
        name: unless(&s.name, format!("scar{k}")),
        nodes: arrays(&s.nodes),
    };
    let point = |(k, p): (usize, &HardPoint)| PointFile {
        xy: p.xy.to_array(),
        name: unless(&p.name, format!("point{k}")),
        size: p.size,
    };
    JobFile {
        schema: None,
        name: job.name.clone(),
        about: job.about.clone(),
        loops,
        scars: job.domain.scars.iter().enumerate().map(scar).collect(),
        points: job.domain.points.iter().enumerate().map(point).collect(),
        size: size_file(&job.size),
        local_region: job.local_region.map(|circle| RegionFile { circle }),
        layers: OrderedMap(job.layers.iter().map(|(k, l)| (k.clone(), layer_file(l))).collect()),
        options: (!options.is_empty()).then(|| options_file(options)),
    }
}

fn size_file(size: &SizeSpec) -> SizeFile {
    let empty = SizeFile::default();
    match size {
        SizeSpec::Boundary => empty,
        SizeSpec::Uniform { h } => SizeFile { kind: SizeKind::Uniform, h: Some(*h), ..empty },
        SizeSpec::Sources { far, sources } => {
            let source =
                |s: &Source| SourceFile { xy: s.xy.to_array(), h: s.h, radius: s.radius, falloff: s.falloff };
            let sources = Some(sources.iter().map(source).collect());
            SizeFile { kind: SizeKind::Sources, far: Some(*far), sources, ..empty }
        }
        SizeSpec::Background { points, triangles, values } => SizeFile {
            kind: SizeKind::Background,
            points: Some(points.iter().map(|p| p.to_array()).collect()),
            triangles: Some(triangles.clone()),
            values: Some(values.clone()),
            ..empty
        },
    }
}

fn layer_file(l: &LayerSpec) -> LayerFile {
    let (law, ratio, thicknesses) = match &l.law {
        LayerLaw::Auto => (LawFile::Auto, None, None),
        LayerLaw::Constant => (LawFile::Constant, None, None),
        LayerLaw::Ramp => (LawFile::Ramp, None, None),
        LayerLaw::Parabolic => (LawFile::Parabolic, None, None),
        LayerLaw::Fibonacci => (LawFile::Fibonacci, None, None),
        LayerLaw::Geometric(q) => (LawFile::Geometric, Some(*q), None),
        LayerLaw::Explicit(t) => (LawFile::Explicit, None, Some(t.clone())),
    };
    LayerFile { count: Some(l.count), law: Some(law), first: l.first, ratio, thicknesses }
}

fn options_file(o: &JobOptions) -> OptionsFile {
    OptionsFile {
        method: o.method.map(|m| match m {
            Method::Csalf => MethodFile::Csalf,
            Method::Paper => MethodFile::Paper,
            Method::Tqm => MethodFile::Tqm,
        }),
        preset: o.preset.map(|p| match p {
            Preset::Quality => PresetFile::Quality,
            Preset::Fast => PresetFile::Fast,
        }),
        threads: o.threads,
        gradation: o.gradation,
        allow_triangles: o.allow_triangles,
        repair_parity: o.repair_parity,
    }
}
