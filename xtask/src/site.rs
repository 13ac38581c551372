//! `cargo xtask site`: csalf studio as a static site in target/site, with the engine as WebAssembly beside it.
//!
//! 1. The target wasm32-unknown-unknown: there, or by `rustup target add`; without it nothing is built, and a line says
//!    so.
//! 2. `cargo build -p csalf-wasm`, in the profile `wasm`.
//! 3. The files of the page, told to ask a worker instead of a server.
//!
//! Any web server can serve the folder; `python3 -m http.server -d target/site` is one.

use crate::{Outcome, say};
use csalf_studio::page::{ASSETS, POLICY};
use std::fs;
use std::path::Path;
use std::process::Command;

const TARGET: &str = "wasm32-unknown-unknown";

/// Builds the site.
///
/// # Errors
/// The module does not build, or a file cannot be written.
pub(crate) fn run(root: &Path) -> Outcome {
    if !has_target() {
        say(&format!("skipped: no target {TARGET} (rustup target add {TARGET})"));
        return Ok(());
    }
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(root).args(["build", "--locked", "--quiet", "--package", "csalf-wasm"]);
    let built = cargo.args(["--profile", "wasm", "--target", TARGET]).status();
    if !built.is_ok_and(|s| s.success()) {
        return Err("csalf-wasm does not build".into());
    }
    let site = root.join("target/site");
    let fail = |e: std::io::Error| format!("target/site: {e}");
    fs::create_dir_all(&site).map_err(fail)?;
    for a in ASSETS {
        fs::write(site.join(a.name), told(a.text)).map_err(fail)?;
    }
    let module = root.join("target").join(TARGET).join("wasm/csalf_wasm.wasm");
    let size = fs::copy(&module, site.join("csalf.wasm")).map_err(fail)?;
    say(&format!("target/site: the studio with a module of {} kB", size / 1000));
    Ok(())
}

/// The page, told where its engine is; a static site brings its content policy in the page. Other files as they are.
fn told(text: &str) -> String {
    // A policy in a page cannot speak of frames.
    let policy = POLICY.split("; frame-ancestors").next().unwrap_or(POLICY);
    let meta =
        format!("content=\"worker\">\n<meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">");
    text.replacen("content=\"server\">", &meta, 1)
}

/// True if the target is installed, if need be by us.
fn has_target() -> bool {
    let there = || {
        let out = Command::new("rustc").args(["--print", "target-libdir", "--target", TARGET]).output();
        out.is_ok_and(|o| Path::new(String::from_utf8_lossy(&o.stdout).trim()).is_dir())
    };
    there() || (Command::new("rustup").args(["target", "add", TARGET]).output().is_ok() && there())
}
