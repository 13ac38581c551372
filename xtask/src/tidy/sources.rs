//! Rules for single files.

use super::scan::{code_only, float_literals, without_tests};
use std::fs;
use std::path::Path;

/// Most lines of code in a file; tests and tables do not count. Larger: files that nobody reads to the end.
/// (House style: 400 is the aim, 600 the cap.)
const MAX_CODE_LINES: usize = 600;

/// Float literals below this belong into a named constant or into `Tolerance`: they are thresholds. (House style.)
const SMALL: f64 = 1e-3;

/// Folders that hold sources, from the root.
const FOLDERS: [&str; 3] = ["crates", "tests", "xtask"];

/// Beginnings of paths that exist only on somebody's machine.
const MACHINE_PATHS: [&str; 3] = ["/work/", "/home/", "/Users/"];

/// Number of files seen, and what is wrong with them.
///
/// # Errors
/// A file or folder cannot be read.
pub(super) fn check(root: &Path) -> Result<(usize, Vec<String>), String> {
    let mut files = Vec::new();
    for folder in FOLDERS {
        collect(root, folder, &mut files)?;
    }
    files.sort();
    let mut findings = Vec::new();
    for path in &files {
        let source = fs::read_to_string(root.join(path)).map_err(|e| format!("{path}: {e}"))?;
        findings.extend(judge(path, &source));
    }
    Ok((files.len(), findings))
}

/// All Rust files below `folder`, as paths from the root with `/`.
fn collect(root: &Path, folder: &str, files: &mut Vec<String>) -> Result<(), String> {
    let entries = fs::read_dir(root.join(folder)).map_err(|e| format!("{folder}: {e}"))?;
    for entry in entries {
        let entry = entry.map_err(|e| format!("{folder}: {e}"))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let path = format!("{folder}/{name}");
        if entry.path().is_dir() {
            if name != "target" && !name.starts_with('.') {
                collect(root, &path, files)?;
            }
        } else if name.ends_with(".rs") {
            files.push(path);
        }
    }
    Ok(())
}

/// Tests, benches and examples: no caps, and any number may stand in them.
fn is_test(path: &str) -> bool {
    path.ends_with("/tests.rs")
        || path.ends_with("_tests.rs")
        || path.starts_with("tests/")
        || ["/tests/", "/benches/", "/examples/"].iter().any(|f| path.contains(f))
}

/// Frozen data.
fn is_table(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or_default();
    name.starts_with("table") || name.ends_with("_table.rs") || name.ends_with("_tables.rs")
}

/// What is wrong with one file.
fn judge(path: &str, source: &str) -> Vec<String> {
    let mut findings = Vec::new();
    if !source.starts_with("//!") && !path.ends_with("/tests.rs") {
        findings.push(format!("{path}:1: does not open with a `//!` doc that says what the file is for"));
    }
    for (k, line) in source.lines().enumerate() {
        if !path.starts_with("xtask/") && MACHINE_PATHS.iter().any(|p| line.contains(p)) {
            findings.push(format!("{path}:{}: names a folder of one machine", k + 1));
        }
    }
    let code = code_only(source);
    for (k, line) in code.lines().enumerate() {
        if line.contains("#[ignore]") {
            findings.push(format!("{path}:{}: `#[ignore]` without a reason", k + 1));
        }
    }
    if is_test(path) {
        return findings;
    }
    let code = without_tests(&code);
    let n = code.lines().filter(|l| !l.trim().is_empty()).count();
    if n > MAX_CODE_LINES && !is_table(path) {
        findings.push(format!("{path}: {n} lines of code, at most {MAX_CODE_LINES} allowed: split it"));
    }
    if path.ends_with("/tolerance.rs") {
        return findings;
    }
    for l in float_literals(&code) {
        if l.value != 0.0 && l.value < SMALL && !l.in_constant {
            findings.push(format!(
                "{path}:{}: the literal {:e} is a threshold: name it in a const with a doc, or ask Tolerance",
                l.line, l.value
            ));
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: &str = "crates/csalf-x/src/a.rs";

    #[test]
    fn a_good_file_passes() {
        let source = "//! What.\n\n/// Doc.\nconst EPS: f64 = 1e-9;\nfn a() -> f64 { EPS + 0.5 + 0.0 }\n\
                      #[cfg(test)]\nmod tests {\n fn b() -> f64 { 1e-12 }\n}\n";
        assert_eq!(judge(PATH, source), Vec::<String>::new());
    }

    #[test]
    fn each_offence_is_found() {
        assert_eq!(judge(PATH, "fn a() {}\n").len(), 1);
        assert_eq!(judge(PATH, "//! W.\nfn a() -> f64 { 1e-9 }\n").len(), 1);
        assert_eq!(judge(PATH, "//! W.\n#[ignore]\nfn a() {}\n").len(), 1);
        assert_eq!(judge(PATH, "//! W.\n#[ignore = \"slow\"]\nfn a() {}\n").len(), 0);
        assert_eq!(judge(PATH, "//! W, see /home/me/notes.\n").len(), 1);
        let long = format!("//! W.\n{}", "fn a() {}\n".repeat(MAX_CODE_LINES + 1));
        assert_eq!(judge(PATH, &long).len(), 1);
        assert_eq!(judge("crates/csalf-x/src/stencil_table.rs", &long).len(), 0);
        assert_eq!(judge("crates/csalf-x/src/tests.rs", &long).len(), 0);
    }
}
