//! Committed files that are made by the program: written, or with `--check` compared.

use crate::{Outcome, say};
use std::fs;
use std::path::Path;

/// Writes `text` to `root/path`, or with `check` only tells whether it already holds exactly that.
///
/// # Errors
/// The file cannot be written; with `check`: it is missing or differs.
pub(crate) fn put(root: &Path, path: &str, text: &str, check: bool, command: &str) -> Outcome {
    let full = root.join(path);
    let old = fs::read_to_string(&full).ok();
    if old.as_deref() == Some(text) {
        return Ok(());
    }
    if check {
        return Err(format!("{path} is out of date: run `cargo xtask {command}`"));
    }
    if let Some(folder) = full.parent() {
        fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    fs::write(&full, text).map_err(|e| format!("{path}: {e}"))?;
    say(&format!("wrote {path}"));
    Ok(())
}
