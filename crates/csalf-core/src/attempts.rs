//! By which means a job is meshed: as asked, then by ever simpler ones; small meshes of mediocre quality in variants.
//!
//! ```text
//!   as asked ──refused──▶ fast, tight ──refused──▶ tqm ──refused──▶ tqm, neither cleaned nor smoothed
//!      │ small and mediocre
//!      └──▶ 2 variants of equally good splits ──▶ the best
//! ```

use crate::pipeline::mesh_once;
use crate::region::Curves;
use crate::{Job, LoopReport, MeshError, Meshed, Method, Options, Preset, Warning, Watch, clock};
use csalf_geom::VertexId;
use csalf_mesh::QuadMesh;
use csalf_mesh::quality::Corners;
use csalf_pave::LayerSpec;

/// One way to mesh a job.
#[derive(Clone, Debug)]
pub(crate) struct Attempt {
    pub(crate) options: Options,
    /// Small contours may be closed by quads that are to be untangled.
    pub(crate) loose: bool,
    /// The mesh is repaired and smoothed.
    pub(crate) clean: bool,
    /// Which of the splits that are nearly as good are chosen ([`SplitRules::variant`]).
    pub(crate) variant: u32,
}

/// Small meshes of mediocre quality are made again in up to so many variants, until one is not mediocre; the best is
/// kept. Of a symmetric outline, where many splits are equally good, one choice can end at a mean of 0.90 and another
/// at 0.95.
const VARIANTS: u32 = 2;
/// What is small (quads), and mediocre: a mean below the first, a minimum above the second (below it the outline forces
/// poor quads, and the work is in vain).
const AGAIN: (usize, f64, f64) = (400, 0.93, 0.3);

/// By which variants are compared: the mean scaled Jacobian and half of the smallest.
fn shape(mesh: &QuadMesh) -> (f64, f64) {
    let least = |q: &[VertexId; 4]| Corners::new(&q.map(|v| mesh.points[v.index()])).min_scaled();
    let (sum, min) =
        mesh.quads.iter().map(least).fold((0.0, 1.0), |(sum, min), s| (sum + s, f64::min(min, s)));
    (sum / mesh.n_quads().max(1) as f64, min)
}

/// The mesh of an attempt, or a better one of its variants.
fn best_variant(job: &Job, attempt: &Attempt, watch: &dyn Watch) -> Result<Meshed, MeshError> {
    let mut best = mesh_once(job, attempt, watch)?;
    let (most, mean, min) = AGAIN;
    let quality = attempt.options.method == Method::Csalf && attempt.options.preset == Preset::Quality;
    if !quality || best.mesh.n_quads() > most {
        return Ok(best);
    }
    let mut first = shape(&best.mesh);
    if first.1 < min {
        return Ok(best);
    }
    let n_made = |m: &Meshed| m.report.loops.iter().map(|l| l.made).sum::<usize>();
    for variant in 1..=VARIANTS {
        if first.0 >= mean {
            break;
        }
        let other = match mesh_once(job, &Attempt { variant, ..attempt.clone() }, watch) {
            Ok(other) => other,
            // There is a mesh, though this was none.
            Err(MeshError::Internal { .. }) => continue,
            Err(e) => return Err(e),
        };
        let now = shape(&other.mesh);
        if now.0 + 0.5 * now.1 > first.0 + 0.5 * first.1 && n_made(&other) >= n_made(&best) {
            (first, best) = (now, other);
        }
    }
    Ok(best)
}

/// Meshes with the options as given. If the certificate refuses the result (a defect of ours, on a domain at the limits
/// of floating-point numbers), again by ever simpler means; the report says so. The last one, subdivision with convex
/// quads only and neither layers nor smoothing, has nothing that could fail but the resolution of the numbers.
pub(crate) fn by_attempts(job: &Job, options: &Options, watch: &dyn Watch) -> Result<Meshed, MeshError> {
    let start = clock::now();
    let attempt =
        |options: &Options, loose, clean| Attempt { options: options.clone(), loose, clean, variant: 0 };
    let fast = Options { preset: Preset::Fast, ..options.clone() };
    let tqm = Options { method: Method::Tqm, ..fast.clone() };
    let mut attempts = vec![attempt(options, true, true), attempt(&fast, false, true)];
    if options.method != Method::Tqm {
        attempts.push(attempt(&tqm, false, true));
    }
    attempts.push(attempt(&tqm, false, false));
    let mut refused = Vec::new();
    for attempt in &attempts {
        match best_variant(job, attempt, watch) {
            Err(_) if watch.cancelled() => return Err(MeshError::Cancelled),
            Err(e @ MeshError::Internal { .. }) => refused.push(e),
            Ok(mut meshed) => {
                meshed.report.timing.wall_s = clock::now() - start;
                let retried = |e: &MeshError| Warning::Retried { reason: e.to_string() };
                meshed.report.warnings.extend(refused.iter().map(retried));
                if attempt.options.method != options.method {
                    meshed.report.loops = layers_given_up(job);
                }
                return Ok(meshed);
            }
            error => return error,
        }
    }
    Err(refused.swap_remove(0))
}

/// What the report says of loops for which layers were asked, where a mesh could be made only without them.
fn layers_given_up(job: &Job) -> Vec<LoopReport> {
    let report = |(name, asked): (&str, Option<&LayerSpec>)| {
        let spec = asked.filter(|spec| spec.count > 0)?;
        let stopped = "no valid mesh could be made with layers".to_owned();
        Some(LoopReport { name: name.to_owned(), asked: spec.count, stopped, ..LoopReport::default() })
    };
    Curves::asked_of(job).into_iter().filter_map(report).collect()
}
