//! Developer tasks of csalf: `cargo xtask COMMAND`. One module per command; a new one is a file, a variant of
//! [`Task`] and a line in [`main`].

mod ci;
mod compare;
mod completions;
mod fuzz;
mod gallery;
mod generated;
mod man;
mod paper;
mod reduce;
mod regress;
mod schema;
mod site;
mod stress;
mod tidy;

use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// What a task may fail with: one message, already complete, one finding per line.
pub(crate) type Outcome = Result<(), String>;

#[derive(Parser, Debug)]
#[command(name = "cargo xtask", about = "Developer tasks of csalf", version)]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand, Debug)]
enum Task {
    /// Check the house rules: layers, file headers and sizes, small literals, licences
    Tidy,
    /// Run everything that the gate runs (.ci/run)
    Ci,
    /// Write the man pages to docs/man
    Man {
        /// Only compare with the committed files
        #[arg(long)]
        check: bool,
    },
    /// Write the shell completions to target/completions
    Completions,
    /// Write the JSON Schema of the job format to docs/job.schema.json
    Schema {
        /// Only compare with the committed file
        #[arg(long)]
        check: bool,
    },
    /// Build the studio as a static site with a WebAssembly engine into target/site
    Site,
    /// Mesh the paper's experiments and write docs/paper.md with its pictures
    Paper {
        /// Only compare with the committed files
        #[arg(long)]
        check: bool,
    },
    /// Draw fixtures and models into docs/gallery.md and its pictures
    Gallery {
        /// Only compare with the committed files
        #[arg(long)]
        check: bool,
    },
    /// Mesh many random domains and judge every mesh
    Stress(stress::StressArgs),
    /// Read and mesh model files with faults put into them
    FuzzModels(fuzz::FuzzArgs),
    /// Shrink a failing job (a file, or a seed of `stress`) and print it as a test
    Reduce(reduce::ReduceArgs),
    /// Mesh all fixtures and compare with their committed figures
    Regress(regress::RegressArgs),
    /// Time csalf, and gmsh where there is one, on the same jobs, and write docs/benchmarks.md
    Compare(compare::CompareArgs),
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().task {
        Task::Tidy => tidy::run(&root()),
        Task::Ci => ci::run(&root()),
        Task::Man { check } => man::run(&root(), check),
        Task::Completions => completions::run(&root()),
        Task::Schema { check } => schema::run(&root(), check),
        Task::Site => site::run(&root()),
        Task::Paper { check } => paper::run(&root(), check),
        Task::Gallery { check } => gallery::run(&root(), check),
        Task::Stress(args) => stress::run(&root(), &args),
        Task::FuzzModels(args) => fuzz::run(&root(), &args),
        Task::Reduce(args) => reduce::run(&root(), &args),
        Task::Regress(args) => regress::run(&root(), &args),
        Task::Compare(args) => compare::run(&root(), &args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            say(&message);
            ExitCode::FAILURE
        }
    }
}

/// The workspace's folder.
pub(crate) fn root() -> PathBuf {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    here.parent().map_or_else(|| here.clone(), PathBuf::from)
}

/// Prints a line for the developer.
#[allow(clippy::print_stderr, reason = "a developer tool talks to the terminal; this is its one place")]
pub(crate) fn say(line: &str) {
    eprintln!("{line}");
}

/// What the gate wants of the tree, as tests: no build of their own.
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_house_rules_hold() {
        assert_eq!(tidy::run(&root()), Ok(()));
    }

    #[test]
    fn the_man_pages_are_up_to_date() {
        assert_eq!(man::run(&root(), true), Ok(()));
    }

    #[test]
    fn the_schema_is_up_to_date() {
        assert_eq!(schema::run(&root(), true), Ok(()));
    }
}
