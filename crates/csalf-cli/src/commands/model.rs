//! `csalf mesh` and `csalf info` of whole models: STEP files and facets.

use crate::args::{InfoArgs, MeshArgs};
use crate::exit::Failure;
use crate::files::{self, Output};
use crate::timing::{Seconds, timed};
use crate::{json, layers, logging, say};
use csalf_core::Options;
use csalf_geom::QuadId;
use csalf_io::facets::FacetFormat;
use csalf_io::{CellData, MeshView};
use csalf_mesh::SurfaceMesh;
use csalf_model::brep::{FaceShape, HoleShape, Model, loop_features};
use csalf_model::facets::{FacetOptions, model_of_triangles};
use csalf_model::{ModelMesh, ModelOptions, SizeRules, mesh_model};
use glam::DVec3;
use serde_json::{Map, Value};
use std::fmt::Write as _;
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
fn read(path: &Path, format: &str) -> Result<Model, Failure> {
    let bytes = files::read(path)?;
    let shown = files::shown(path);
    let mut model = match format {
        #[cfg(feature = "step")]
        "step" => csalf_step::read(&bytes)
            .map_err(|e| Failure::Invalid { input: shown.clone(), defects: vec![e.to_string()] })?,
        "stl" | "obj" | "ply" => facet_model(&bytes, format, &shown)?,
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
fn facet_model(bytes: &[u8], format: &str, shown: &str) -> Result<Model, Failure> {
    let format =
        FacetFormat::from_name(format).ok_or_else(|| Failure::Usage(format!("{shown}: {format}?")))?;
    let data = csalf_io::facets::read(format, bytes).map_err(|e| Failure::of_file(shown, &e))?;
    let points: Vec<DVec3> = data.points.into_iter().map(DVec3::from_array).collect();
    let model = model_of_triangles(&points, &data.triangles, &FacetOptions::default());
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
pub fn mesh(args: &MeshArgs, format: &str, level: i32) -> Result<(), Failure> {
    let input = args.input.clone().unwrap_or_default();
    let shown = files::shown(&input);
    if args.order == Some(2) {
        return Err(Failure::Usage(format!("{shown}: --order 2 is not for models yet")));
    }
    let mut outputs: Vec<Output> = Vec::new();
    for path in &args.output {
        outputs
            .push(Output { path: path.clone(), format: files::mesh_format(path, args.format.as_deref())? });
    }
    let table = match &args.layers {
        Some(text) => layers::parse(text, args.layer_law.as_ref(), args.first_layer)
            .map_err(|e| Failure::Usage(format!("--layers: {e}")))?,
        None => layers::Layers::new(),
    };
    logging::install(level, None);
    let model = read(&input, format)?;
    let mut size = args.size.map(SizeRules::of);
    if let (Some(rules), Some(g)) = (&mut size, args.gradation) {
        rules.gradation = g;
    }
    let mesher = Options {
        method: args.method.map(Into::into).unwrap_or_default(),
        preset: args.preset.map(Into::into).unwrap_or_default(),
        gradation: args.gradation,
        ..Options::default()
    };
    let options = ModelOptions { size, layers: table, mesher, ..ModelOptions::default() };
    let (meshed, seconds) = timed(|| mesh_model(&model, &options));
    if level >= 0 {
        say::warnings(&shown, &meshed.warnings);
    }
    if !outputs.is_empty() {
        write(&model, &meshed, &outputs)?;
    }
    for f in &meshed.failures {
        say::warning(&format!("{shown}: face {} has no mesh: {}", f.name, f.message));
        if let (Some(case), Some(out)) = (&f.case, outputs.first()) {
            write_case(case, &out.path)?;
        }
    }
    let to_stdout = outputs.iter().any(|o| files::is_standard(&o.path));
    if args.json {
        say::out(&json::success(entries(&model, &meshed, seconds)))?;
    } else if level >= 0 && !to_stdout {
        say::out(&summary(&model, &meshed, seconds, &outputs))?;
    }
    match meshed.failures.len() {
        0 => Ok(()),
        n => Err(Failure::Unmeshed(format!("{shown}: {n} of {} faces have no mesh", model.faces.len()))),
    }
}

/// Writes the mesh with its sets, face numbers and scaled Jacobians.
fn write(model: &Model, meshed: &ModelMesh, outputs: &[Output]) -> Result<(), Failure> {
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
    outputs.iter().try_for_each(|o| files::write_mesh(&view, &csalf_io::WriteOptions::default(), o))
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

/// Scaled Jacobian of each quad in space: the least over the corners, against the quad's mean normal.
fn scaled_jacobians(mesh: &SurfaceMesh) -> Vec<f64> {
    (0..mesh.quads.len())
        .map(|q| {
            let p = mesh.corners(QuadId(q as u32));
            let n = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
            let corner = |k: usize| {
                let (a, b) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
                a.cross(b).dot(n) / (a.length() * b.length())
            };
            (0..4).map(corner).fold(1.0, f64::min)
        })
        .collect()
}

/// Smallest and mean scaled Jacobian.
fn quality(meshed: &ModelMesh) -> (f64, f64) {
    let sj = scaled_jacobians(&meshed.mesh);
    let n = sj.len().max(1) as f64;
    (sj.iter().copied().fold(1.0, f64::min), sj.iter().sum::<f64>() / n)
}

fn summary(model: &Model, meshed: &ModelMesh, seconds: Seconds, outputs: &[Output]) -> String {
    let (least, mean) = quality(meshed);
    let n_faces = model.faces.len();
    let mut s = format!(
        "{}: {} of {n_faces} faces, {} quads, {} nodes in {:.3} s",
        model.name,
        n_faces - meshed.failures.len(),
        meshed.mesh.quads.len(),
        meshed.mesh.points.len(),
        seconds.wall
    );
    let _ = write!(s, "\nscaled Jacobian: mean {mean:.4}, least {least:.4}");
    let _ = write!(
        s,
        "\nsides of one quad only: {}; of three and more: {}",
        meshed.n_free_sides, meshed.n_branching_sides
    );
    for l in meshed.layers.iter().filter(|l| l.made < l.asked) {
        let _ = write!(s, "\n{}: {} of {} layers: {}", l.name, l.made, l.asked, l.why);
    }
    let files: Vec<String> = outputs
        .iter()
        .filter(|o| !files::is_standard(&o.path))
        .map(|o| o.path.display().to_string())
        .collect();
    if !files.is_empty() {
        let _ = write!(s, "\nwrote {}", files.join(", "));
    }
    s
}

fn entries(model: &Model, meshed: &ModelMesh, seconds: Seconds) -> Map<String, Value> {
    let (least, mean) = quality(meshed);
    let failures: Vec<Value> =
        meshed.failures.iter().map(|f| serde_json::json!({ "face": f.name, "message": f.message })).collect();
    let mut m = Map::new();
    m.insert("name".into(), model.name.clone().into());
    m.insert("n_faces".into(), model.faces.len().into());
    m.insert("n_vertices".into(), meshed.mesh.points.len().into());
    m.insert("n_quads".into(), meshed.mesh.quads.len().into());
    m.insert("min_sj".into(), least.into());
    m.insert("mean_sj".into(), mean.into());
    m.insert("n_free_sides".into(), meshed.n_free_sides.into());
    m.insert("n_branching_sides".into(), meshed.n_branching_sides.into());
    m.insert("mesh_s".into(), seconds.wall.into());
    m.insert("mesh_cpu_s".into(), seconds.cpu.into());
    m.insert("failures".into(), failures.into());
    m
}

/// Runs `csalf info` on a model.
///
/// # Errors
/// A [`Failure`].
pub fn info(args: &InfoArgs, format: &str) -> Result<(), Failure> {
    let model = read(&args.input, format)?;
    let holes = loop_features(&model);
    let (lo, hi) = model.bounds().unwrap_or_default();
    let free = model.edge_uses().iter().filter(|u| u.len() == 1).count();
    if args.json {
        let holes: Vec<Value> = holes
            .iter()
            .map(|h| {
                let name = &model.faces[h.face].name;
                serde_json::json!({ "name": h.name, "face": name, "diameter": h.shape.diameter(),
                    "center": h.center.to_array() })
            })
            .collect();
        let faces: Vec<Value> = model
            .faces
            .iter()
            .map(|f| serde_json::json!({ "name": f.name, "kind": kind(&f.shape), "n_loops": f.loops.len() }))
            .collect();
        let mut m = Map::new();
        m.insert("name".into(), model.name.clone().into());
        m.insert("unit".into(), model.unit.clone().into());
        m.insert("n_bodies".into(), model.bodies.len().into());
        m.insert("n_edges".into(), model.edges.len().into());
        m.insert("n_free_edges".into(), free.into());
        m.insert("box".into(), serde_json::json!([lo.to_array(), hi.to_array()]));
        m.insert("faces".into(), faces.into());
        m.insert("holes".into(), holes.into());
        m.insert("notes".into(), model.notes.clone().into());
        return say::out(&json::success(m));
    }
    let mut s = format!(
        "{}: {} bodies, {} faces, {} edges ({free} of one face only)",
        model.name,
        model.bodies.len(),
        model.faces.len(),
        model.edges.len()
    );
    let unit = if model.unit.is_empty() { "unknown" } else { &model.unit };
    let _ = write!(s, "\nunit {unit}; box ({}, {}, {}) to ({}, {}, {})", lo.x, lo.y, lo.z, hi.x, hi.y, hi.z);
    let mut kinds: Vec<&str> = model.faces.iter().map(|f| kind(&f.shape)).collect();
    kinds.sort_unstable();
    for run in kinds.chunk_by(|a, b| a == b) {
        let _ = write!(s, "\n{:6} faces: {}", run.len(), run[0]);
    }
    for h in &holes {
        let at = h.center;
        let shape = match h.shape {
            HoleShape::Circle { diameter } => format!("circle, diameter {diameter}"),
            HoleShape::Slot { width, length } => format!("slot, width {width}, length {length}"),
        };
        let face = &model.faces[h.face].name;
        let _ = write!(s, "\n{}: {shape}, at ({}, {}, {}), in {face}", h.name, at.x, at.y, at.z);
    }
    for note in &model.notes {
        let _ = write!(s, "\nnote: {note}");
    }
    say::out(&s)
}

fn kind(shape: &FaceShape) -> &'static str {
    match shape {
        FaceShape::Surface(s, _) => s.kind(),
        FaceShape::Facets(_) => "facets",
    }
}
