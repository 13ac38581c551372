//! Runs the program as a user would.

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

/// A folder of this test's own, empty.
pub(crate) fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).expect("the temporary folder can be made");
    path
}

/// What a run gave.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
    pub(crate) bytes: Vec<u8>,
}

impl Ran {
    fn new(o: Output) -> Self {
        Self {
            code: o.status.code().unwrap_or(-1),
            out: String::from_utf8_lossy(&o.stdout).into_owned(),
            err: String::from_utf8_lossy(&o.stderr).into_owned(),
            bytes: o.stdout,
        }
    }

    /// The last line on standard output, as JSON.
    pub(crate) fn json(&self) -> serde_json::Value {
        let line = self.out.lines().last().unwrap_or_default();
        serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}\n{}", self.err))
    }
}

/// The program with these arguments, in this folder.
pub(crate) fn program(folder: &std::path::Path, args: &[&str]) -> Command {
    let mut c = Command::new(env!("CARGO_BIN_EXE_csalf"));
    c.args(args).current_dir(folder).env_remove("NO_COLOR").stdin(Stdio::null());
    c
}

pub(crate) fn run(folder: &std::path::Path, args: &[&str]) -> Ran {
    Ran::new(program(folder, args).output().expect("the program starts"))
}

pub(crate) fn run_with_input(folder: &std::path::Path, args: &[&str], input: &str) -> Ran {
    let mut child = program(folder, args)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    // A program that stops early closes the pipe; its exit code tells what happened.
    let _ = child.stdin.take().expect("it was piped").write_all(input.as_bytes());
    Ran::new(child.wait_with_output().expect("the program ends"))
}

/// A square of `n` segments a side and side `n`, as a job.
pub(crate) fn square(n: usize) -> String {
    let at = |k: usize| match k / n {
        0 => (k, 0),
        1 => (n, k - n),
        2 => (3 * n - k, n),
        _ => (0, 4 * n - k),
    };
    let nodes: Vec<String> = (0..4 * n).map(at).map(|(x, y)| format!("[{x},{y}]")).collect();
    format!(r#"{{"name":"square","loops":[{{"kind":"outer","nodes":[{}]}}]}}"#, nodes.join(","))
}
