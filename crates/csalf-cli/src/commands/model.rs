//! `csalf mesh` of whole models: STEP files and facets.

use super::mesh::outputs;
use super::model_info;
use super::model_report::{Done, scaled_jacobians};
use crate::args::MeshArgs;
use crate::config::{Extra, ModelKeys};
use crate::exit::Failure;
use crate::files::{self, Output};
use crate::progress::{self, Progress};
use crate::timing::timed;
use crate::{json, layers, logging, say};
use csalf_core::Options;
use csalf_io::facets::FacetFormat;
use csalf_io::{CellData, MeshView};
use csalf_model::brep::Model;
use csalf_model::facets::{FacetOptions, model_of_triangles};
use csalf_model::{ModelMesh, ModelOptions, SizeRules, mesh_model};
use glam::DVec3;
use std::path::Path;

/// Edges closer than this share of the model's diagonal are sewn.
const SEWING: f64 = 1e-6;

/// The format of a model file, by the name given or the extension; `None` if it is no model.
pub fn format(path: &Path, name: Option<&str>) -> Option<&'static str> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let name = name.map(str::to_ascii_lowercase).or(extension)?;
    match name.as_str() {
        "step" | "stp" | "p21" => Some("step"),
        "stl" => Some("stl"),
        "obj" => Some("obj"),
        "ply" => Some("ply"),
        _ => None,
    }
}

/// Reads a model, checks and sews it.
pub(super) fn read(path: &Path, format: &str, keys: &ModelKeys) -> Result<Model, Failure> {
    let bytes = files::read(path)?;
    let shown = files::shown(path);
    let mut model = match format {
        #[cfg(feature = "step")]
        "step" => csalf_step::read(&bytes)
            .map_err(|e| Failure::Invalid { input: shown.clone(), defects: vec![e.to_string()] })?,
        "stl" | "obj" | "ply" => facet_model(&bytes, format, &shown, keys)?,
        _ => {
            let message = format!("{shown}: this program was built without a reader of {format}");
            let _ = bytes;
            return Err(Failure::Usage(message));
        }
    };
    if model.name.trim().is_empty() {
        model.name = files::stem(path);
    }
    let tolerance = SEWING * model.diagonal();
    let n_sewn = csalf_model::sew(&mut model, tolerance);
    if n_sewn > 0 {
        model.notes.push(format!("{n_sewn} edges were sewn to others at the same place"));
    }
    let report = csalf_model::check_and_snap(&mut model);
    model.notes.extend(report.messages);
    Ok(model)
}

/// Reads facets and makes faces of them.
fn facet_model(bytes: &[u8], format: &str, shown: &str, keys: &ModelKeys) -> Result<Model, Failure> {
    let format =
        FacetFormat::from_name(format).ok_or_else(|| Failure::Usage(format!("{shown}: {format}?")))?;
    let data = csalf_io::facets::read(format, bytes).map_err(|e| Failure::of_file(shown, &e))?;
    let points: Vec<DVec3> = data.points.into_iter().map(DVec3::from_array).collect();
    let mut options = FacetOptions::default();
    options.feature_angle = keys.feature_angle.unwrap_or(options.feature_angle);
    let model = model_of_triangles(&points, &data.triangles, &options);
    if model.faces.is_empty() {
        let defects = vec!["there is no triangle with an area in it".to_owned()];
        return Err(Failure::Invalid { input: shown.to_owned(), defects });
    }
    Ok(model)
}

/// Runs `csalf mesh` on a model.
///
/// # Errors
/// A [`Failure`]; if some faces have no mesh, after the others are written.
pub fn mesh(args: &MeshArgs, extra: &Extra, format: &str, level: i32) -> Result<(), Failure> {
    let input = args.input.clone().unwrap_or_default();
    let shown = files::shown(&input);
    if args.order == Some(2) || args.centres {
        return Err(Failure::Usage(format!("{shown}: --order 2 is not for models yet")));
    }
    let outputs = outputs(args)?;
    let report = args.report.as_deref();
    if report.is_some_and(|p| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("html"))) {
        let message = "the page of --report shows plane meshes; of a model, name a .json file";
        return Err(Failure::Usage(format!("{shown}: {message}")));
    }
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
    let (meshed, seconds) = timed(|| pool.install(|| mesh_model(&model, &options)));
    drop(line);
    if level >= 0 {
        say::warnings(&shown, &meshed.warnings);
    }
    let (written, write_s) = timed(|| write(&model, &meshed, args, &outputs));
    written?;
    for f in &meshed.failures {
        say::warning(&format!("{shown}: face {} has no mesh: {}", f.name, f.message));
        if let (Some(case), Some(out)) = (&f.case, outputs.first()) {
            write_case(case, &out.path)?;
        }
    }
    let done = Done { model: &model, meshed: &meshed, outputs: &outputs, read_s, mesh_s: seconds, write_s };
    if let Some(path) = report {
        let text = serde_json::to_string_pretty(&done.entries(true)).unwrap_or_default();
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

/// Writes the mesh with its sets, face numbers and scaled Jacobians.
fn write(model: &Model, meshed: &ModelMesh, args: &MeshArgs, outputs: &[Output]) -> Result<(), Failure> {
    let (flat, heights) = meshed.mesh.split();
    let cell_data = [
        CellData { name: "face".into(), values: meshed.face_of_quad.iter().map(|f| f64::from(*f)).collect() },
        CellData { name: "scaled_jacobian".into(), values: scaled_jacobians(&meshed.mesh) },
    ];
    let view = MeshView {
        mesh: &flat,
        heights: &heights,
        sets: &meshed.sets,
        cell_data: &cell_data,
        title: &model.name,
    };
    let element = args.element.map(Into::into).unwrap_or_default();
    let how = csalf_io::WriteOptions { element, ..csalf_io::WriteOptions::default() };
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
