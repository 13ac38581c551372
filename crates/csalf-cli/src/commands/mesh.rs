//! `csalf mesh`: outlines in, meshes out.
//!
//! 1. `settle`: the command line, the `--config` file and the options in the job file become one plan; every
//!    wrong option and unknown format is found before any work is done.
//! 2. [`mesh_one`]: meshes a job, measures time and quality, writes the files.
//! 3. `finish`: summary, `--report`, and with `--json` the last line.
//!
//! An input with several outlines gives one mesh each; one that fails does not lose the others.

use super::model;
use crate::args::MeshArgs;
use crate::config::Extra;
use crate::exit::Failure;
use crate::files::{self, Output};
use crate::outlines::{self, Wish};
use crate::progress::{self, Progress};
use crate::timing::{Seconds, timed};
use crate::{config, json, layers, logging, page, say, summary};
use csalf_core::{Job, Meshed, Options};
use csalf_geom::Geometry;
use csalf_io::inp::InpElement;
use csalf_io::{CellData, JobFormat, JobOptions, MeshView, MidNodes, WriteOptions};
use csalf_mesh::digest;
use csalf_mesh::quality::{QualityReport, metrics};
use csalf_sizemap::SizeField;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Runs the command.
///
/// # Errors
/// A [`Failure`]; of several outlines, that of the first one that failed.
pub fn run(args: &MeshArgs, level: i32) -> Result<(), Failure> {
    let mut json = args.json;
    let result = merged(args).and_then(|(args, extra)| {
        json |= args.json;
        match args.input.as_deref().and_then(|p| model::format(p, args.input_format.as_deref())) {
            Some(format) => model::mesh(&args, &extra, format, level),
            None => settle(args, extra).and_then(|plan| execute(&plan, level)),
        }
    });
    super::with_json(json, result)
}

/// All options, checked; formats of all files known.
#[derive(Clone, Debug)]
struct Plan {
    args: MeshArgs,
    input: PathBuf,
    input_format: JobFormat,
    outputs: Vec<Output>,
    /// Replace those of the job where not empty.
    layers: layers::Layers,
}

/// The order of the elements that is asked for.
pub(super) fn order(args: &MeshArgs) -> Result<Order, Failure> {
    match (args.order, args.centres) {
        (Some(2), centres) => Ok(Order::Second { centres }),
        (_, true) => Err(Failure::Usage("--centres goes with --order 2".into())),
        _ => Ok(Order::First),
    }
}

/// The command line, and the `--config` file below it.
fn merged(args: &MeshArgs) -> Result<(MeshArgs, Extra), Failure> {
    let Some(path) = &args.config else { return Ok((args.clone(), Extra::default())) };
    let bytes = files::read(path)?;
    let name = path.display();
    let text = String::from_utf8(bytes).map_err(|e| Failure::Usage(format!("{name}: {e}")))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    config::merge(args, &text, folder).map_err(|e| Failure::Usage(format!("{name}: {e}")))
}

/// Settles the formats.
fn settle(args: MeshArgs, extra: Extra) -> Result<Plan, Failure> {
    let mut table = extra.layers;
    if args.shard.is_some() {
        return Err(Failure::Usage("--shard is for models".into()));
    }
    if extra.model.is_some() {
        return Err(Failure::Usage("[model] in the configuration is for models, not for outlines".into()));
    }
    let input = args.input.clone().ok_or_else(|| Failure::Usage("no input: name one, or `-`".into()))?;
    let input_format = files::job_format(&input, args.input_format.as_deref())?;
    let outputs = outputs(&args)?;
    order(&args)?;
    if let Some(text) = &args.layers {
        table = layers::parse(text, args.layer_law.as_ref(), args.first_layer)
            .map_err(|e| Failure::Usage(format!("--layers: {e}")))?;
    }
    Ok(Plan { args, input, input_format, outputs, layers: table })
}

/// The files to write, their formats known.
pub(super) fn outputs(args: &MeshArgs) -> Result<Vec<Output>, Failure> {
    let mut outputs = Vec::with_capacity(args.output.len());
    for path in &args.output {
        let format = files::mesh_format(path, args.format.as_deref())?;
        if outputs.iter().any(|o: &Output| o.path == *path) {
            return Err(Failure::Usage(format!("the output {} is named twice", path.display())));
        }
        outputs.push(Output { path: path.clone(), format });
    }
    if outputs.is_empty() && !args.dry_run && !args.json && args.report.is_none() {
        return Err(Failure::Usage(
            "nothing to write: give -o OUT (several are allowed), --json or --report".into(),
        ));
    }
    if args.json && outputs.iter().any(|o| files::is_standard(&o.path)) {
        return Err(Failure::Usage(
            "-o - and --json both want standard output: write the mesh to a file, or use --report".into(),
        ));
    }
    Ok(outputs)
}

/// Reads, meshes, writes, reports.
fn execute(plan: &Plan, level: i32) -> Result<(), Failure> {
    let shown = files::shown(&plan.input);
    let mut read = files::read_jobs(&plan.input, plan.input_format)?;
    let wish = Wish { size: plan.args.size, resample: plan.args.resample };
    let mut outlines = outlines::jobs(read.input, &files::stem(&plan.input), wish, &mut read.notes);
    outlines.iter_mut().filter_map(|o| o.job.as_mut().ok()).for_each(|job| override_layers(job, plan));
    read.notes.extend(unmatched(&outlines));
    if level >= 0 {
        say::warnings(&shown, &read.notes);
    }
    let n = outlines.len();
    if n > 1 && plan.outputs.iter().any(|o| files::is_standard(&o.path)) {
        return Err(Failure::Usage(format!("{shown}: {n} outlines do not fit into one stream: use files")));
    }
    let options = options(&read.options, &plan.args);
    if plan.args.dry_run {
        return super::dry_run::run(&shown, &outlines, &options, &plan.outputs, plan.args.json);
    }
    let mut done = Vec::with_capacity(n);
    let mut failures = Vec::new();
    for (k, outline) in outlines.iter().enumerate() {
        let input = shown_outline(&shown, &outline.name, n);
        let outputs: Vec<Output> = plan
            .outputs
            .iter()
            .map(|o| Output { path: path_of(&o.path, &outline.name, k, n), ..o.clone() })
            .collect();
        let (order, element) = (order(&plan.args)?, plan.args.element.map(Into::into).unwrap_or_default());
        let geometry = outline.geometry.as_ref();
        let request = Request {
            input: &input,
            options: options.clone(),
            outputs: &outputs,
            level,
            order,
            element,
            geometry,
        };
        let result = match &outline.job {
            Ok(job) => mesh_one(job, &request),
            Err(defects) => Err(Failure::Invalid { input, defects: defects.clone() }),
        };
        match result {
            Ok(d) => done.push(d),
            Err(f) => failures.push(f),
        }
    }
    finish(plan, &done, n, failures, level)
}

/// How one outline of `n` is called in messages.
pub(super) fn shown_outline(shown: &str, name: &str, n: usize) -> String {
    if n == 1 { shown.to_owned() } else { format!("{shown} ({name})") }
}

/// Layers asked for that no loop, scar or point has a name for, one sentence each.
fn unmatched(outlines: &[outlines::Outline]) -> Vec<String> {
    let jobs: Vec<&Job> = outlines.iter().filter_map(|o| o.job.as_ref().ok()).collect();
    let mut patterns: Vec<&str> = jobs.iter().flat_map(|j| j.unmatched_layers()).collect();
    patterns.sort_unstable();
    patterns.dedup();
    // Layers of the command line go to all outlines: one that takes them is enough.
    patterns.retain(|p| {
        jobs.iter().all(|j| !j.layers.iter().any(|l| l.0 == *p) || j.unmatched_layers().contains(p))
    });
    patterns
        .iter()
        .map(|p| format!("layers for '{p}': nothing has such a name (`csalf info` lists the loops)"))
        .collect()
}

/// The options of the run: the command line over the config file over the job file over the defaults.
fn options(of_job: &JobOptions, args: &MeshArgs) -> Options {
    let mut o = Options::default();
    of_job.apply(&mut o);
    if let Some(m) = args.method {
        o.method = m.into();
    }
    if let Some(p) = args.preset {
        o.preset = p.into();
    }
    if let Some(n) = args.threads {
        o.threads = n;
    }
    if args.gradation.is_some() {
        o.gradation = args.gradation;
    }
    o.allow_triangles |= args.allow_triangles;
    o.repair_parity |= args.repair_parity;
    o
}

/// Layers of the command line in place of those of the job. Without new layers, a law or first thickness of the
/// command line goes to the layers that the job has.
fn override_layers(job: &mut Job, plan: &Plan) {
    if !plan.layers.is_empty() {
        job.layers.clone_from(&plan.layers);
        return;
    }
    for (_, spec) in &mut job.layers {
        if let Some(law) = &plan.args.layer_law {
            spec.law = law.clone();
        }
        if plan.args.first_layer.is_some() {
            spec.first = plan.args.first_layer;
        }
    }
}

/// Where outline `k` of `n` goes: with several, number and name are put before the extension.
pub(super) fn path_of(path: &Path, name: &str, k: usize, n: usize) -> PathBuf {
    if n == 1 {
        return path.to_owned();
    }
    let safe: String = name.chars().map(|c| if c.is_alphanumeric() || c == '-' { c } else { '_' }).collect();
    let extension = path.extension().map(|e| e.to_string_lossy().into_owned()).unwrap_or_default();
    path.with_file_name(format!("{}_{k}_{safe}.{extension}", files::stem(path)))
}

/// One job to be meshed.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// Name of the input, for messages.
    pub input: &'a str,
    /// Options of the mesher.
    pub options: Options,
    /// Files to write.
    pub outputs: &'a [Output],
    /// Verbosity, -1 to 3.
    pub level: i32,
    /// Order of the elements in the files.
    pub order: Order,
    /// Elements of `.inp` files.
    pub element: InpElement,
    /// The curves that the nodes of the job lie on, for mid-side nodes.
    pub geometry: Option<&'a Geometry>,
}

/// Order of the elements in the files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Corners alone.
    #[default]
    First,
    /// Mid-side nodes, and with `centres` one in the middle of each quad.
    Second {
        /// Nine nodes per quad.
        centres: bool,
    },
}

/// One job, meshed and written.
#[derive(Debug)]
pub struct Done {
    /// Name of the job.
    pub name: String,
    /// What came out.
    pub meshed: Meshed,
    /// Times of the meshing alone.
    pub seconds: Seconds,
    /// Figures of the mesh.
    pub quality: QualityReport,
    /// Files written.
    pub outputs: Vec<Output>,
    /// The sizes that were asked for; `None` if they cannot be built.
    field: Option<Arc<dyn SizeField>>,
    about: String,
}

impl Done {
    /// A few lines for a person.
    pub fn summary(&self) -> String {
        let mut s = summary::of_mesh(&self.name, &self.meshed, self.seconds, &self.quality);
        let files: Vec<String> = self
            .outputs
            .iter()
            .filter(|o| !files::is_standard(&o.path))
            .map(|o| o.path.display().to_string())
            .collect();
        if !files.is_empty() {
            s.push_str(&format!("\nwrote {}", files.join(", ")));
        }
        s
    }

    /// The entries of the JSON report.
    fn entries(&self, full: bool) -> Map<String, Value> {
        let mesh = &self.meshed.mesh;
        let mut m = Map::new();
        m.insert("name".into(), self.name.clone().into());
        m.insert("n_vertices".into(), mesh.n_vertices().into());
        m.insert("n_quads".into(), mesh.n_quads().into());
        m.insert("n_triangles".into(), mesh.triangles.len().into());
        m.insert("mesh_s".into(), self.seconds.wall.into());
        m.insert("mesh_cpu_s".into(), self.seconds.cpu.into());
        m.insert("quality".into(), json::quality(&self.quality, full));
        m.insert("digest".into(), digest(mesh, &[]).into());
        m.extend(json::report(&self.meshed.report, full));
        let outputs: Vec<String> = self.outputs.iter().map(|o| o.path.display().to_string()).collect();
        m.insert("outputs".into(), outputs.into());
        m
    }
}

/// Meshes a job and writes its files. Warnings go to standard error.
///
/// # Errors
/// [`Failure::Invalid`], [`Failure::Unmeshed`] or [`Failure::Files`].
pub fn mesh_one(job: &Job, request: &Request<'_>) -> Result<Done, Failure> {
    let line = progress::wanted(request.level).then(Progress::start);
    logging::install(request.level, line.as_ref().map(Progress::stages));
    let (meshed, seconds) = timed(|| csalf_core::mesh(job, &request.options));
    drop(line);
    let meshed = meshed.map_err(|e| Failure::of_meshing(request.input, &e))?;
    if request.level >= 0 {
        say::warnings(request.input, &meshed.report.warnings);
    }
    if !request.outputs.is_empty() {
        let cell_data = [scaled_jacobians(&meshed)];
        let view = MeshView {
            mesh: &meshed.mesh,
            heights: &[],
            sets: &meshed.sets,
            cell_data: &cell_data,
            title: &job.name,
        };
        let mid = match (request.order, request.geometry) {
            (Order::First, _) => None,
            (Order::Second { centres }, None) => Some(MidNodes::new(&meshed.mesh, centres)),
            (Order::Second { centres }, Some(g)) => {
                Some(MidNodes::on_curves(&meshed.mesh, &meshed.sets, g, centres))
            }
        };
        let how = WriteOptions { mid: mid.as_ref(), element: request.element };
        for o in request.outputs {
            files::write_mesh(&view, &how, o)?;
        }
    }
    let field = size_field(job, request.options.gradation);
    let quality = QualityReport::new(&meshed.mesh, field.as_deref(), job.local_region);
    Ok(Done {
        name: job.name.clone(),
        meshed,
        seconds,
        quality,
        outputs: request.outputs.to_vec(),
        field,
        about: job.about.clone(),
    })
}

/// The size field that the job asks for, to compare the mesh with; `None` if it cannot be built.
pub fn size_field(job: &Job, gradation: Option<f64>) -> Option<Arc<dyn SizeField>> {
    job.size_field(gradation).ok()
}

/// The scaled Jacobian of every element, for viewers.
fn scaled_jacobians(meshed: &Meshed) -> CellData {
    let name = "scaled_jacobian";
    CellData { name: name.into(), values: metrics::values(&meshed.mesh, name, None).unwrap_or_default() }
}

/// Says what was done, and what was not.
fn finish(
    plan: &Plan,
    done: &[Done],
    n_outlines: usize,
    failures: Vec<Failure>,
    level: i32,
) -> Result<(), Failure> {
    if let Some(path) = &plan.args.report {
        let is_page = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("html"));
        let all: Vec<Value> = done.iter().map(|d| Value::Object(d.entries(true))).collect();
        let text =
            if is_page { page_of(done) } else { serde_json::to_string_pretty(&all).unwrap_or_default() };
        files::write(path, |sink| Ok(writeln!(sink, "{text}")?))?;
    }
    let to_stdout = plan.outputs.iter().any(|o| files::is_standard(&o.path));
    if level >= 0 && !plan.args.json && !to_stdout {
        for d in done {
            say::out(&d.summary())?;
        }
    }
    if failures.is_empty() {
        if plan.args.json {
            say::out(&json::success(entries_of(done)))?;
        }
        return Ok(());
    }
    several(failures, n_outlines)
}

/// The page of `--report FILE.html`.
fn page_of(done: &[Done]) -> String {
    let shown: Vec<page::Shown<'_>> = done
        .iter()
        .map(|d| page::Shown {
            meshed: &d.meshed,
            quality: &d.quality,
            field: d.field.as_deref(),
            entries: d.entries(true),
            about: &d.about,
        })
        .collect();
    page::page(&shown, &page::command_line())
}

/// One failure out of those of `n_outlines` outlines; more than one outline: each is reported here.
pub(super) fn several(mut failures: Vec<Failure>, n_outlines: usize) -> Result<(), Failure> {
    if n_outlines == 1 {
        return failures.pop().map_or(Ok(()), Err);
    }
    let Some(code) = failures.iter().map(Failure::code).max() else { return Ok(()) };
    failures.iter().for_each(say::failure);
    Err(Failure::Several { code, n_outlines, errors: failures.iter().map(ToString::to_string).collect() })
}

/// The entries of one run; of several jobs, sums.
fn entries_of(done: &[Done]) -> Map<String, Value> {
    if let [one] = done {
        return one.entries(false);
    }
    let sum = |f: &dyn Fn(&Done) -> usize| Value::from(done.iter().map(f).sum::<usize>());
    let seconds = |f: &dyn Fn(&Done) -> f64| Value::from(done.iter().map(f).sum::<f64>());
    let least = done.iter().map(|d| d.quality.min_sj).fold(1.0, f64::min);
    let mut m = Map::new();
    m.insert("n_jobs".into(), done.len().into());
    m.insert("n_vertices".into(), sum(&|d| d.meshed.mesh.n_vertices()));
    m.insert("n_quads".into(), sum(&|d| d.meshed.mesh.n_quads()));
    m.insert("n_triangles".into(), sum(&|d| d.meshed.mesh.triangles.len()));
    m.insert("mesh_s".into(), seconds(&|d| d.seconds.wall));
    m.insert("mesh_cpu_s".into(), seconds(&|d| d.seconds.cpu));
    m.insert("min_sj".into(), least.into());
    m.insert("n_warnings".into(), sum(&|d| d.meshed.report.warnings.len()));
    m
}
