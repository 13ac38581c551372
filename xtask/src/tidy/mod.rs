//! `cargo xtask tidy`: the house rules that a machine can check. All findings are listed, not only the first.
//!
//! 1. [`layers`]: crates see only crates of lower layers.
//! 2. [`sources`]: every source file opens with a `//!` doc, is not too long, has no unexplained `#[ignore]` and
//!    no small float literal outside a named constant; no file names a machine's folders.
//! 3. [`licences`]: everything that is linked has a permissive licence.
//! 4. [`book`]: every page is in the book, every link leads somewhere.

mod book;
mod layers;
mod licences;
mod scan;
mod sources;

use crate::{Outcome, say};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Runs all checks.
///
/// # Errors
/// The findings, one per line.
pub(crate) fn run(root: &Path) -> Outcome {
    let metadata = metadata(root)?;
    let mut findings = layers::check(&metadata);
    findings.extend(licences::check(&metadata));
    findings.extend(book::check(root)?);
    let (n_files, more) = sources::check(root)?;
    findings.extend(more);
    if findings.is_empty() {
        say(&format!("tidy: {n_files} source files, layers, licences, book: all well"));
        return Ok(());
    }
    Err(format!("{}\ntidy: {} findings", findings.join("\n"), findings.len()))
}

/// What cargo knows of the workspace and of all that it depends on.
fn metadata(root: &Path) -> Result<Value, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let out = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--locked"])
        .current_dir(root)
        .output()
        .map_err(|e| format!("cargo metadata: {e}"))?;
    if !out.status.success() {
        return Err(format!("cargo metadata: {}", String::from_utf8_lossy(&out.stderr)));
    }
    serde_json::from_slice(&out.stdout).map_err(|e| format!("cargo metadata: {e}"))
}

/// A string in a JSON object, or "".
fn text<'a>(v: &'a Value, key: &str) -> &'a str {
    v[key].as_str().unwrap_or_default()
}

/// The entries of an array in a JSON object, none if it is not there.
fn list<'a>(v: &'a Value, key: &str) -> &'a [Value] {
    v[key].as_array().map_or(&[], Vec::as_slice)
}
