//! Layer 6 of csalf: STEP files (AP203, AP214, AP242) into [`csalf_model::Model`]. The only user of `step-io`: if its
//! interface changes, this crate changes and nothing else.
//!
//! ```text
//!   product definitions ─occurrences, placed─▶ bodies ─shells─▶ faces ─bounds─▶ edge uses ─▶ edges, vertices
//! ```
//!
//! Lines, circles and ellipses are taken from their own parameters, never through NURBS (a closed circle's NURBS begins
//! at the circle's axis, not at the edge's vertex); everything else through the NURBS form that step-io derives.

mod geometry;
mod topology;

use csalf_model::Model;

/// Why a STEP file cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The file is no STEP file, or is cut off.
    #[error("not a STEP file: {0}")]
    Syntax(String),
    /// Nothing in it that has faces.
    #[error("the STEP file has no faces: no solid and no surface model{0}")]
    NoFaces(String),
    /// The reader of the file format stopped: a fault of the reader.
    #[error("the STEP reader stopped at this file; please report it")]
    Reader,
}

/// Reads a STEP file; instances of an assembly are placed. What was left out is said in [`Model::notes`]. The model is
/// as in the file: call [`csalf_model::check_and_snap`] and [`csalf_model::sew`] on it.
///
/// # Errors
/// [`StepError`].
pub fn read(bytes: &[u8]) -> Result<Model, StepError> {
    // The reader is young and its work on broken files is not ours to check: a panic in it is an error here.
    std::panic::catch_unwind(|| {
        let (model, report) = step_io::read(bytes).map_err(|e| StepError::Syntax(e.to_string()))?;
        topology::read(&model, &report)
    })
    .unwrap_or(Err(StepError::Reader))
}
