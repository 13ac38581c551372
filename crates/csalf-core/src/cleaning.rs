//! The cleaning stage: repair, smoothing, cavity refill.
//!
//! ```text
//!   quads of rings and patches ──repair, smooth──▶ irregular vertices? ──cavities──▶ smooth ──▶ mesh
//! ```

use crate::mend::{MendReport, MendTask, mend};
use crate::{Method, Options, Preset};
use csalf_clean::reshape::POOR;
use csalf_clean::smooth::{SmoothOptions, smooth};
use csalf_clean::{
    CavityRules, CavityTask, REMOVED, ReshapeTask, finish, lift, refill_cavities, repair, reshape,
};
use csalf_geom::VertexId;
use csalf_geom::arrangement::Arrangement;
use csalf_mesh::{NamedSets, QuadMesh, QuadTopology, quality::Corners};
use csalf_sizemap::SizeField;
use csalf_tfi::{TfiRules, Transfinite};
use rayon::prelude::*;

/// The last smoothing: nearly all that is not perfect, and some rings around it. The more weight on size, the more edges
/// are as long as they should be (measured: 0.3 to 0.4 gives 0.4 % more of them and 0.001 less of the mean scaled Jacobian);
/// the power 8 in place of 4 raises the smallest scaled Jacobian by 0.01 and costs as much of nothing else.
const POLISH: SmoothOptions =
    SmoothOptions { threshold: 0.97, rings: 5, lambda: 0.4, power: 8, ..SmoothOptions::DEFAULT };

/// Quads that the last smoothing starts from, at most: this many, and one of so many more. What is far from any defect in a
/// large mesh is bent over so many quads that sweeps do not reach it. Larger: a little better, and a microsecond for each.
const POLISHED: (usize, usize) = (1000, 200);

/// The threshold of [`POLISH`], lowered so far that no more than [`POLISHED`] quads are below it. Cost 15 ns per quad.
fn polish_threshold(mesh: &QuadMesh) -> f64 {
    let shape = |q: &[VertexId; 4]| Corners::new(&q.map(|v| mesh.points[v.index()])).min_scaled();
    let mut below: Vec<f64> =
        mesh.quads.par_iter().with_min_len(1 << 12).map(shape).filter(|&s| s < POLISH.threshold).collect();
    let most = POLISHED.0 + mesh.n_quads() / POLISHED.1;
    if below.len() <= most {
        return POLISH.threshold;
    }
    *below.select_nth_unstable_by(most, f64::total_cmp).1
}

/// The last but one, for the few quads that are still poor, until nothing moves any more: a thin quad gains about a factor
/// of two per sweep. No floor: energy alone decides, else two thin quads side by side hold each other fast.
const RESCUE: SmoothOptions = SmoothOptions {
    threshold: 0.3,
    rings: 3,
    laplace_sweeps: 0,
    sweeps: 100,
    lambda: 0.05,
    tolerance: 1e-3,
    floor: 0.0,
    ..SmoothOptions::DEFAULT
};

/// Rings of quads around poor ones that move with them at the very end.
const LIFT_RINGS: usize = 3;

/// After that: shapes and sizes again, as far as no corner gets worse that is not good. (A floor of 0.4 in place of 0.8
/// lets sizes win: 0.02 less of the mean on a ragged outline.)
const AFTER_LIFT: SmoothOptions = SmoothOptions { threshold: 0.8, rings: 2, ..POLISH };

/// What cleaning reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CleanTask<'a> {
    pub(crate) arrangement: &'a Arrangement,
    pub(crate) size: &'a dyn SizeField,
    pub(crate) options: &'a Options,
}

/// Cleans and smooths the mesh; returns its topology and what had to be mended. `fixed` (per vertex) must not move,
/// `protected` (per quad) must stay. The sets follow the new numbers.
pub(crate) fn clean(
    mesh: &mut QuadMesh,
    mut fixed: Vec<bool>,
    mut protected: Vec<bool>,
    sets: &mut NamedSets,
    task: &CleanTask<'_>,
) -> (QuadTopology, MendReport) {
    let CleanTask { arrangement, size, options } = *task;
    let quality = options.method == Method::Csalf && options.preset == Preset::Quality;
    // What cavities change is smoothed again.
    let smoothing =
        if quality { SmoothOptions { sweeps: 1, ..Default::default() } } else { Default::default() };
    let scars = arrangement.scars.iter();
    let kept: Vec<[VertexId; 2]> =
        scars.flat_map(|s| s.windows(2).map(|w| [VertexId(w[0]), VertexId(w[1])])).collect();
    let (repaired, mut topology) = repair(mesh, &mut fixed, &mut protected, &kept, size, &smoothing);
    renumber(sets, &repaired.quads);
    let n_input = arrangement.points.len();
    let mending = MendTask { n_input, kept: &kept, size, tolerance: arrangement.tolerance };
    let mut mended = mend(mesh, &mut topology, &mut fixed, &mut protected, sets, &mending);
    if mended.n_holes > 0 {
        finish(mesh, &topology, &fixed, size, &smoothing);
    }
    if quality {
        let task = CavityTask {
            fixed: &fixed,
            protected: &protected,
            kept: &kept,
            size,
            mesher: &Transfinite::new(TfiRules::default()),
            tolerance: arrangement.tolerance,
            rules: CavityRules::default(),
        };
        let cleaned = refill_cavities(mesh, &topology, &task);
        tracing::info!(seeds = cleaned.n_seeds, tried = cleaned.tried, taken = cleaned.taken, small = cleaned.small, rejected = ?cleaned.rejected,
            "cavities");
        renumber(sets, &cleaned.quads);
        let mut still = vec![false; mesh.n_vertices()];
        for v in (0..fixed.len()).filter(|&v| fixed[v]) {
            // Fixed vertices are never removed.
            if let Some(s) = still.get_mut(cleaned.vertices.get(v).map_or(v, |&w| w as usize)) {
                *s = true;
            }
        }
        fixed = still;
        let mut of_layer = vec![false; mesh.n_quads()];
        for q in (0..protected.len()).filter(|&q| protected[q]) {
            if let Some(p) = of_layer.get_mut(cleaned.quads.get(q).map_or(q, |&r| r as usize)) {
                *p = true;
            }
        }
        protected = of_layer;
        if cleaned.taken > 0 {
            topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
        }
        smooth(mesh, &topology, &fixed, size, &RESCUE);
        let threshold = polish_threshold(mesh);
        finish(mesh, &topology, &fixed, size, &SmoothOptions { threshold, ..POLISH });
    } else {
        smooth(mesh, &topology, &fixed, size, &RESCUE);
    }
    let task = ReshapeTask { kept: &kept, size, tolerance: arrangement.tolerance };
    let mut n_lifted = lift(mesh, &topology, &fixed, POOR, LIFT_RINGS);
    let reshaped = reshape(mesh, &mut topology, &mut fixed, &mut protected, &task);
    renumber(sets, &reshaped.quads);
    if reshaped.taken > 0 {
        n_lifted += lift(mesh, &topology, &fixed, POOR, LIFT_RINGS);
    }
    if n_lifted + reshaped.taken > 0 {
        smooth(mesh, &topology, &fixed, size, &AFTER_LIFT);
    }
    tracing::info!(seeds = reshaped.n_seeds, tried = reshaped.tried, taken = reshaped.taken, "reshaped");
    // Whatever smoothing made flat or brought together. Layers are not protected from it: better cut into than no mesh.
    let last = mend(mesh, &mut topology, &mut fixed, &mut Vec::new(), sets, &mending);
    mended.add(&last);
    (topology, mended)
}

/// Follows new numbers of quads, if there are any; removed ones leave their sets.
fn renumber(sets: &mut NamedSets, quads: &[u32]) {
    if quads.is_empty() {
        return;
    }
    for (_, list) in &mut sets.quads {
        list.retain_mut(|q| {
            q.0 = quads.get(q.index()).copied().unwrap_or(REMOVED);
            q.0 != REMOVED
        });
    }
}
