//! `csalf mesh MODEL --shard I/N` and `csalf stitch`: a model meshed by processes that know nothing of each other, for
//! job arrays, MPI or make.

use super::model;
use super::model_report::of_list;
use crate::args::{MeshArgs, StitchArgs};
use crate::exit::Failure;
use crate::files::{self, Output};
use crate::metrics::scaled_jacobians;
use crate::{json, logging, say};
use csalf_model::shard::{Shard, ShardError, Stitched, stitch};
use csalf_model::{Model, ModelOptions, Prepared};
use serde_json::{Map, Value};
use std::borrow::Cow;

/// Meshes a part of a model into a shard. Faces that fail are in it, and told; they are a failure of `csalf stitch`.
///
/// # Errors
/// [`Failure::Usage`] without one output, [`Failure::Files`].
pub(super) fn write_shard(
    model: &Model,
    options: &ModelOptions,
    (index, count): (u32, u32),
    args: &MeshArgs,
    level: i32,
) -> Result<(), Failure> {
    let [path] = args.output.as_slice() else {
        return Err(Failure::Usage("--shard writes one file: give one -o OUT.csalf-shard".into()));
    };
    let prepared = Prepared::new(Cow::Borrowed(model), options);
    let no_part = || Failure::Usage(format!("--shard: there is no part {index} of {count}"));
    let shard = prepared.shard(index, count, &()).ok_or_else(no_part)?;
    for f in shard.failures().filter(|_| level >= 0) {
        say::warning(&format!("{}: face {} has no mesh: {}", model.name, f.name, f.message));
    }
    let bytes = shard.to_bytes().map_err(|e| Failure::Unmeshed(e.to_string()))?;
    files::write(path, |sink| Ok(sink.write_all(&bytes)?))?;
    let (n_faces, n_quads) = (shard.n_faces(), shard.n_quads());
    if args.json && !files::is_standard(path) {
        let mut m = Map::new();
        m.insert("name".into(), model.name.clone().into());
        m.insert("shard".into(), Value::from(vec![index, count]));
        m.insert("n_faces".into(), n_faces.into());
        m.insert("n_quads".into(), n_quads.into());
        m.insert("n_failures".into(), shard.failures().count().into());
        say::out(&json::success(m))?;
    } else if level >= 0 && !files::is_standard(path) {
        let of = prepared.n_faces();
        let out = path.display();
        say::out(&format!(
            "{}: shard {index} of {count}, {n_faces} of {of} faces, {n_quads} quads\nwrote {out}",
            model.name
        ))?;
    }
    Ok(())
}

/// Runs `csalf stitch`.
///
/// # Errors
/// [`Failure::Invalid`] of shards that do not go together; [`Failure::Unmeshed`] if some faces have no mesh, after the
/// others are written.
pub fn run(args: &StitchArgs, level: i32) -> Result<(), Failure> {
    super::with_json(args.json, put_together(args, level))
}

fn put_together(args: &StitchArgs, level: i32) -> Result<(), Failure> {
    let mut outputs: Vec<Output> = Vec::new();
    for path in &args.output {
        let format = files::mesh_format(path, args.format.as_deref())?;
        outputs.push(Output { path: path.clone(), format });
    }
    if outputs.is_empty() && !args.json {
        return Err(Failure::Usage("nothing to write: give -o OUT (several are allowed) or --json".into()));
    }
    let to_stdout = outputs.iter().any(|o| files::is_standard(&o.path));
    if to_stdout && args.json {
        return Err(Failure::Usage("-o - and --json both want standard output".into()));
    }
    logging::install(level, None);
    let mut shards = Vec::with_capacity(args.shards.len());
    let mut errors: Vec<ShardError> = Vec::new();
    for path in &args.shards {
        match Shard::from_bytes(&files::shown(path), &files::read(path)?) {
            Ok(shard) => shards.push(shard),
            Err(e) => errors.push(e),
        }
    }
    let stitched = if errors.is_empty() { stitch(shards) } else { Err(errors) };
    let Stitched { name, faces, mesh } = stitched.map_err(|errors| Failure::Invalid {
        input: "the shards".into(),
        defects: errors.iter().map(ToString::to_string).collect(),
    })?;
    if level >= 0 {
        say::warnings(&name, &mesh.warnings);
    }
    model::write(&name, &mesh, None, args.element, &outputs)?;
    model::say_failures(&name, &mesh, outputs.first())?;
    let (least, mean) = of_list(&scaled_jacobians(&mesh.mesh));
    let (n_quads, n_nodes, n_failed) = (mesh.mesh.quads.len(), mesh.mesh.points.len(), mesh.failures.len());
    if args.json && n_failed == 0 {
        let mut m = Map::new();
        m.insert("name".into(), name.into());
        m.insert("n_shards".into(), args.shards.len().into());
        m.insert("n_faces".into(), faces.len().into());
        m.insert("n_vertices".into(), n_nodes.into());
        m.insert("n_quads".into(), n_quads.into());
        m.insert("min_sj".into(), least.into());
        m.insert("mean_sj".into(), mean.into());
        m.insert("n_free_sides".into(), mesh.n_free_sides.into());
        m.insert("n_branching_sides".into(), mesh.n_branching_sides.into());
        m.insert("n_warnings".into(), mesh.warnings.len().into());
        say::out(&json::success(m))?;
    } else if level >= 0 && !to_stdout && !args.json {
        let n_meshed = faces.len() - n_failed;
        let mut s = format!(
            "{name}: {} shards, {n_meshed} of {} faces, {n_quads} quads, {n_nodes} nodes\n\
               scaled Jacobian at least {least:.3}, mean {mean:.3}",
            args.shards.len(),
            faces.len()
        );
        let written: Vec<String> = outputs.iter().map(|o| o.path.display().to_string()).collect();
        if !written.is_empty() {
            s.push_str(&format!("\nwrote {}", written.join(", ")));
        }
        say::out(&s)?;
    }
    match n_failed {
        0 => Ok(()),
        n => Err(Failure::Unmeshed(format!("{n} of {} faces have no mesh", faces.len()))),
    }
}
