//! Meshes one job, catches what may go wrong, and gives it a name.

use crate::check::{Fault, faults};
use csalf_core::{Job, MeshError, Meshed, Options, Warning};
use csalf_geom::VertexId;
use csalf_geom::arrangement::{Arrangement, CheckOptions};
use csalf_mesh::{Expectation, QuadMesh, validate};
use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Longest time for one job, in processor seconds of one thread.
pub const TIME_LIMIT: f64 = 10.0;

/// What went wrong with a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// A panic: where and what.
    Panic(String),
    /// A typed error, though the domain is valid.
    Error(String, String),
    /// The mesh is not what was asked for.
    Mesh(Vec<Fault>),
    /// Took longer than [`TIME_LIMIT`]: seconds.
    Slow(f64),
    /// Another number of threads gave another mesh.
    Threads(usize),
}

impl Failure {
    /// What `reduce` keeps while it shrinks: equal for failures of one cause, as far as one can tell.
    pub fn kind(&self) -> String {
        match self {
            Self::Panic(at) => format!("panic {}", at.split_whitespace().next().unwrap_or_default()),
            Self::Error(stage, _) => format!("error in {stage}"),
            Self::Mesh(faults) => format!("mesh {}", faults.first().map_or("", |f| f.kind)),
            Self::Slow(_) => "slow".into(),
            Self::Threads(_) => "threads".into(),
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Panic(at) => write!(f, "panic at {at}"),
            Self::Error(stage, detail) => write!(f, "error in {stage}: {detail}"),
            Self::Mesh(faults) => {
                let text: Vec<_> = faults.iter().map(ToString::to_string).collect();
                write!(f, "invalid mesh: {}", text.join("; "))
            }
            Self::Slow(s) => write!(f, "took {s:.1} s"),
            Self::Threads(n) => write!(f, "{n} threads give another mesh"),
        }
    }
}

/// A job that was meshed and found valid.
#[derive(Debug)]
pub struct Run {
    /// What came out.
    pub meshed: Meshed,
    /// Seconds of the meshing alone: of the processor on one thread, else of the wall.
    pub seconds: f64,
}

impl Run {
    /// How many contours were filled by the guaranteed fallback.
    pub fn n_fallbacks(&self) -> usize {
        let members = self.meshed.report.members.iter();
        members.filter(|m| m.0 == "fallback").map(|m| m.1).sum()
    }

    /// How many meshes were refused before this one.
    pub fn n_retries(&self) -> usize {
        let warnings = self.meshed.report.warnings.iter();
        warnings.filter(|w| matches!(w, Warning::Retried { .. })).count()
    }

    /// Smallest scaled Jacobian over all corners.
    pub fn min_scaled_jacobian(&self) -> f64 {
        let mesh = &self.meshed.mesh;
        let corners = mesh
            .quads
            .iter()
            .map(|q| csalf_mesh::quality::Corners::new(&q.map(|v| mesh.points[v.index()])).min_scaled());
        corners.fold(f64::INFINITY, f64::min)
    }
}

/// Meshed or failed.
pub type Outcome = Result<Run, Failure>;

thread_local! {
    static LAST_PANIC: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// The last panic of a thread that is not ours (workers of the mesher).
static LAST_ELSEWHERE: Mutex<Option<String>> = Mutex::new(None);

/// Keeps the place of panics instead of printing it.
fn watch_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        std::panic::set_hook(Box::new(|info| {
            let at = info.location().map_or("?".into(), |l| format!("{}:{}", l.file(), l.line()));
            let text = format!("{at} {}", text_of(info.payload()));
            LAST_PANIC.set(Some(text.clone()));
            *LAST_ELSEWHERE.lock().unwrap_or_else(PoisonError::into_inner) = Some(text);
        }));
    });
}

fn text_of(payload: &dyn Any) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("panic")
}

/// Meshes and takes the time. One thread runs in a pool of our own, so that its processor time can be told; the time
/// of several threads is by the wall.
fn timed(job: &Job, options: &Options) -> (Result<Meshed, MeshError>, f64) {
    if options.threads == 1
        && let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(1).build()
    {
        return pool.install(|| {
            let start = cpu_time::ThreadTime::now();
            let result = csalf_core::mesh(job, &Options { threads: 0, ..options.clone() });
            (result, start.elapsed().as_secs_f64())
        });
    }
    let start = Instant::now();
    let result = csalf_core::mesh(job, options);
    (result, start.elapsed().as_secs_f64())
}

/// Meshes without judging; panics become failures.
fn mesh(job: &Job, options: &Options) -> Outcome {
    watch_panics();
    LAST_PANIC.set(None);
    let result = catch_unwind(AssertUnwindSafe(|| timed(job, options)));
    let (result, seconds) = match result {
        Ok((result, seconds)) => (Ok(result), seconds),
        Err(payload) => (Err(payload), 0.0),
    };
    match result {
        Ok(Ok(meshed)) => Ok(Run { meshed, seconds }),
        Ok(Err(MeshError::Internal { stage, detail })) => Err(Failure::Error(stage.into(), detail)),
        Ok(Err(e)) => Err(Failure::Error("input".into(), e.to_string())),
        Err(_) => {
            let elsewhere = || LAST_ELSEWHERE.lock().unwrap_or_else(PoisonError::into_inner).clone();
            Err(Failure::Panic(LAST_PANIC.take().or_else(elsewhere).unwrap_or_default()))
        }
    }
}

/// Meshes a valid job and judges the mesh, twice: by [`faults`] and by `csalf_mesh::validate`. `threads`: further
/// numbers of threads that must give the same bytes.
///
/// # Errors
/// [`Failure`]: what went wrong.
pub fn run(job: &Job, options: &Options, threads: &[usize]) -> Outcome {
    let run = mesh(job, options)?;
    let mut found = faults(job, &run.meshed.mesh);
    found.extend(by_validate(job, &run.meshed.mesh));
    if !found.is_empty() {
        return Err(Failure::Mesh(found));
    }
    for &threads in threads {
        let other = mesh(job, &Options { threads, ..options.clone() })?;
        if !same_bytes(&run.meshed.mesh, &other.meshed.mesh) {
            return Err(Failure::Threads(threads));
        }
    }
    if run.seconds > TIME_LIMIT {
        return Err(Failure::Slow(run.seconds));
    }
    Ok(run)
}

/// True if two meshes are the same, bit for bit.
pub fn same_bytes(a: &QuadMesh, b: &QuadMesh) -> bool {
    let bits = |m: &QuadMesh| m.points.iter().map(|p| [p.x.to_bits(), p.y.to_bits()]).collect::<Vec<_>>();
    a.quads == b.quads && a.triangles == b.triangles && bits(a) == bits(b)
}

/// The defects that the mesher's own validation finds.
fn by_validate(job: &Job, mesh: &QuadMesh) -> Vec<Fault> {
    let Ok(a) = Arrangement::new(&job.domain, &CheckOptions::default()) else {
        return vec![Fault { kind: "domain", detail: "the domain is invalid".into() }];
    };
    let pair = |u: u32, v: u32| [VertexId(u), VertexId(v)];
    let boundary: Vec<_> =
        a.loops.iter().flat_map(|l| (0..l.len()).map(|i| pair(l[i], l[(i + 1) % l.len()]))).collect();
    let scars: Vec<_> = a.scars.iter().flat_map(|s| s.windows(2).map(|w| pair(w[0], w[1]))).collect();
    let points: Vec<_> = a.hard_points.iter().map(|&v| VertexId(v)).collect();
    let expected =
        Expectation { nodes: &a.points, boundary: &boundary, scars: &scars, points: &points, area: a.area };
    let defects = validate(mesh, &expected);
    defects.iter().take(5).map(|d| Fault { kind: "validate", detail: d.to_string() }).collect()
}
