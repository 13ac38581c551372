//! One module per command.

pub mod check;
pub mod completions;
pub mod demo;
mod dry_run;
pub mod info;
pub mod mesh;
pub mod model;
mod model_info;
mod model_report;
pub mod plot;
pub mod stitch;
#[cfg(feature = "studio")]
pub mod studio;
pub mod sweep;

use crate::args::{Args, Command};
use crate::exit::Failure;

/// Runs the command.
///
/// # Errors
/// A [`Failure`], which has the exit code. With `--json` the line that tells of it is already printed.
pub fn run(args: &Args) -> Result<(), Failure> {
    let level = args.verbosity.level();
    match &args.command {
        Command::Mesh(a) => mesh::run(a, level),
        Command::Check(a) => check::run(a, level),
        Command::Demo(a) => demo::run(a, level),
        Command::Sweep(a) => sweep::run(a, level),
        Command::Stitch(a) => stitch::run(a, level),
        Command::Plot(a) => plot::run(a),
        Command::Info(a) => info::run(a, level),
        #[cfg(feature = "studio")]
        Command::Studio(a) => studio::run(a, level),
        Command::Completions { shell } => completions::run(*shell),
    }
}

/// After a failed run with `--json`: prints the line that says so.
fn with_json(json: bool, result: Result<(), Failure>) -> Result<(), Failure> {
    if json && let Err(failure) = &result {
        crate::say::out(&crate::json::failure(failure))?;
    }
    result
}
