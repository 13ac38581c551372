//! `cargo xtask schema`: the JSON Schema of the job format, made from the types that read it.

use crate::Outcome;
use crate::generated::put;
use std::path::Path;

/// Writes (or compares) docs/job.schema.json.
///
/// # Errors
/// The file cannot be written; with `check`, it differs.
pub(crate) fn run(root: &Path, check: bool) -> Outcome {
    let schema = csalf_io::json::schema();
    let mut text = serde_json::to_string_pretty(&schema).map_err(|e| e.to_string())?;
    text.push('\n');
    put(root, "docs/job.schema.json", &text, check, "schema")
}
