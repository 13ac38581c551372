//! `cargo xtask stress`: meshes many random domains and judges every mesh.
//!
//! 1. Workers take one seed after the other: job, mesh on one thread, verdict (`csalf_testkit::run`).
//! 2. Every tenth domain is meshed with two threads as well: the bytes must be the same.
//! 3. A failure is saved as a JSON job, with its seed in the name, to `target/stress`; `cargo xtask reduce` shrinks it.
//! 4. The summary: failures by kind, the slowest, smallest scaled Jacobians (all; and of domains whose corners and gaps
//!    allow better: `csalf_testkit::bound`), fallbacks, retries.
//!
//! Each worker notes its seed in `target/stress/running-K`, so that even an abort leaves a trace. A job that hangs
//! ends the run.

use crate::{Outcome, say};
use csalf_core::{Method, Options};
use csalf_io::{JobOptions, json};
use csalf_testkit::run as judge;
use csalf_testkit::{Recipe, job};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Every so many domains are meshed with two threads too.
const THREADS_EVERY: u64 = 10;

/// After so many seconds a job is given up, and the run with it.
const HANG: u64 = 150;

/// Scaled Jacobians below this are poor.
const POOR: f64 = 0.1;

/// Percentiles of the smallest scaled Jacobian that are printed.
const PERCENTILES: [usize; 9] = [0, 1, 5, 10, 25, 50, 75, 90, 100];

/// Slowest jobs listed.
const SLOWEST: usize = 5;

/// Options of the command.
#[derive(clap::Args, Debug)]
pub(crate) struct StressArgs {
    /// How many domains
    #[arg(long, default_value_t = 1000)]
    count: u64,
    /// First seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// csalf, paper, tqm, or mix: one after the other
    #[arg(long, default_value = "csalf")]
    method: String,
    /// Ask for random layers
    #[arg(long)]
    layers: bool,
    /// Only nasty (true) or only easy (false) domains; both if not given
    #[arg(long)]
    nasty: Option<bool>,
    /// Workers; 0: as many as there are cores
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Save the jobs that did not fail, too
    #[arg(long)]
    keep: bool,
    /// Print one line per domain: seed, quads, seconds, smallest scaled Jacobian, its bound, fallbacks, retries
    #[arg(long)]
    each: bool,
    /// Most quads that a job may ask for
    #[arg(long, default_value_t = 30_000.0)]
    most_quads: f64,
}

/// One finished job.
struct Done {
    seed: u64,
    seconds: f64,
    n_quads: usize,
    n_fallbacks: usize,
    min_sj: f64,
    /// What the input allows at most.
    bound: f64,
    n_retries: usize,
    failure: Option<String>,
}

/// The options of a seed, or what is wrong with the method's name.
pub(crate) fn options_for(method: &str, seed: u64, base: Options) -> Result<Options, String> {
    let method = match (method, seed % 3) {
        ("csalf", _) | ("mix", 0) => Method::Csalf,
        ("paper", _) | ("mix", 1) => Method::Paper,
        ("tqm", _) | ("mix", _) => Method::Tqm,
        _ => return Err(format!("no method `{method}`: csalf, paper, tqm or mix")),
    };
    Ok(Options { method, threads: 1, ..base })
}

/// Saves a job where `cargo xtask reduce` finds it.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn save(path: &Path, job: &csalf_core::Job, options: &Options) -> Result<(), String> {
    let kept =
        JobOptions { method: Some(options.method), gradation: options.gradation, ..JobOptions::default() };
    let mut bytes = Vec::new();
    json::write(job, &kept, &mut bytes).map_err(|e| e.to_string())?;
    fs::write(path, bytes).map_err(|e| format!("{}: {e}", path.display()))
}

/// Runs `count` seeds.
///
/// # Errors
/// Anything failed.
pub(crate) fn run(root: &Path, args: &StressArgs) -> Outcome {
    options_for(&args.method, 0, Options::default())?;
    let folder = root.join("target/stress");
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let recipe =
        Recipe { nasty: args.nasty, layers: args.layers, most_quads: args.most_quads, ..Recipe::default() };
    let next = AtomicU64::new(args.seed);
    let end = args.seed + args.count;
    let n_workers = match args.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        n => n,
    };
    let start = Instant::now();
    // Per worker: seconds since the start, and seed, of its present job; u64::MAX when there is none.
    let running: Vec<_> = (0..n_workers).map(|_| (AtomicU64::new(u64::MAX), AtomicU64::new(0))).collect();
    let done = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for (k, now) in running.iter().enumerate() {
            let (next, done, folder, recipe) = (&next, &done, &folder, &recipe);
            scope.spawn(move || {
                let note = folder.join(format!("running-{k}"));
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= end {
                        break;
                    }
                    now.1.store(seed, Ordering::Relaxed);
                    now.0.store(start.elapsed().as_secs(), Ordering::Relaxed);
                    let _ = fs::write(&note, seed.to_string());
                    let one = one(seed, args, recipe, folder);
                    now.0.store(u64::MAX, Ordering::Relaxed);
                    done.lock().unwrap_or_else(PoisonError::into_inner).push(one);
                }
                let _ = fs::remove_file(note);
            });
        }
        watch(&running, start, end, &next, args);
    });
    let done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    summary(done, start.elapsed().as_secs_f64())
}

/// Waits for the workers, tells of progress, and ends the run if one hangs.
#[allow(clippy::exit, reason = "a worker that hangs cannot be stopped in another way")]
fn watch(running: &[(AtomicU64, AtomicU64)], start: Instant, end: u64, next: &AtomicU64, args: &StressArgs) {
    let mut told = 0;
    loop {
        std::thread::sleep(Duration::from_millis(100));
        let busy = |w: &&(AtomicU64, AtomicU64)| w.0.load(Ordering::Relaxed) != u64::MAX;
        let now = start.elapsed().as_secs();
        for w in running.iter().filter(busy) {
            if now.saturating_sub(w.0.load(Ordering::Relaxed)) > HANG {
                let seed = w.1.load(Ordering::Relaxed);
                say(&format!("seed {seed} hangs: no end after {HANG} s (method {})", args.method));
                std::process::exit(1);
            }
        }
        let at = next.load(Ordering::Relaxed);
        if at >= end && running.iter().filter(busy).count() == 0 {
            return;
        }
        if now >= told + 30 {
            told = now;
            say(&format!("{now} s: {} of {}", at.min(end) - args.seed, args.count));
        }
    }
}

/// Meshes one seed and saves it if that fails.
fn one(seed: u64, args: &StressArgs, recipe: &Recipe, folder: &Path) -> Done {
    let (job, base) = job(seed, recipe);
    let options = options_for(&args.method, seed, base).unwrap_or_default();
    let threads: &[usize] = if seed.is_multiple_of(THREADS_EVERY) { &[2] } else { &[] };
    let outcome = judge::run(&job, &options, threads);
    let mut done = Done {
        seed,
        seconds: 0.0,
        n_quads: 0,
        n_fallbacks: 0,
        min_sj: 1.0,
        bound: 1.0,
        n_retries: 0,
        failure: None,
    };
    let path = folder.join(format!("seed{seed}.json"));
    if args.keep
        && let Err(e) = save(&path, &job, &options)
    {
        say(&e);
    }
    match outcome {
        Ok(run) => {
            done.seconds = run.seconds;
            done.n_quads = run.meshed.mesh.n_quads();
            done.n_fallbacks = run.n_fallbacks();
            done.min_sj = run.min_scaled_jacobian();
            done.bound = csalf_testkit::bound::scaled_jacobian(&job);
            done.n_retries = run.n_retries();
        }
        Err(failure) => {
            let saved = save(&path, &job, &options).err().unwrap_or_default();
            say(&format!("seed {seed} ({:?}): {failure} {saved}", options.method));
            done.failure = Some(failure.kind());
        }
    }
    if args.each && done.failure.is_none() {
        let Done { seconds, n_quads, n_fallbacks, n_retries, min_sj, bound, .. } = done;
        say(&format!("{seed} {n_quads} {seconds:.2} {min_sj:.2e} {bound:.2e} {n_fallbacks} {n_retries}"));
    }
    done
}

fn percent(n: usize, of: usize) -> f64 {
    100.0 * n as f64 / of.max(1) as f64
}

/// Prints the distribution of the smallest scaled Jacobians.
fn quality<'a>(what: &str, done: impl Iterator<Item = &'a Done>) {
    let mut sj: Vec<(f64, u64)> = done.map(|d| (d.min_sj, d.seed)).collect();
    sj.sort_by(|a, b| a.0.total_cmp(&b.0));
    if sj.is_empty() {
        return;
    }
    let at: Vec<_> = PERCENTILES.iter().map(|k| format!("{:.1e}", sj[k * (sj.len() - 1) / 100].0)).collect();
    say(&format!(
        "min scaled Jacobian, {what} ({}): percentiles {PERCENTILES:?}: {}",
        sj.len(),
        at.join(" ")
    ));
    let share = |x: f64| percent(sj.iter().filter(|s| s.0 < x).count(), sj.len());
    say(&format!("  below 0.1: {:.1} %, below 0.01: {:.1} %", share(POOR), share(0.1 * POOR)));
    let worst: Vec<_> = sj.iter().take(SLOWEST).map(|s| format!("{:.1e} (seed {})", s.0, s.1)).collect();
    say(&format!("  worst: {}", worst.join(", ")));
}

fn summary(mut done: Vec<Done>, seconds: f64) -> Outcome {
    let n = done.len();
    let n_quads: usize = done.iter().map(|d| d.n_quads).sum();
    done.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    say(&format!("\n{n} domains, {n_quads} quads in {seconds:.0} s"));
    for d in done.iter().take(SLOWEST) {
        say(&format!("  {:6.2} s  {:7} quads  seed {}", d.seconds, d.n_quads, d.seed));
    }
    let good: Vec<&Done> = done.iter().filter(|d| d.failure.is_none()).collect();
    quality("all", good.iter().copied());
    // Corners and gaps of the input allow more than 0.1 on these.
    quality("not bounded by the input", good.iter().copied().filter(|d| d.bound >= POOR));
    let ratios = good.iter().map(|d| d.min_sj / d.bound).filter(|r| *r < 0.1).count();
    say(&format!("  below a tenth of what the input allows: {:.1} %", percent(ratios, good.len())));
    let fallbacks: Vec<usize> = good.iter().map(|d| d.n_fallbacks).filter(|&n| n > 0).collect();
    say(&format!("fallbacks: {} in {} domains", fallbacks.iter().sum::<usize>(), fallbacks.len()));
    let retried = good.iter().filter(|d| d.n_retries > 0);
    let seeds: Vec<u64> = retried.map(|d| d.seed).collect();
    say(&format!("meshed again: {} domains {:?}", seeds.len(), &seeds[..seeds.len().min(12)]));
    let mut kinds: BTreeMap<&str, Vec<u64>> = BTreeMap::new();
    for d in &done {
        if let Some(kind) = &d.failure {
            kinds.entry(kind).or_default().push(d.seed);
        }
    }
    let n_failed = done.iter().filter(|d| d.failure.is_some()).count();
    for (kind, seeds) in &mut kinds {
        seeds.sort_unstable();
        say(&format!("FAILED {} x {kind}: seeds {:?}", seeds.len(), &seeds[..seeds.len().min(12)]));
    }
    if n_failed > 0 {
        return Err(format!("stress: {n_failed} of {n} failed"));
    }
    say(&format!("stress: all {n} valid"));
    Ok(())
}
