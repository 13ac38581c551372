//! The only place that prints. Colours only on a terminal, and never where `NO_COLOR` is set.

use crate::exit::Failure;
use std::io::{IsTerminal, Write};

/// True if standard error may be coloured: it is a terminal, `NO_COLOR` is unset or empty, and `TERM` is not `dumb`.
pub fn colored() -> bool {
    std::io::stderr().is_terminal()
        && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
        && std::env::var_os("TERM").is_none_or(|v| v != "dumb")
}

/// Prints `text` and a line end to standard output.
///
/// # Errors
/// [`Failure::Files`] if it cannot be written. A closed pipe is not an error: the reader has seen enough.
pub fn out(text: &str) -> Result<(), Failure> {
    let mut sink = std::io::stdout().lock();
    match writeln!(sink, "{text}").and_then(|()| sink.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Files(format!("cannot write to standard output: {e}")))
        }
        _ => Ok(()),
    }
}

/// Prints a line to standard error. Failing to do so is not reported: there is nowhere left to report it to.
pub fn err(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Prints a warning to standard error.
pub fn warning(text: &str) {
    labelled("warning", "33", text);
}

/// Most warnings of one kind printed one by one.
const MAX_WARNINGS: usize = 10;

/// Prints warnings about `about`; of many only the first, and how many more there are.
pub fn warnings<T: std::fmt::Display>(about: &str, list: &[T]) {
    list.iter().take(MAX_WARNINGS).for_each(|w| warning(&format!("{about}: {w}")));
    if list.len() > MAX_WARNINGS {
        warning(&format!("{about}: {} more warnings", list.len() - MAX_WARNINGS));
    }
}

/// Prints why a command failed to standard error.
pub fn failure(failure: &Failure) {
    labelled("error", "31", &failure.to_string());
}

fn labelled(label: &str, color: &str, text: &str) {
    if colored() {
        err(&format!("\x1b[1;{color}m{label}\x1b[0m: {text}"));
    } else {
        err(&format!("{label}: {text}"));
    }
}
