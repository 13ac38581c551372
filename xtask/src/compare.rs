//! `cargo xtask compare`: csalf and, where there is one, gmsh beside it on the same jobs in the same run.
//!
//! ```text
//!   fixtures/*/job.json, --cases DIR/*.json ──▶ csalf, gmsh, csalf, gmsh, ... ──▶ docs/benchmarks.md
//!                                               each in a process of its own
//! ```
//!
//! Times are processor seconds of the meshing alone on one thread, the least of some runs. Quality is measured by
//! csalf-mesh for both, against the same size field. gmsh is never linked: it is run through a Python that has its
//! package (`xtask/python/gmsh_mesh.py`), with its Frontal-Delaunay for quads and Blossom recombination, which keeps
//! the boundary.

use crate::{Outcome, say};
use csalf_core::{Job, Options};
use csalf_geom::{Point2, Tolerance, VertexId};
use csalf_io::json;
use csalf_mesh::{QuadMesh, quality::QualityReport};
use csalf_sizemap::build::{build, of_boundary};
use csalf_sizemap::{Extras, SizeField, SizeSpec};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Options of the command.
#[derive(clap::Args, Debug)]
pub(crate) struct CompareArgs {
    /// A folder of further jobs (*.json)
    #[arg(long, value_name = "DIR")]
    cases: Option<PathBuf>,
    /// Only these jobs, by name, separated by commas
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    only: Vec<String>,
    /// Runs of each, in turn; the least time counts
    #[arg(long, default_value_t = 3, value_name = "N")]
    runs: usize,
    /// A Python that has the gmsh package
    #[arg(long, default_value = "python3", value_name = "PROGRAM")]
    python: String,
    /// No gmsh, even if there is one
    #[arg(long)]
    alone: bool,
    /// Where the table goes
    #[arg(long, default_value = "docs/benchmarks.md", value_name = "FILE")]
    output: PathBuf,
    /// Mesh one job and print its times (what this program runs itself by)
    #[arg(long, hide = true, value_name = "FILE")]
    one: Option<PathBuf>,
}

/// What one mesher did on one job.
struct Result1 {
    cpu_s: f64,
    rss_mb: f64,
    n_elements: usize,
    quality: QualityReport,
}

impl Result1 {
    /// Elements per processor second.
    fn rate(&self) -> f64 {
        self.n_elements as f64 / self.cpu_s
    }
}

/// Compares and writes the table.
///
/// # Errors
/// A job that cannot be read or meshed, a file that cannot be written.
pub(crate) fn run(root: &Path, args: &CompareArgs) -> Outcome {
    if let Some(file) = &args.one {
        return one(file);
    }
    let scratch = std::env::temp_dir().join(format!("csalf-compare-{}", std::process::id()));
    fs::create_dir_all(&scratch).map_err(|e| format!("{}: {e}", scratch.display()))?;
    let version = if args.alone { None } else { gmsh_version(&args.python) };
    if version.is_none() {
        say("no gmsh: csalf alone (python3 -m pip install gmsh, and --python if it is another one)");
    }
    let mut rows = Vec::new();
    for path in jobs(root, args)? {
        let job = read(&path)?;
        if !args.only.is_empty() && !args.only.contains(&job.name) {
            continue;
        }
        let size = size_of(&job)?;
        let options = Options { threads: 1, ..Options::default() };
        let meshed = csalf_core::mesh(&job, &options).map_err(|e| format!("{}: {e}", job.name))?;
        let quality = QualityReport::new(&meshed.mesh, Some(size.as_ref()), None);
        let (mut ours, mut theirs): (Option<Result1>, Option<Result1>) = (None, None);
        for _ in 0..args.runs.max(1) {
            least(&mut ours, csalf(&path, &quality)?);
            if version.is_some() {
                match gmsh(root, args, &job, size.as_ref(), &scratch) {
                    Ok(r) => least(&mut theirs, r),
                    Err(e) => {
                        say(&format!("{}: gmsh: {e}", job.name));
                        break;
                    }
                }
            }
        }
        if let Some(ours) = ours {
            let row = row(&job.name, &ours, theirs.as_ref());
            say(&row);
            rows.push((row, theirs.map(|t| ours.rate() / t.rate())));
        }
    }
    // Nothing to be done if it stays.
    let _ = fs::remove_dir_all(&scratch);
    let page = page(&rows, version.as_deref(), args);
    let output = root.join(&args.output);
    fs::write(&output, page).map_err(|e| format!("{}: {e}", output.display()))
}

fn least(kept: &mut Option<Result1>, new: Result1) {
    if kept.as_ref().is_none_or(|k| new.cpu_s < k.cpu_s) {
        *kept = Some(new);
    }
}

/// The job files: fixtures first, then those of `--cases`, by name.
fn jobs(root: &Path, args: &CompareArgs) -> Result<Vec<PathBuf>, String> {
    let list = |dir: &Path| -> Result<Vec<PathBuf>, String> {
        let entries = fs::read_dir(dir).map_err(|e| format!("{}: {e}", dir.display()))?;
        let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        paths.sort();
        Ok(paths)
    };
    let mut out: Vec<PathBuf> = list(&root.join("fixtures"))?.iter().map(|p| p.join("job.json")).collect();
    out.retain(|p| p.is_file());
    if let Some(dir) = &args.cases {
        out.extend(list(dir)?.into_iter().filter(|p| p.extension().is_some_and(|e| e == "json")));
    }
    Ok(out)
}

fn read(path: &Path) -> Result<Job, String> {
    let bytes = fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(json::read(&bytes).map_err(|e| format!("{}: {e}", path.display()))?.job)
}

fn loops(job: &Job) -> Vec<Vec<Point2>> {
    job.domain.loops.iter().map(|l| l.nodes.clone()).collect()
}

fn size_of(job: &Job) -> Result<std::sync::Arc<dyn SizeField>, String> {
    let hard: Vec<_> = job.domain.points.iter().filter_map(|p| p.size.map(|h| (p.xy, h))).collect();
    let extras = Extras { hard_points: &hard, gradation: None };
    let nodes = job.domain.loops.iter().flat_map(|l| l.nodes.iter().copied());
    build(&job.size, &loops(job), &extras, Tolerance::of_points(nodes))
        .map_err(|e| format!("{}: {e}", job.name))
}

/// Meshes a job once in this process and prints what it took.
fn one(path: &Path) -> Outcome {
    let job = read(path)?;
    let before = peak_mb();
    let start = cpu_time::ProcessTime::now();
    let meshed = csalf_core::mesh(&job, &Options { threads: 1, ..Options::default() });
    let cpu = start.elapsed().as_secs_f64();
    let meshed = meshed.map_err(|e| format!("{}: {e}", job.name))?;
    say(&json!({ "cpu_s": cpu, "rss_mb": peak_mb() - before, "quads": meshed.mesh.n_quads() }).to_string());
    Ok(())
}

/// Peak memory of this process, where the system tells; else 0.
fn peak_mb() -> f64 {
    let text = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find(|l| l.starts_with("VmHWM:"));
    let kb = line.and_then(|l| l.split_whitespace().nth(1)?.parse::<f64>().ok());
    kb.unwrap_or_default() / 1024.0
}

/// Time and memory of a process of its own, which makes the mesh of this quality.
fn csalf(path: &Path, quality: &QualityReport) -> Result<Result1, String> {
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let output = Command::new(program).args(["compare", "--one"]).arg(path).output();
    let output = output.map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&output.stderr);
    let last = text.lines().last().unwrap_or_default();
    let v: Value = serde_json::from_str(last).map_err(|e| format!("{}: {e}: {last}", path.display()))?;
    let number = |key: &str| v[key].as_f64().unwrap_or_default();
    Ok(Result1 {
        cpu_s: number("cpu_s"),
        rss_mb: number("rss_mb"),
        n_elements: quality.n_quads + quality.n_triangles,
        quality: quality.clone(),
    })
}

fn gmsh_version(python: &str) -> Option<String> {
    let output = Command::new(python).args(["-c", "import gmsh; print(gmsh.__version__)"]).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    (output.status.success() && !text.is_empty()).then_some(text)
}

fn gmsh(
    root: &Path,
    args: &CompareArgs,
    job: &Job,
    size: &dyn SizeField,
    scratch: &Path,
) -> Result<Result1, String> {
    let (input, output) = (scratch.join("in.json"), scratch.join("out.json"));
    fs::write(&input, input_of(job)?.to_string()).map_err(|e| e.to_string())?;
    let script = root.join("xtask/python/gmsh_mesh.py");
    let run = Command::new(&args.python).arg(script).args([&input, &output]).output();
    let run = run.map_err(|e| e.to_string())?;
    if !run.status.success() {
        let text = String::from_utf8_lossy(&run.stderr).into_owned();
        return Err(text.lines().last().unwrap_or("failed").to_owned());
    }
    let text = fs::read_to_string(&output).map_err(|e| e.to_string())?;
    let v: Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
    let mesh = mesh_of(&v).ok_or("no mesh")?;
    let number = |key: &str| v[key].as_f64().unwrap_or_default();
    Ok(Result1 {
        cpu_s: number("cpu_s"),
        rss_mb: number("rss_mb"),
        n_elements: mesh.n_quads() + mesh.triangles.len(),
        quality: QualityReport::new(&mesh, Some(size), None),
    })
}

/// What the script reads.
fn input_of(job: &Job) -> Result<Value, String> {
    let list = |p: &[Point2]| p.iter().map(|p| p.to_array()).collect::<Vec<_>>();
    let mut nodes: Vec<Vec<Point2>> = loops(job);
    // The outer loop first.
    let outer = job.domain.loops.iter().position(|l| l.kind == csalf_geom::LoopKind::Outer).unwrap_or(0);
    nodes.swap(0, outer);
    let background = |b: &csalf_sizemap::Background| {
        let points: Vec<_> = b.points().map(|p| p.to_array()).collect();
        json!({
            "points": points,
            "triangles": b.triangles().collect::<Vec<_>>(),
            "values": b.values().collect::<Vec<_>>(),
        })
    };
    let size = match &job.size {
        SizeSpec::Uniform { h } => json!({ "uniform": h }),
        SizeSpec::Sources { far, sources } => {
            let one = |s: &csalf_sizemap::Source| json!({ "xy": s.xy.to_array(), "h": s.h, "radius": s.radius, "falloff": s.falloff });
            json!({ "far": far, "sources": sources.iter().map(one).collect::<Vec<_>>() })
        }
        SizeSpec::Boundary => background(&of_boundary(&loops(job)).map_err(|e| e.to_string())?),
        SizeSpec::Background { points, triangles, values } => {
            json!({ "points": list(points), "triangles": triangles, "values": values })
        }
    };
    Ok(json!({
        "loops": nodes.iter().map(|l| list(l)).collect::<Vec<_>>(),
        "scars": job.domain.scars.iter().map(|s| list(&s.nodes)).collect::<Vec<_>>(),
        "points": job.domain.points.iter().map(|p| p.xy.to_array()).collect::<Vec<_>>(),
        "size": size,
    }))
}

/// The mesh that the script wrote, its elements counter-clockwise.
fn mesh_of(v: &Value) -> Option<QuadMesh> {
    let pair = |p: &Value| Some(Point2::new(p.get(0)?.as_f64()?, p.get(1)?.as_f64()?));
    let points: Vec<Point2> = v["points"].as_array()?.iter().map(pair).collect::<Option<_>>()?;
    let ids = |e: &Value| {
        let list = e.as_array()?.iter().map(|i| i.as_u64().map(|i| VertexId(i as u32)));
        let mut ids = list.collect::<Option<Vec<_>>>()?;
        let p = |k: usize| points.get(ids[k].index()).copied();
        let n = ids.len();
        let area = (1..n - 1).map(|k| Some((p(k)? - p(0)?).perp_dot(p(k + 1)? - p(0)?)));
        if area.sum::<Option<f64>>()? < 0.0 {
            ids.reverse();
        }
        Some(ids)
    };
    let quads = v["quads"].as_array()?.iter().map(|e| ids(e)?.try_into().ok());
    let triangles = v["triangles"].as_array()?.iter().map(|e| ids(e)?.try_into().ok());
    let (quads, triangles) = (quads.collect::<Option<_>>()?, triangles.collect::<Option<_>>()?);
    Some(QuadMesh { points, quads, triangles })
}

fn row(name: &str, ours: &Result1, theirs: Option<&Result1>) -> String {
    let both = |f: &dyn Fn(&Result1) -> String| match theirs {
        Some(t) => format!("{} / {}", f(ours), f(t)),
        None => f(ours),
    };
    let share = |x: Option<f64>| x.map_or("-".into(), |x| format!("{:.1}", 100.0 * x));
    let cells = [
        name.to_owned(),
        both(&|r| r.n_elements.to_string()),
        both(&|r| format!("{:.3}", r.quality.min_sj)),
        both(&|r| format!("{:.3}", r.quality.mean_sj)),
        both(&|r| share(r.quality.irregular_share)),
        both(&|r| share(r.quality.size.as_ref().map(|s| s.share))),
        both(&|r| share(r.quality.structure.as_ref().map(|s| s.row1_share))),
        both(&|r| format!("{:.1}", 1e6 / r.rate())),
        theirs.map_or("-".into(), |t| format!("{:.1}", ours.rate() / t.rate())),
        both(&|r| format!("{:.1}", r.rss_mb)),
    ];
    format!("| {} |", cells.join(" | "))
}

fn page(rows: &[(String, Option<f64>)], gmsh: Option<&str>, args: &CompareArgs) -> String {
    let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu.lines().find_map(|l| l.strip_prefix("model name")).unwrap_or("unknown processor");
    let model = model.trim_start_matches([' ', '\t', ':']);
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let mut out = String::from("# Benchmarks\n\n");
    let beside = gmsh.map_or(String::new(), |v| format!(" gmsh {v} (8, blossom) beside it in turn."));
    // Writing to a string cannot fail.
    let _ = write!(
        out,
        "Written by `cargo xtask compare{} --runs {}`. {model}, {cores} threads; one thread used.{beside} Each figure is \
         csalf's, then gmsh's. Times: processor time of the meshing alone in a process of its own, the least of {} runs, \
         microseconds per element; ratio: elements per processor second, csalf's over gmsh's. Memory: what the peak \
         of the process rose by. Irregular, size and row 1 in percent.\n\n",
        match (&args.cases, args.only.is_empty()) {
            (None, true) => "",
            (None, false) => " --only NAMES",
            (Some(_), true) => " --cases DIR",
            (Some(_), false) => " --cases DIR --only NAMES",
        },
        args.runs,
        args.runs,
    );
    out.push_str(
        "| job | elements | min SJ | mean SJ | irregular | size | row 1 | us / element | ratio | MB |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (row, _) in rows {
        out.push_str(row);
        out.push('\n');
    }
    let mut ratios: Vec<f64> = rows.iter().filter_map(|r| r.1).collect();
    ratios.sort_by(f64::total_cmp);
    if let (Some(least), Some(most)) = (ratios.first(), ratios.last()) {
        let median = ratios[ratios.len() / 2];
        let _ = write!(out, "\nRatio of speed: least {least:.1}, median {median:.1}, largest {most:.1}.\n");
    }
    out
}
