//! `cargo xtask man`: one man page per command, made from the definition of the command line.

use crate::Outcome;
use crate::generated::put;
use clap::CommandFactory;
use std::path::Path;

/// What stands at the foot of each page.
const SOURCE: &str = concat!("csalf ", env!("CARGO_PKG_VERSION"));

/// Writes (or compares) docs/man/csalf*.1.
///
/// # Errors
/// A page cannot be made or written; with `check`, a page differs.
pub(crate) fn run(root: &Path, check: bool) -> Outcome {
    let mut top = csalf_cli::Args::command().name("csalf");
    top.build();
    for command in std::iter::once(&top).chain(top.get_subcommands()) {
        if command.is_hide_set() || command.get_name() == "help" {
            continue;
        }
        let name = if command.get_name() == "csalf" {
            "csalf".to_owned()
        } else {
            format!("csalf-{}", command.get_name())
        };
        let page = clap_mangen::Man::new(command.clone()).title(name.clone()).source(SOURCE);
        let mut bytes = Vec::new();
        page.render(&mut bytes).map_err(|e| format!("{name}: {e}"))?;
        let text = String::from_utf8(bytes).map_err(|e| format!("{name}: {e}"))?;
        put(root, &format!("docs/man/{name}.1"), &text, check, "man")?;
    }
    Ok(())
}
