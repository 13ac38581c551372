//! `csalf info` of whole models.

use crate::args::InfoArgs;
use crate::config::ModelKeys;
use crate::exit::Failure;
use crate::{json, say};
use csalf_model::brep::{HoleShape, Model, loop_features};
use serde_json::{Map, Value};
use std::fmt::Write as _;

/// Runs `csalf info` on a model.
///
/// # Errors
/// A [`Failure`].
pub(super) fn info(args: &InfoArgs, format: &str) -> Result<(), Failure> {
    show(&super::model::read(&args.input, format, &ModelKeys::default())?, args.json)
}

/// Tells what is in a model.
///
/// # Errors
/// [`Failure::Files`] if it cannot be printed.
pub(super) fn show(model: &Model, as_json: bool) -> Result<(), Failure> {
    let holes = loop_features(model);
    let (lo, hi) = model.bounds().unwrap_or_default();
    let free = model.edge_uses().iter().filter(|u| u.len() == 1).count();
    if as_json {
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
            .map(|f| serde_json::json!({ "name": f.name, "kind": f.shape.kind(), "n_loops": f.loops.len() }))
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
    let mut kinds: Vec<&str> = model.faces.iter().map(|f| f.shape.kind()).collect();
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
