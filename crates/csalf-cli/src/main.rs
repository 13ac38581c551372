//! The program `csalf`; all of it is in the library beside it, so that the man pages and tests can reach it.

use std::process::ExitCode;

fn main() -> ExitCode {
    csalf_cli::main()
}
