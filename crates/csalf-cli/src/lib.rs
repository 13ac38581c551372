//! The command line of csalf: reads files, calls [`csalf_core::mesh`], writes files, prints reports.
//!
//! Rules of the house:
//!
//! - Standard output carries what was asked for (a mesh by `-o -`, a report, one line of JSON); progress,
//!   warnings and errors go to standard error.
//! - Every failure has an exit code ([`exit::Failure`]), and an invalid input is reported in full: all defects,
//!   one per line.
//! - The mesh does not depend on the terminal, on the number of threads or on the verbosity.

pub mod args;
pub mod commands;
pub mod config;
pub mod exit;
pub mod files;
pub mod json;
pub mod layers;
pub mod logging;
pub mod model_file;
pub mod page;
pub mod progress;
pub mod requirement;
pub mod say;
pub mod second_order;
pub mod summary;
pub mod timing;

pub use args::Args;
pub use csalf_io::outlines;
pub use csalf_mesh::quality::metrics;

use clap::Parser;
use std::process::ExitCode;

/// The program: reads its arguments, runs the command, returns the exit code.
pub fn main() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(e) => {
            // Help and version also come here; clap prints them to standard output and errors to standard error.
            let code = if e.use_stderr() { exit::USAGE } else { exit::DONE };
            let _ = e.print();
            return ExitCode::from(code);
        }
    };
    match commands::run(&args) {
        Ok(()) => ExitCode::from(exit::DONE),
        Err(failure) => {
            say::failure(&failure);
            ExitCode::from(failure.code())
        }
    }
}

/// The example of the README, kept true.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
