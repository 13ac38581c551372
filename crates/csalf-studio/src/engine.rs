//! The three requests of the page. No state, no panic: what is wrong with the input goes into the answer.

use crate::{Document, reply};
use csalf_core::{MeshError, Watch};
use csalf_io::{CellData, IoError, JobFormat, MeshFormat, MeshView, json, read_job_bytes, write_mesh};
use csalf_mesh::quality::metrics;
use serde::Serialize;
use serde_json::value::RawValue;
use std::path::Path;

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Refused {
    /// The file or document cannot be read, or the mesh not be written in this format.
    #[error(transparent)]
    Io(#[from] IoError),
    /// There is no mesh to be exported.
    #[error("{0}")]
    Mesh(#[from] MeshError),
    /// The curves of the document got no nodes.
    #[error("{0}")]
    Unplaced(#[from] csalf_io::outlines::Unplaced),
    /// Nothing is written in the format of this name.
    #[error("'{0}' is not a format that the studio writes")]
    Format(String),
}

#[derive(Serialize)]
struct Opened {
    documents: Vec<Box<RawValue>>,
    notes: Vec<String>,
}

/// The documents in a file, as JSON: `{"documents": [...], "notes": [...]}`. The name tells the format.
///
/// # Errors
/// [`Refused::Io`].
pub fn open(name: &str, bytes: &[u8]) -> Result<Vec<u8>, Refused> {
    let path = Path::new(name);
    let read = read_job_bytes(JobFormat::from_path(path)?, bytes)?;
    let notes = read.notes.clone();
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let documents = Document::of_input(read, &stem);
    let documents = documents.iter().map(Document::write).collect::<Result<Vec<_>, _>>()?;
    Ok(serde_json::to_vec(&Opened { documents, notes }).unwrap_or_default())
}

/// Meshes a document; the answer is a [`reply`], also if the domain is invalid.
///
/// # Errors
/// [`Refused::Io`] if the document cannot be read, [`Refused::Mesh`] if `watch` ended the run.
pub fn mesh(document: &[u8], watch: &dyn Watch) -> Result<Vec<u8>, Refused> {
    let document = Document::read(document)?;
    let ready = match document.ready() {
        Ok(ready) => ready,
        Err(why) => return Ok(reply::unplaced(&document, &why)),
    };
    let mut notes = document.notes.clone();
    let unmatched = ready.job.unmatched_layers();
    notes.extend(unmatched.iter().map(|p| format!("layers for '{p}': nothing has such a name")));
    let options = document.run_options();
    match csalf_core::mesh_watched(&ready.job, &options, watch) {
        Ok(meshed) => Ok(reply::done(&ready, &notes, &meshed, options.gradation)),
        Err(MeshError::Cancelled) => Err(MeshError::Cancelled.into()),
        Err(why) => Ok(reply::refused(&ready, &notes, &why)),
    }
}

/// A file made for the person.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported {
    /// Name to save it under.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Meshes a document once more and writes it: the same document gives the same mesh. `json` is the job, any
/// other name
/// one of [`MeshFormat`].
///
/// # Errors
/// [`Refused`].
pub fn export(document: &[u8], format: &str, watch: &dyn Watch) -> Result<Exported, Refused> {
    let mut document = Document::read(document)?;
    document.draft = false;
    let job = document.ready()?.job;
    let stem = file_stem(&job.name);
    let mut bytes = Vec::new();
    if format == "json" {
        json::write(&job, &document.options, &mut bytes)?;
        return Ok(Exported { name: format!("{stem}.json"), bytes });
    }
    let format = MeshFormat::from_name(format).ok_or_else(|| Refused::Format(format.to_owned()))?;
    let meshed = csalf_core::mesh_watched(&job, &document.run_options(), watch)?;
    let name = "scaled_jacobian";
    let values = metrics::values(&meshed.mesh, name, None).unwrap_or_default();
    let cell_data = [CellData { name: name.into(), values }];
    let (mesh, sets) = (&meshed.mesh, &meshed.sets);
    let view = MeshView { mesh, heights: &[], sets, cell_data: &cell_data, title: &job.name };
    write_mesh(format, &view, &mut bytes)?;
    let extension = format.extensions().first().copied().unwrap_or_default();
    Ok(Exported { name: format!("{stem}.{extension}"), bytes })
}

/// A name that every file system takes.
fn file_stem(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let stem: String = name.chars().take(64).map(safe).collect();
    if stem.is_empty() { "mesh".into() } else { stem }
}
