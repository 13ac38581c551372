//! `cargo xtask regress`: meshes all fixtures and compares with their committed figures.
//!
//! ```text
//!   fixtures/CASE/job.json ──mesh by csalf, by tqm──▶ figures ──compare──▶ table, worst change first
//!                 baseline.toml ────────────────────────────────┘
//! ```
//!
//! Any difference fails, improvements too; time is never compared. `--bless [CASE]` writes the files anew: the job
//! from the code of the testkit, the baseline, and a picture unless that would be large.

use crate::{Outcome, say};
use csalf_core::{Job, Method, Options};
use csalf_io::{JobOptions, MeshView, json};
use csalf_testkit::baseline::{Change, Figures};
use csalf_testkit::fixtures;
use csalf_testkit::run as judge;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The methods that are held to their figures.
const METHODS: [(&str, Method); 2] = [("csalf", Method::Csalf), ("tqm", Method::Tqm)];

/// Pictures of more bytes are not written.
const LARGEST_PICTURE: usize = 150_000;

/// Coordinates of the code and of the file may differ by this share of their size: another libm.
const SAME: f64 = 1e-12;

/// Figures by method.
type Baseline = BTreeMap<String, Figures>;

/// Options of the command.
#[derive(clap::Args, Debug)]
pub(crate) struct RegressArgs {
    /// Write the figures anew, of all cases or of one
    #[arg(long, num_args = 0..=1, default_missing_value = "*", value_name = "CASE")]
    bless: Option<String>,
}

/// Compares or blesses.
///
/// # Errors
/// Differences, one per line; a case that does not mesh; a file that is missing or stale.
pub(crate) fn run(root: &Path, args: &RegressArgs) -> Outcome {
    let folder = root.join("fixtures");
    let mut findings = Vec::new();
    let mut changes: Vec<(String, Change)> = Vec::new();
    let all = fixtures::all();
    for coded in &all {
        let case = folder.join(&coded.name);
        let bless = args.bless.as_ref().is_some_and(|b| b == "*" || *b == coded.name);
        let job = if bless { Ok(coded.clone()) } else { stored_job(&case, coded) };
        let job = match job {
            Ok(job) => job,
            Err(e) => {
                findings.push(format!("{}: {e}", coded.name));
                continue;
            }
        };
        let before = baseline(&case).unwrap_or_default();
        let mut now = Baseline::new();
        for (name, method) in METHODS {
            let place = format!("{} {name}", coded.name);
            let options = Options { method, threads: 1, ..Options::default() };
            match judge::run(&job, &options, &[]) {
                Err(failure) => findings.push(format!("{place}: {failure}")),
                Ok(run) => {
                    let figures = Figures::new(&job, &run.meshed);
                    match before.get(name) {
                        Some(was) => {
                            changes.extend(figures.changes_from(was).into_iter().map(|c| (place.clone(), c)));
                        }
                        None if !bless => findings.push(format!("{place}: no baseline")),
                        None => {}
                    }
                    if bless && method == Method::Csalf {
                        write_picture(&case, &job, &run)?;
                    }
                    now.insert(name.to_owned(), figures);
                }
            }
        }
        if bless {
            write_case(&case, &job, &now)?;
        }
    }
    table(&mut changes);
    findings.extend(strangers(&folder, &all));
    if !findings.is_empty() {
        return Err(findings.join("\n"));
    }
    match (changes.len(), &args.bless) {
        (0, None) => say(&format!("regress: {} cases as they were", all.len())),
        (n, Some(_)) => say(&format!("regress: blessed, {n} figures changed")),
        (n, None) => {
            return Err(format!("regress: {n} figures changed; if on purpose: cargo xtask regress --bless"));
        }
    }
    Ok(())
}

/// The job of the file, which must be that of the code.
fn stored_job(case: &Path, coded: &Job) -> Result<Job, String> {
    let path = case.join("job.json");
    let bytes =
        fs::read(&path).map_err(|e| format!("job.json: {e}; cargo xtask regress --bless writes it"))?;
    let job = json::read(&bytes).map_err(|e| e.to_string())?.job;
    let nodes = |j: &Job| {
        let d = &j.domain;
        let curves = d.loops.iter().map(|l| &l.nodes).chain(d.scars.iter().map(|s| &s.nodes));
        curves.flatten().copied().chain(d.points.iter().map(|p| p.xy)).collect::<Vec<_>>()
    };
    let (a, b) = (nodes(&job), nodes(coded));
    let same = a.len() == b.len()
        && a.iter().zip(&b).all(|(p, q)| p.distance(*q) <= SAME * (1.0 + p.length()))
        && job.layers == coded.layers
        && job.about == coded.about;
    if same { Ok(job) } else { Err("job.json is not what the code makes; --bless writes it anew".into()) }
}

fn baseline(case: &Path) -> Option<Baseline> {
    toml::from_str(&fs::read_to_string(case.join("baseline.toml")).ok()?).ok()
}

fn write_case(case: &Path, job: &Job, figures: &Baseline) -> Outcome {
    let fail = |e: &dyn std::fmt::Display| format!("{}: {e}", case.display());
    fs::create_dir_all(case).map_err(|e| fail(&e))?;
    let mut bytes = Vec::new();
    json::write(job, &JobOptions::default(), &mut bytes).map_err(|e| fail(&e))?;
    fs::write(case.join("job.json"), bytes).map_err(|e| fail(&e))?;
    let text = toml::to_string(figures).map_err(|e| fail(&e))?;
    fs::write(case.join("baseline.toml"), text).map_err(|e| fail(&e))
}

fn write_picture(case: &Path, job: &Job, run: &judge::Run) -> Outcome {
    let fail = |e: &dyn std::fmt::Display| format!("{}: {e}", case.display());
    let view = MeshView {
        mesh: &run.meshed.mesh,
        heights: &[],
        sets: &run.meshed.sets,
        cell_data: &[],
        title: job.about.as_str(),
    };
    let mut bytes = Vec::new();
    csalf_io::write_mesh(csalf_io::MeshFormat::Svg, &view, &mut bytes).map_err(|e| fail(&e))?;
    fs::create_dir_all(case).map_err(|e| fail(&e))?;
    let path = case.join("picture.svg");
    if bytes.len() <= LARGEST_PICTURE {
        fs::write(path, bytes).map_err(|e| fail(&e))
    } else {
        // There may be none.
        let _ = fs::remove_file(path);
        Ok(())
    }
}

/// Prints what changed, worst first.
fn table(changes: &mut [(String, Change)]) {
    changes.sort_by(|a, b| b.1.relative().total_cmp(&a.1.relative()));
    if !changes.is_empty() {
        say(&format!("{:28} {:14} {:>12} {:>12} {:>9}", "case", "figure", "was", "is", "change"));
    }
    for (place, c) in changes {
        let percent = 100.0 * (c.is - c.was) / c.was.abs().max(f64::MIN_POSITIVE);
        say(&format!("{place:28} {:14} {:>12.6} {:>12.6} {percent:>+8.2} %", c.figure, c.was, c.is));
    }
}

/// Folders that no code makes.
fn strangers(folder: &Path, all: &[Job]) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else { return vec!["no folder `fixtures`".into()] };
    let mut names: Vec<String> = entries
        .flatten()
        .filter(|e| e.path().is_dir())
        .map(|e| e.file_name().to_string_lossy().into())
        .collect();
    names.sort();
    names.retain(|n| all.iter().all(|j| j.name != *n));
    names.into_iter().map(|n| format!("fixtures/{n}: no code makes this case")).collect()
}
