//! Models from files: read, sewn, checked.

use crate::exit::Failure;
use csalf_io::facets::FacetFormat;
use csalf_model::Model;
use csalf_model::facets::{FacetOptions, model_of_triangles};
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
        "igs" | "iges" => Some("iges"),
        "brep" | "brp" => Some("brep"),
        _ => None,
    }
}

/// The model in the bytes of a file that messages call `shown`; named `name` if the file does not name it. Facets fall
/// into faces where the normal turns by more than `feature_angle` degrees.
///
/// # Errors
/// [`Failure::Invalid`] if it is no such file, [`Failure::Usage`] if this program cannot read it.
pub fn read(
    bytes: &[u8],
    format: &str,
    shown: &str,
    name: &str,
    feature_angle: Option<f64>,
) -> Result<Model, Failure> {
    let mut model = match format {
        #[cfg(feature = "step")]
        "step" => csalf_step::read(bytes)
            .map_err(|e| Failure::Invalid { input: shown.to_owned(), defects: vec![e.to_string()] })?,
        "stl" | "obj" | "ply" => facet_model(bytes, format, shown, feature_angle)?,
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
