//! `csalf completions SHELL`: the completion script, on standard output.

use crate::args::Args;
use crate::exit::Failure;
use clap::CommandFactory;

/// Prints the script.
///
/// # Errors
/// [`Failure::Files`] if standard output cannot be written.
pub fn run(shell: clap_complete::Shell) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Args::command(), "csalf", &mut text);
    crate::say::out(String::from_utf8_lossy(&text).trim_end())
}
