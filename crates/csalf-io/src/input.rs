//! What a job reader gives back: jobs that can be meshed as they are, or raw curves that must first be given nodes.

use crate::{IoError, JobFormat, JobOptions, json};
use csalf_core::Job;
use std::path::Path;

/// What a file held.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Input {
    /// Discretised domains: every point of the file is a mesh node.
    Jobs(Vec<Job>),
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
        JobFormat::Json => {
            let doc = json::read(bytes)?;
            Ok(JobInput { input: Input::Jobs(vec![doc.job]), options: doc.options, notes: doc.notes })
        }
        _ => Err(IoError::unsupported(format.name(), crate::Place::Whole, "not built yet")),
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
    let Input::Jobs(jobs) = &mut out.input;
    for job in jobs.iter_mut().filter(|j| j.name.is_empty()) {
        job.name.clone_from(&stem);
    }
    Ok(out)
}
