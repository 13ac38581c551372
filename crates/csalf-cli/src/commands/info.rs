//! `csalf info`: what is in a file, without meshing it.

use crate::args::InfoArgs;
use crate::commands::mesh::{path_of, several, shown_outline};
use crate::exit::Failure;
use crate::outlines::{self, Wish};
use crate::{files, json, say};
use csalf_core::Job;
use csalf_geom::{LoopKind, Point2, polygon};
use csalf_io::{JobFormat, MeshData, MeshFormat};
use csalf_sizemap::SizeSpec;
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// Most loops listed one by one.
const MAX_LOOPS: usize = 12;

/// Runs the command.
///
/// # Errors
/// [`Failure::Usage`], [`Failure::Invalid`] or [`Failure::Files`].
pub fn run(args: &InfoArgs, level: i32) -> Result<(), Failure> {
    super::with_json(args.json, info(args, level))
}

fn info(args: &InfoArgs, level: i32) -> Result<(), Failure> {
    let shown = files::shown(&args.input);
    if let Some(format) = super::model::format(&args.input, args.format.as_deref()) {
        return super::model_info::info(args, format);
    }
    // Outlines come first; of formats that hold both, a mesh is what has elements.
    match files::job_format(&args.input, args.format.as_deref()) {
        Ok(JobFormat::Msh) => {}
        Ok(format) => {
            return of_outlines(args, &shown, format, level);
        }
        Err(f) if args.format.is_none() && MeshFormat::from_path(&args.input).is_err() => return Err(f),
        Err(_) => {}
    }
    let format = files::mesh_format(&args.input, args.format.as_deref())?;
    let data = files::read_mesh(&args.input, format)?;
    if args.json {
        let mut m = Map::new();
        m.insert("n_vertices".into(), data.mesh.n_vertices().into());
        m.insert("n_quads".into(), data.mesh.n_quads().into());
        m.insert("n_triangles".into(), data.mesh.triangles.len().into());
        m.insert("sets".into(), json!(set_names(&data)));
        return say::out(&json::success(m));
    }
    say::out(&describe_mesh(&shown, &data))
}

/// Tells of outlines, and with `--job` writes what would be meshed.
fn of_outlines(args: &InfoArgs, shown: &str, format: JobFormat, level: i32) -> Result<(), Failure> {
    let mut read = files::read_jobs(&args.input, format)?;
    let wish = Wish { size: args.size, resample: args.resample };
    let all = outlines::jobs(read.input, &files::stem(&args.input), wish, &mut read.notes);
    if level >= 0 {
        say::warnings(shown, &read.notes);
    }
    let n = all.len();
    let to_stdout = args.job.as_deref().is_some_and(files::is_standard);
    if to_stdout && (n > 1 || args.json) {
        return Err(Failure::Usage(format!(
            "{shown}: more than one job does not fit into one stream: use files"
        )));
    }
    let (mut failures, mut entries) = (Vec::new(), Vec::new());
    for (k, outline) in all.iter().enumerate() {
        let job = match &outline.job {
            Ok(job) => job,
            Err(defects) => {
                let input = shown_outline(shown, &outline.name, n);
                failures.push(Failure::Invalid { input, defects: defects.clone() });
                continue;
            }
        };
        if let Some(path) = &args.job {
            let path = path_of(path, &outline.name, k, n);
            files::write(&path, |sink| csalf_io::json::write(job, &read.options, sink))?;
        }
        if args.json {
            entries.push(entry(job));
        } else if !to_stdout {
            say::out(&describe(job))?;
        }
    }
    several(failures, n)?;
    if args.json {
        let mut m = Map::new();
        m.insert("jobs".into(), entries.into());
        say::out(&json::success(m))?;
    }
    Ok(())
}

/// A job in numbers.
pub(super) fn entry(job: &Job) -> Value {
    let d = &job.domain;
    json!({
        "name": job.name,
        "n_loops": d.loops.len(),
        "n_segments": segments(job),
        "n_scars": d.scars.len(),
        "n_points": d.points.len(),
        "area": area(job),
        "size": size_kind(&job.size),
        "n_layer_rules": job.layers.len(),
    })
}

/// A job in words.
pub fn describe(job: &Job) -> String {
    let d = &job.domain;
    let mut s = job.name.clone();
    if !job.about.is_empty() {
        let _ = write!(s, ": {}", job.about);
    }
    let n = segments(job);
    let parity = if n.is_multiple_of(2) { "even" } else { "odd" };
    let _ = write!(s, "\n  {} loops, {n} segments ({parity}), area {}", d.loops.len(), area(job));
    let nodes = d.loops.iter().flat_map(|l| l.nodes.iter().copied());
    if let Some((low, high)) = polygon::bounds(nodes) {
        let _ = write!(s, ", from ({}, {}) to ({}, {})", low.x, low.y, high.x, high.y);
    }
    for l in d.loops.iter().take(MAX_LOOPS) {
        let kind = if l.kind == LoopKind::Outer { "outer" } else { "hole" };
        let (short, long) = segment_range(&l.nodes);
        let _ = write!(s, "\n  {} ({kind}): {} segments of {short:.4} to {long:.4}", l.name, l.nodes.len());
    }
    if d.loops.len() > MAX_LOOPS {
        let _ = write!(s, "\n  ... {} more loops", d.loops.len() - MAX_LOOPS);
    }
    if !d.scars.is_empty() || !d.points.is_empty() {
        let _ = write!(s, "\n  {} scars, {} hard points", d.scars.len(), d.points.len());
    }
    let _ = write!(s, "\n  size: {}", size_kind(&job.size));
    for (pattern, l) in &job.layers {
        let _ = write!(s, "\n  layers: {pattern} {} {:?}", l.count, l.law);
    }
    s
}

fn segments(job: &Job) -> usize {
    job.domain.loops.iter().map(|l| l.nodes.len()).sum()
}

/// Area of the outer loops without that of the holes, whatever their orientation.
fn area(job: &Job) -> f64 {
    let signed = |l: &csalf_geom::Loop| {
        let a = polygon::signed_area(&l.nodes).abs();
        if l.kind == LoopKind::Outer { a } else { -a }
    };
    job.domain.loops.iter().map(signed).sum()
}

fn segment_range(nodes: &[Point2]) -> (f64, f64) {
    let lengths = (0..nodes.len()).map(|i| nodes[i].distance(nodes[(i + 1) % nodes.len()]));
    lengths.fold((f64::INFINITY, 0.0), |(a, b), l| (a.min(l), b.max(l)))
}

fn size_kind(size: &SizeSpec) -> String {
    match size {
        SizeSpec::Boundary => "from the boundary segments".into(),
        SizeSpec::Uniform { h } => format!("{h} everywhere"),
        SizeSpec::Sources { far, sources } => format!("{} sources, {far} away from them", sources.len()),
        SizeSpec::Background { points, .. } => format!("a background of {} nodes", points.len()),
    }
}

fn set_names(data: &MeshData) -> Vec<&str> {
    let s = &data.sets;
    let names = s
        .nodes
        .iter()
        .map(|(n, _)| n)
        .chain(s.edges.iter().map(|(n, _)| n))
        .chain(s.quads.iter().map(|(n, _)| n));
    let mut names: Vec<&str> = names.map(String::as_str).collect();
    names.sort_unstable();
    names.dedup();
    names
}

fn describe_mesh(shown: &str, data: &MeshData) -> String {
    let m = &data.mesh;
    let mut s = format!(
        "{shown}: {} quads, {} triangles, {} vertices",
        m.n_quads(),
        m.triangles.len(),
        m.n_vertices()
    );
    if !data.heights.is_empty() {
        s.push_str(", in space");
    }
    let names = set_names(data);
    if !names.is_empty() {
        let _ = write!(s, "\n  sets: {}", names.join(", "));
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_in_words_and_in_numbers() {
        let job = crate::commands::demo::plate();
        let text = describe(&job);
        assert!(text.contains("2 loops, 112 segments (even)"), "{text}");
        assert!(text.contains("hole0 (hole): 64 segments"), "{text}");
        let hole = 32.0 * (std::f64::consts::TAU / 64.0).sin();
        assert!((area(&job) - (144.0 - hole)).abs() < 1e-9, "{}", area(&job));
        assert_eq!(entry(&job)["n_segments"], 112);
    }
}
