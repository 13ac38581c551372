//! `cargo xtask completions`: completions for all shells, into target/completions (not committed; users get the
//! same text from `csalf completions SHELL`).

use crate::{Outcome, say};
use clap::{CommandFactory, ValueEnum};
use clap_complete::{Shell, generate_to};
use std::path::Path;

/// Writes one file per shell.
///
/// # Errors
/// A file cannot be written.
pub(crate) fn run(root: &Path) -> Outcome {
    let folder = root.join("target/completions");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for &shell in Shell::value_variants() {
        let file = generate_to(shell, &mut csalf_cli::Args::command(), "csalf", &folder)
            .map_err(|e| format!("{shell}: {e}"))?;
        say(&format!("wrote {}", file.display()));
    }
    Ok(())
}
