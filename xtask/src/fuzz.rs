//! `cargo xtask fuzz-models`: model files with faults put into them, read and meshed. Nothing may panic or hang, and each
//! face must have a mesh or a failure with a reason.
//!
//! ```text
//!   seed ──▶ a sound file ──changed at some places──▶ read, sew, check, mesh ──▶ verdict
//!            fuzz/files        fuzz/mutate                                       kept in target/fuzz if it is bad
//! ```
//!
//! A try depends on its seed alone. Workers take one seed after the other; one that takes too long ends the run, with its
//! file kept.

mod files;
mod mutate;

use crate::{Outcome, say};
use csalf_geom::VertexId;
use csalf_io::facets::{FacetFormat, read as read_facets};
use csalf_model::brep::Model;
use csalf_model::facets::{FacetOptions, model_of_triangles};
use csalf_model::{
    ModelMesh, ModelOptions, SizeRules, check_and_snap, mesh_model, sew, sew_closed, turn_alike,
};
use files::Sound;
use glam::DVec3;
use mutate::Random;
use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Options of the command.
#[derive(clap::Args, Debug)]
pub(crate) struct FuzzArgs {
    /// How many tries
    #[arg(long, default_value_t = 10_000)]
    count: u64,
    /// First seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A folder of further sound files (.step, .stl, .obj, .ply)
    #[arg(long, value_name = "DIR")]
    files: Option<PathBuf>,
    /// Workers; 0: as many as there are cores
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// After so many seconds a try is a hang
    #[arg(long, default_value_t = 60)]
    hang: u64,
}

/// What came of one try.
#[derive(Clone, Debug, PartialEq)]
enum Verdict {
    /// The file was refused with an error.
    Refused,
    /// The reader of STEP files, which is not ours, panicked; an error for the user.
    ReaderStopped,
    /// Every face has a mesh.
    Whole,
    /// So many faces have none, each with a reason.
    Partly(usize),
    /// What may not be.
    Bad(String),
}

/// Runs the tries.
///
/// # Errors
/// How many tries were bad.
pub(crate) fn run(root: &Path, args: &FuzzArgs) -> Outcome {
    let sound = files::sound(root, args.files.as_deref())?;
    let keep = root.join("target/fuzz");
    fs::create_dir_all(&keep).map_err(|e| format!("{}: {e}", keep.display()))?;
    // Panics are findings here; their text goes into the verdict.
    std::panic::set_hook(Box::new(|_| {}));
    let n = match args.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        n => n,
    };
    let next = AtomicU64::new(0);
    let running: Vec<Mutex<Option<(u64, Instant)>>> = (0..n).map(|_| Mutex::new(None)).collect();
    let tally: Mutex<BTreeMap<String, u64>> = Mutex::new(BTreeMap::new());
    let start = Instant::now();
    let done = AtomicU64::new(0);
    std::thread::scope(|scope| {
        for slot in &running {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    if k >= args.count {
                        break;
                    }
                    let seed = args.seed + k;
                    *lock(slot) = Some((seed, Instant::now()));
                    let (name, bytes) = mutated(&sound, seed);
                    let verdict = attempt(&name, &bytes, seed);
                    *lock(slot) = None;
                    if let Verdict::Bad(why) = &verdict {
                        say(&format!("seed {seed}: {why}"));
                        save(&keep, seed, &name, &bytes);
                    }
                    *lock(&tally).entry(label(&verdict)).or_default() += 1;
                    done.fetch_add(1, Ordering::Relaxed);
                }
            });
        }
        scope.spawn(|| watch(args, &running, &sound, &keep, &done, start));
    });
    let tally = lock(&tally);
    let words: Vec<String> = tally.iter().map(|(k, n)| format!("{k} {n}")).collect();
    say(&format!("{} tries in {:.0} s: {}", args.count, start.elapsed().as_secs_f64(), words.join(", ")));
    match tally.get("bad") {
        None => Ok(()),
        Some(n) => Err(format!("{n} tries were bad; their files are in {}", keep.display())),
    }
}

fn lock<T>(m: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    m.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Says how far it is, and ends the program if a try hangs.
#[allow(clippy::exit, reason = "a worker that hangs cannot be stopped in another way")]
fn watch(
    args: &FuzzArgs,
    running: &[Mutex<Option<(u64, Instant)>>],
    sound: &[Sound],
    keep: &Path,
    done: &AtomicU64,
    start: Instant,
) {
    const TICK: Duration = Duration::from_millis(200);
    const SAY_EVERY: u64 = 30;
    let mut said = 0;
    while done.load(Ordering::Relaxed) < args.count {
        std::thread::sleep(TICK);
        for slot in running {
            let Some((seed, since)) = *lock(slot) else { continue };
            if since.elapsed().as_secs() >= args.hang {
                let (name, bytes) = mutated(sound, seed);
                save(keep, seed, &name, &bytes);
                say(&format!("seed {seed} hangs; its file is in {}", keep.display()));
                std::process::exit(1);
            }
        }
        let seconds = start.elapsed().as_secs();
        if seconds / SAY_EVERY > said {
            said = seconds / SAY_EVERY;
            say(&format!("{} tries in {seconds} s", done.load(Ordering::Relaxed)));
        }
    }
}

fn label(v: &Verdict) -> String {
    match v {
        Verdict::Refused => "refused",
        Verdict::ReaderStopped => "refused by a panic of the STEP reader",
        Verdict::Whole => "meshed",
        Verdict::Partly(_) => "meshed but for some faces",
        Verdict::Bad(_) => "bad",
    }
    .to_owned()
}

fn save(keep: &Path, seed: u64, name: &str, bytes: &[u8]) {
    // A file that cannot be kept can be made again from its seed.
    let _ = fs::write(keep.join(format!("{seed}_{name}")), bytes);
}

/// The file of a try.
fn mutated(sound: &[Sound], seed: u64) -> (String, Vec<u8>) {
    let mut random = Random::new(seed);
    let s = &sound[random.below(sound.len())];
    (s.name.clone(), mutate::change(&s.bytes, s.is_text, &mut random))
}

/// Reads and meshes.
fn attempt(name: &str, bytes: &[u8], seed: u64) -> Verdict {
    let work = || -> Verdict {
        let mut model = match read(name, bytes) {
            Ok(m) => m,
            Err(v) => return v,
        };
        let mut random = Random::new(!seed);
        // As the program does, now and then within a length that takes parts of the model away.
        let length = model.diagonal() * 10_f64.powi(-2 - random.below(4) as i32);
        match random.below(8) {
            0 => sew(&mut model, length),
            _ => sew_closed(&mut model),
        };
        turn_alike(&mut model);
        check_and_snap(&mut model);
        // Mostly a share of the model, now and then a length that does not go with it.
        let size = match random.below(20) {
            0 => 8.0_f64.max(model.diagonal() / 500.0),
            k => model.diagonal() * (0.04 + 0.01 * k as f64),
        };
        let options = ModelOptions { size: Some(SizeRules::of(size)), ..ModelOptions::default() };
        let mesh = mesh_model(&model, &options);
        judge(&model, &mesh)
    };
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|e| {
        let text = e.downcast_ref::<String>().cloned();
        let text = text.or_else(|| e.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        Verdict::Bad(format!("panic: {}", text.unwrap_or_default()))
    })
}

fn read(name: &str, bytes: &[u8]) -> Result<Model, Verdict> {
    if name.ends_with(".step") {
        return csalf_step::read(bytes).map_err(|e| match e {
            csalf_step::StepError::Reader => Verdict::ReaderStopped,
            _ => Verdict::Refused,
        });
    }
    let format = FacetFormat::from_path(Path::new(name)).ok_or(Verdict::Refused)?;
    let data = read_facets(format, bytes).map_err(|_| Verdict::Refused)?;
    let points: Vec<DVec3> = data.points.into_iter().map(DVec3::from_array).collect();
    Ok(model_of_triangles(&points, &data.triangles, &FacetOptions::default()))
}

/// What must hold of every outcome.
fn judge(model: &Model, m: &ModelMesh) -> Verdict {
    let bad = |why: String| Verdict::Bad(why);
    let mut has = vec![false; model.faces.len()];
    for f in &m.failures {
        if f.message.contains("fault of the mesher") {
            return bad(format!("face {} panicked", f.name));
        }
        if f.message.trim().is_empty() || std::mem::replace(&mut has[f.face], true) {
            return bad(format!("face {} has no reason or two", f.name));
        }
    }
    for f in &m.face_of_quad {
        has[*f as usize] = true;
    }
    if !model.faces.is_empty() && model.diagonal() > 0.0 && has.contains(&false) && m.warnings.is_empty() {
        return bad("a face was lost".into());
    }
    let n = m.mesh.points.len();
    if m.mesh.points.iter().any(|p| !p.is_finite()) {
        return bad("a node is not finite".into());
    }
    let mut sides: BTreeMap<[VertexId; 2], (u32, u32)> = BTreeMap::new();
    for (q, f) in m.mesh.quads.iter().zip(&m.face_of_quad) {
        if q.iter().any(|v| v.index() >= n) || (0..4).any(|k| (0..k).any(|j| q[j] == q[k])) {
            return bad(format!("a quad of {} has no or equal corners", model.faces[*f as usize].name));
        }
        for k in 0..4 {
            let (a, b) = (q[k], q[(k + 1) % 4]);
            let entry = sides.entry([a.min(b), a.max(b)]).or_insert((0, *f));
            entry.0 = if entry.1 == *f { entry.0 + 1 } else { 1 };
            entry.1 = *f;
            if entry.0 > 2 {
                return bad(format!("three quads of {} at one side", model.faces[*f as usize].name));
            }
        }
    }
    if m.failures.is_empty() { Verdict::Whole } else { Verdict::Partly(m.failures.len()) }
}
