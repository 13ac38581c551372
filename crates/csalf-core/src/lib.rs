//! Layer 4 of csalf: the pipeline. [`mesh`] takes a [`Job`] and [`Options`] and returns a [`Meshed`] or a typed
//! [`MeshError`]; everything below it is used through here.

mod cleaning;
pub mod error;
pub mod job;
pub mod options;
mod pipeline;
mod region;
pub mod report;
pub mod triad;

pub use error::MeshError;
pub use job::Job;
pub use options::{Method, Options, Preset};
pub use report::{LoopReport, MeshReport, Meshed, Timing, Warning};

/// Meshes a job.
///
/// # Errors
/// [`MeshError::Invalid`] lists everything that is wrong with the input; [`MeshError::Internal`] is our fault.
pub fn mesh(job: &Job, options: &Options) -> Result<Meshed, MeshError> {
    pipeline::run(job, options)
}
