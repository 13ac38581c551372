//! `cargo xtask reduce FILE|SEED`: shrinks a failing job and prints it as a Rust test.

use crate::stress::{options_for, save};
use crate::{Outcome, say};
use csalf_core::Options;
use csalf_testkit::{Recipe, job, reduce};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Options of the command.
#[derive(clap::Args, Debug)]
pub(crate) struct ReduceArgs {
    /// A job file (JSON), or a seed of `stress`
    input: String,
    /// Method, if the input is a seed
    #[arg(long, default_value = "csalf")]
    method: String,
    /// With layers, if the input is a seed
    #[arg(long)]
    layers: bool,
    /// Most seconds to spend
    #[arg(long, default_value_t = 60)]
    seconds: u64,
    /// Another number of threads that must give the same bytes
    #[arg(long)]
    threads: Option<usize>,
}

/// Shrinks and prints.
///
/// # Errors
/// The input cannot be read, or does not fail.
pub(crate) fn run(root: &Path, args: &ReduceArgs) -> Outcome {
    let (job, options) = match args.input.parse::<u64>() {
        Ok(seed) => {
            let recipe = Recipe { layers: args.layers, ..Recipe::default() };
            let (job, base) = job(seed, &recipe);
            (job, options_for(&args.method, seed, base)?)
        }
        Err(_) => {
            let bytes = std::fs::read(&args.input).map_err(|e| format!("{}: {e}", args.input))?;
            let doc = csalf_io::json::read(&bytes).map_err(|e| e.to_string())?;
            let mut options = Options { threads: 1, ..Options::default() };
            doc.options.apply(&mut options);
            (doc.job, options)
        }
    };
    let threads: Vec<usize> = args.threads.into_iter().collect();
    let limit = Duration::from_secs(args.seconds);
    let Some(mut small) = reduce::reduce(&job, &options, &threads, limit) else {
        return Err("this job does not fail".into());
    };
    small.job.about = small.failure.to_string().chars().take(200).collect();
    let name = match args.input.parse::<u64>() {
        Ok(seed) => format!("seed{seed}"),
        Err(_) => PathBuf::from(&args.input).file_stem().unwrap_or_default().to_string_lossy().into_owned(),
    };
    let path = root.join(format!("target/stress/{name}.reduced.json"));
    save(&path, &small.job, &small.options)?;
    let d = &small.job.domain;
    let n: usize = d.loops.iter().map(|l| l.nodes.len()).sum();
    say(&reduce::as_test(&small));
    say(&format!(
        "{} loops of {n} nodes, {} scars, {} points: {}\n{}",
        d.loops.len(),
        d.scars.len(),
        d.points.len(),
        small.failure,
        path.display()
    ));
    Ok(())
}
