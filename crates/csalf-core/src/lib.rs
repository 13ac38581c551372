//! Layer 4 of csalf: the pipeline. [`mesh`] takes a [`Job`] and [`Options`] and returns a [`Meshed`] or a typed
//! [`MeshError`]; everything below it is used through here.

mod attempts;
mod certify;
mod cleaning;
mod clock;
pub mod error;
pub mod job;
mod mend;
pub mod options;
mod pipeline;
mod region;
pub mod report;
pub mod triad;
pub mod watch;

pub use error::MeshError;
pub use job::Job;
pub use options::{Method, Options, Preset};
pub use report::{LoopReport, MeshReport, Meshed, Timing, Warning};
pub use watch::Watch;

/// Meshes a job.
///
/// # Errors
/// [`MeshError::Invalid`] lists everything that is wrong with the input; [`MeshError::Internal`] is our fault.
pub fn mesh(job: &Job, options: &Options) -> Result<Meshed, MeshError> {
    mesh_watched(job, options, &())
}

/// As [`mesh`], under the eyes of `watch`.
///
/// # Errors
/// As [`mesh`], and [`MeshError::Cancelled`] if the watch says so before the mesh is finished.
pub fn mesh_watched(job: &Job, options: &Options, watch: &dyn Watch) -> Result<Meshed, MeshError> {
    pipeline::run(job, options, watch)
}
