//! Models from files: read, sewn, checked.

use crate::exit::Failure;
use csalf_io::facets::FacetFormat;
use csalf_model::facets::{FacetOptions, model_of_triangles};
use csalf_model::{Model, Sewn};
use glam::DVec3;
use std::path::Path;

/// A sewing length of more than this share of the diagonal is a mistake in the units, and would take parts of the model
/// away.
const MOST_SEWING: f64 = 0.01;

/// What there is to say of reading a model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Facets fall into faces where the normal turns by more degrees; by default [`FacetOptions::default`].
    pub feature_angle: Option<f64>,
    /// Edges within this distance are sewn, length; by default [`csalf_model::sew_closed`] chooses. Facets are not.
    pub sewing: Option<f64>,
}

/// The format of a model file, by the name given or the extension; `None` if it is no model.
pub fn format(path: &Path, name: Option<&str>) -> Option<&'static str> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let name = name.map(str::to_ascii_lowercase).or(extension)?;
    match name.as_str() {
        "step" | "stp" | "p21" => Some("step"),
        "stl" => Some("stl"),
        "obj" => Some("obj"),
        "ply" => Some("ply"),
        "igs" | "iges" => Some("iges"),
        "brep" | "brp" => Some("brep"),
        _ => None,
    }
}

/// The model in the bytes of a file that messages call `shown`; named `name` if the file does not name it.
///
/// # Errors
/// [`Failure::Invalid`] if it is no such file, [`Failure::Usage`] if this program cannot read it.
pub fn read(bytes: &[u8], format: &str, shown: &str, name: &str, how: Reading) -> Result<Model, Failure> {
    let mut model = match format {
        #[cfg(feature = "step")]
        "step" => csalf_step::read(bytes)
            .map_err(|e| Failure::Invalid { input: shown.to_owned(), defects: vec![e.to_string()] })?,
        "stl" | "obj" | "ply" => facet_model(bytes, format, shown, how.feature_angle)?,
        "iges" | "brep" => {
            let message = format!(
                "{shown}: {format} is read by Open CASCADE, in Python: pip install 'csalf[cad]', then \
                 python -m csalf.cad {shown} part.step"
            );
            return Err(Failure::Usage(message));
        }
        _ => {
            let message = format!("{shown}: this program was built without a reader of {format}");
            return Err(Failure::Usage(message));
        }
    };
    if model.name.trim().is_empty() {
        model.name = name.to_owned();
    }
    let diagonal = model.diagonal();
    if let Some(sewing) = how.sewing.filter(|s| *s > MOST_SEWING * diagonal) {
        let message =
            format!("sewing within {sewing} would join all that is near in a model of {diagonal:.3e} across");
        return Err(Failure::Usage(format!("{shown}: {message}")));
    }
    let sewn = match how.sewing {
        Some(tolerance) => csalf_model::sew(&mut model, tolerance),
        None => csalf_model::sew_closed(&mut model),
    };
    model.notes.extend(told(&sewn, &model));
    let n_turned = csalf_model::turn_alike(&mut model);
    if n_turned > 0 {
        model.notes.push(format!("{n_turned} faces were turned round, to agree with their neighbours"));
    }
    let report = csalf_model::check_and_snap(&mut model);
    model.notes.extend(report.messages);
    Ok(model)
}

/// What was sewn and what was not, in words.
fn told(sewn: &Sewn, model: &Model) -> Vec<String> {
    let within = format!("within {:.3e}", sewn.tolerance);
    let mut notes = Vec::new();
    if sewn.n_edges > 0 {
        let cuts = if sewn.n_cuts > 0 {
            format!(", after {} cuts where others end", sewn.n_cuts)
        } else {
            String::new()
        };
        notes.push(format!("{} edges were sewn to others {within}{cuts}", sewn.n_edges));
    }
    notes.extend(
        sewn.slivers.iter().map(|name| format!("{name}: left out, as all of it lies {within} of its edges")),
    );
    let n_free = model.free_edges().count();
    if n_free > 0 && model.bodies.iter().any(|b| b.solid) {
        notes.push(format!(
            "{n_free} edges bound one face only, though the model is of solids: a larger sewing length may join them"
        ));
    }
    notes
}

/// Reads facets and makes faces of them.
fn facet_model(
    bytes: &[u8],
    format: &str,
    shown: &str,
    feature_angle: Option<f64>,
) -> Result<Model, Failure> {
    let format =
        FacetFormat::from_name(format).ok_or_else(|| Failure::Usage(format!("{shown}: {format}?")))?;
    let data = csalf_io::facets::read(format, bytes).map_err(|e| Failure::of_file(shown, &e))?;
    let points: Vec<DVec3> = data.points.into_iter().map(DVec3::from_array).collect();
    let mut options = FacetOptions::default();
    options.feature_angle = feature_angle.unwrap_or(options.feature_angle);
    let model = model_of_triangles(&points, &data.triangles, &options);
    if model.faces.is_empty() {
        let defects = vec!["there is no triangle with an area in it".to_owned()];
        return Err(Failure::Invalid { input: shown.to_owned(), defects });
    }
    Ok(model)
}
