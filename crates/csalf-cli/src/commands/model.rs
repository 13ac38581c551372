//! `csalf mesh` of whole models: STEP files and facets.

use super::mesh::{Order, order, outputs};
use super::model_info;
use super::model_report::Done;
use crate::args::{ElementArg, MeshArgs};
use crate::config::{Extra, ModelKeys};
use crate::exit::Failure;
use crate::files::{self, Output};
use crate::metrics::scaled_jacobians;
pub use crate::model_file::format;
use crate::progress::{self, Progress};
use crate::timing::timed;
use crate::{json, layers, logging, model_file, page, say, second_order};
use csalf_core::Options;
use csalf_io::{CellData, MeshView, MidNodes, WriteOptions};
use csalf_model::brep::Model;
use csalf_model::{LoopLayers, ModelMesh, ModelOptions, SizeRules, mesh_model};
use glam::DVec3;
use std::fmt::Write as _;
use std::path::Path;

/// Reads a model, checks and sews it.
pub(super) fn read(path: &Path, format: &str, keys: &ModelKeys) -> Result<Model, Failure> {
    let bytes = files::read(path)?;
    model_file::read(&bytes, format, &files::shown(path), &files::stem(path), keys.reading())
}

/// Runs `csalf mesh` on a model.
///
/// # Errors
/// A [`Failure`]; if some faces have no mesh, after the others are written.
pub fn mesh(args: &MeshArgs, extra: &Extra, format: &str, level: i32) -> Result<(), Failure> {
    let input = args.input.clone().unwrap_or_default();
    let shown = files::shown(&input);
    let order = order(args)?;
    if order != Order::First && args.shard.is_some() {
        return Err(Failure::Usage(
            "--order 2 does not go with --shard: a stitched mesh knows no surfaces".into(),
        ));
    }
    let outputs = if args.shard.is_some() { Vec::new() } else { outputs(args)? };
    let report = args.report.as_deref();
    let options = options(args, extra)?;
    let keys = extra.model.clone().unwrap_or_default();
    let line = progress::wanted(level).then(Progress::start);
    logging::install(level, line.as_ref().map(Progress::stages));
    let (model, read_s) = timed(|| read(&input, format, &keys));
    let model = model?;
    if args.dry_run {
        drop(line);
        return model_info::show(&model, args.json);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.unwrap_or(0)).build();
    let pool = pool.map_err(|e| Failure::Usage(format!("--threads: {e}")))?;
    let options = ModelOptions { size: Some(sizes(args, &keys, &model)), ..options };
    if let Some(part) = args.shard {
        let written = pool.install(|| super::stitch::write_shard(&model, &options, part, args, level));
        drop(line);
        return written;
    }
    let (meshed, seconds) = timed(|| pool.install(|| mesh_model(&model, &options)));
    drop(line);
    if level >= 0 {
        say::warnings(&shown, &meshed.warnings);
    }
    let (written, write_s) = timed(|| {
        let mid = match order {
            Order::First => None,
            Order::Second { centres } => {
                Some(pool.install(|| second_order::of_model(&model, &meshed, centres)))
            }
        };
        write(&model.name, &meshed, mid.as_ref(), args.element, &outputs)
    });
    written?;
    say_failures(&shown, &meshed, outputs.first())?;
    let done = Done { model: &model, meshed: &meshed, outputs: &outputs, read_s, mesh_s: seconds, write_s };
    if let Some(path) = report {
        let text = match path.extension() {
            Some(e) if e.eq_ignore_ascii_case("html") => page_of(&done),
            _ => serde_json::to_string_pretty(&done.entries(true)).unwrap_or_default(),
        };
        files::write(path, |sink| Ok(writeln!(sink, "{text}")?))?;
    }
    let to_stdout = outputs.iter().any(|o| files::is_standard(&o.path));
    if args.json && meshed.failures.is_empty() {
        say::out(&json::success(done.entries(false)))?;
    } else if level >= 0 && !to_stdout && !args.json {
        say::out(&done.summary())?;
    }
    match meshed.failures.len() {
        0 => Ok(()),
        n => Err(Failure::Unmeshed(format!("{shown}: {n} of {} faces have no mesh", model.faces.len()))),
    }
}

/// The page of `--report FILE.html`.
fn page_of(done: &Done<'_>) -> String {
    let model = done.model;
    let mut about = format!("{} faces, {} edges", model.faces.len(), model.edges.len());
    if !model.unit.is_empty() {
        let _ = write!(about, ", in {}", model.unit.to_lowercase());
    }
    let mut entries = done.entries(true);
    // As of plane meshes, whose page it is.
    let layers = |l: &LoopLayers| {
        serde_json::json!({
            "loops": l.name, "asked": l.asked, "made": l.made, "stopped": l.why, "thickness_error": null
        })
    };
    entries.insert("layers".into(), done.meshed.layers.iter().map(layers).collect());
    let stages =
        serde_json::json!({ "read": done.read_s.wall, "mesh": done.mesh_s.wall, "write": done.write_s.wall });
    entries.insert("stages".into(), stages);
    let shown = page::ShownModel { meshed: done.meshed, entries, about: &about };
    page::model_page(&shown, &page::command_line())
}

/// Sizes: the command line, the table `[model]`, the defaults.
fn sizes(args: &MeshArgs, keys: &ModelKeys, model: &Model) -> SizeRules {
    let mut rules = args.size.map_or_else(|| SizeRules::of_model(model), SizeRules::of);
    rules.gradation = args.gradation.unwrap_or(rules.gradation);
    rules.min_size = keys.min_size.unwrap_or(rules.min_size);
    rules.per_turn = keys.per_turn.unwrap_or(rules.per_turn);
    rules.faces.clone_from(&keys.faces);
    rules.edges.clone_from(&keys.edges);
    rules
}

/// The options without the sizes.
fn options(args: &MeshArgs, extra: &Extra) -> Result<ModelOptions, Failure> {
    let layers = match &args.layers {
        Some(text) => layers::parse(text, args.layer_law.as_ref(), args.first_layer)
            .map_err(|e| Failure::Usage(format!("--layers: {e}")))?,
        None => extra.layers.clone(),
    };
    let mesher = Options {
        method: args.method.map(Into::into).unwrap_or_default(),
        preset: args.preset.map(Into::into).unwrap_or_default(),
        gradation: args.gradation,
        ..Options::default()
    };
    let keys = extra.model.clone().unwrap_or_default();
    Ok(ModelOptions {
        layers,
        loop_sizes: keys.loops,
        points: keys.points.into_iter().map(|(n, p)| (n, DVec3::from_array(p))).collect(),
        counts: keys.counts,
        mesher,
        ..ModelOptions::default()
    })
}

/// Says which faces have no mesh; their flat boundaries go beside the first output.
pub(super) fn say_failures(shown: &str, meshed: &ModelMesh, beside: Option<&Output>) -> Result<(), Failure> {
    for f in &meshed.failures {
        say::warning(&format!("{shown}: face {} has no mesh: {}", f.name, f.message));
        if let (Some(case), Some(out)) = (&f.case, beside) {
            write_case(case, &out.path)?;
        }
    }
    Ok(())
}

/// Writes the mesh with its sets, face numbers and scaled Jacobians.
pub(super) fn write(
    title: &str,
    meshed: &ModelMesh,
    mid: Option<&MidNodes>,
    element: Option<ElementArg>,
    outputs: &[Output],
) -> Result<(), Failure> {
    let (flat, heights) = meshed.mesh.split();
    let cell_data = [
        CellData { name: "face".into(), values: meshed.face_of_quad.iter().map(|f| f64::from(*f)).collect() },
        CellData { name: "scaled_jacobian".into(), values: scaled_jacobians(&meshed.mesh) },
    ];
    let view = MeshView { mesh: &flat, heights: &heights, sets: &meshed.sets, cell_data: &cell_data, title };
    let element = element.map(Into::into).unwrap_or_default();
    let how = WriteOptions { mid, element };
    outputs.iter().try_for_each(|o| files::write_mesh(&view, &how, o))
}

/// Writes the flat boundary of a failed face beside the mesh, as a job to reproduce it.
fn write_case(case: &csalf_core::Job, beside: &Path) -> Result<(), Failure> {
    if files::is_standard(beside) {
        return Ok(());
    }
    let plain: String = case.name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    let path = beside.with_file_name(format!("{}.{plain}.json", files::stem(beside)));
    files::write(&path, |sink| csalf_io::json::write(case, &csalf_io::JobOptions::default(), sink))
}
