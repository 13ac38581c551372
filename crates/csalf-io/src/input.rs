//! What a job reader gives back: jobs that can be meshed as they are, or raw curves that must first be given nodes.

use crate::{IoError, JobFormat, JobOptions, dxf, geojson, json, msh, poly, svg, topojson};
use csalf_core::Job;
use csalf_geom::Geometry;
use std::path::Path;

/// What a file held.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Input {
    /// Discretised domains: every point of the file is a mesh node.
    Jobs(Vec<Job>),
    /// Raw curves, to be discretised with a size first (`csalf_sizemap::discretize`).
    Curves(Vec<NamedGeometry>),
}

/// One outline of curves and its name (empty if the file has none).
#[derive(Clone, Debug, PartialEq, Default)]
pub struct NamedGeometry {
    /// Name of the outline.
    pub name: String,
    /// Loops, scars, points.
    pub geometry: Geometry,
}

/// What a job reader gives back.
#[derive(Clone, Debug, PartialEq)]
pub struct JobInput {
    /// Jobs or curves, at least one.
    pub input: Input,
    /// Options that the file asks for.
    pub options: JobOptions,
    /// What was left out, repaired or not understood, one sentence each.
    pub notes: Vec<String>,
}

/// Reads jobs from bytes of a known format.
///
/// # Errors
/// [`IoError::Syntax`], [`IoError::Unsupported`] or [`IoError::Empty`].
pub fn read_job_bytes(format: JobFormat, bytes: &[u8]) -> Result<JobInput, IoError> {
    match format {
        JobFormat::Json => match json_kind(bytes) {
            JsonKind::Job => {
                let doc = json::read(bytes)?;
                Ok(JobInput { input: Input::Jobs(vec![doc.job]), options: doc.options, notes: doc.notes })
            }
            JsonKind::GeoJson => geojson::read(bytes),
            JsonKind::TopoJson => topojson::read(bytes),
        },
        JobFormat::GeoJson => geojson::read(bytes),
        JobFormat::TopoJson => topojson::read(bytes),
        JobFormat::Poly => poly::read(bytes),
        JobFormat::Msh => msh::read_job(bytes),
        JobFormat::Dxf => dxf::read(bytes),
        JobFormat::Svg => svg::read(bytes),
    }
}

/// Reads jobs from a file, in the format that its extension means. Jobs without a name get that of the file.
///
/// # Errors
/// [`IoError::Open`] and [`IoError::UnknownFormat`], and those of [`read_job_bytes`].
pub fn read_job(path: &Path) -> Result<JobInput, IoError> {
    let format = JobFormat::from_path(path)?;
    let bytes = std::fs::read(path).map_err(|source| IoError::Open { path: path.to_owned(), source })?;
    let mut out = read_job_bytes(format, &bytes)?;
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let mut names: Vec<&mut String> = match &mut out.input {
        Input::Jobs(jobs) => jobs.iter_mut().map(|j| &mut j.name).collect(),
        Input::Curves(curves) => curves.iter_mut().map(|c| &mut c.name).collect(),
    };
    let n = names.len();
    for (k, name) in names.iter_mut().enumerate().filter(|(_, name)| name.is_empty()) {
        **name = crate::rings::part_name(&stem, k, n);
    }
    Ok(out)
}

/// What a `.json` file holds.
enum JsonKind {
    Job,
    GeoJson,
    TopoJson,
}

/// Tells by the key `type`, which jobs do not have.
fn json_kind(bytes: &[u8]) -> JsonKind {
    #[derive(serde::Deserialize)]
    struct Head {
        #[serde(rename = "type")]
        kind: Option<String>,
    }
    match serde_json::from_slice::<Head>(bytes).ok().and_then(|h| h.kind).as_deref() {
        Some("Topology") => JsonKind::TopoJson,
        Some("FeatureCollection" | "Feature" | "Polygon" | "MultiPolygon" | "GeometryCollection") => {
            JsonKind::GeoJson
        }
        _ => JsonKind::Job,
    }
}
