//! `cargo xtask ci`: runs `.ci/run`, which is the same gate on every machine.

use crate::Outcome;
use std::path::Path;
use std::process::Command;

/// Runs the gate and passes its verdict on.
///
/// # Errors
/// The gate could not be started, or a step of it failed.
pub(crate) fn run(root: &Path) -> Outcome {
    let status = Command::new(root.join(".ci/run"))
        .current_dir(root)
        .status()
        .map_err(|e| format!(".ci/run could not be started: {e}"))?;
    if status.success() { Ok(()) } else { Err("the gate failed".into()) }
}
