//! Cavity refill: around irregular vertices, a disk of quads is replaced by a pattern with fewer of them.
//!
//! ```text
//!   o──o──o──o          o──o──o──o      the rim is read by connectivity: a vertex that has r quads outside and
//!   │  │ 5│  │          │  │  │  │      wants w in all wants w - r inside: 1 makes it a corner, 2 a side
//!   o──o─/ \─o   ──▶    o──o──o──o
//!   │  3\ /  │          │  │  │  │
//!   o──o──o──o          o──o──o──o
//! ```
//!
//! 1. Seeds: irregular inner vertices and boundary vertices with a wrong number of quads, worst quads first.
//! 2. [`small`]: the disks of a few quads at the seed, by a table. If there is nothing to gain, steps 3 to 5.
//! 3. [`grow`]: the quads around the seed, then paths to the nearest other irregular vertices, then rings;
//!    after each step the cavity is made convex by absorbing what stands in reflex rim vertices.
//! 4. If the number of corners allows fewer irregular vertices than there are, a mesher for contours with
//!    given corners fills the cavity.
//! 5. [`refill`]: the patch and a ring around are smoothed apart from the mesh and compared with what was
//!    there. If shape and size are good, the patch is taken; its surroundings are seeds again.
//!
//! **Termination.** The potential is the sum of w (1 + (d - wanted)²) over the vertices that do not have the number d of
//! quads that they want. Each vertex has a weight w from its coming to its going (2 on the boundary, 8 at the quads that lay
//! on the boundary at the start or must stay, 4 elsewhere and for all new ones) and wants a number that does not change
//! (4, or by its angle at the boundary, where nothing moves). So the potential is a sum of natural numbers that only an
//! edit changes, every edit makes it smaller, and there are finitely many; between two of them each seed of the queue is
//! tried once, and there is a budget besides. Nothing depends on the number of threads. Source: handbook 6.3 to 6.6.

mod grow;
mod local_size;
mod refill;
mod small;

use crate::edit::EditMesh;
use csalf_geom::{Tolerance, VertexId};
use csalf_mesh::{QuadMesh, QuadTopology, RegionMesher, quality::Corners};
use csalf_sizemap::SizeField;
use grow::{Cavity, Site};
use std::collections::VecDeque;

/// Seeds are tried at most this many times per seed of the start. Larger: chains of changes are followed
/// further. Reached only where patches keep making new seeds.
const TRIES_PER_SEED: usize = 6;

/// What may be edited, and to what end.
#[derive(Clone, Copy, Debug)]
pub struct CavityTask<'a> {
    /// Per vertex: must not move or vanish. Boundary vertices count as fixed anyhow.
    pub fixed: &'a [bool],
    /// Per quad: must stay. Missing entries count as false.
    pub protected: &'a [bool],
    /// Edges that must stay (scars).
    pub kept: &'a [[VertexId; 2]],
    /// The size field.
    pub size: &'a dyn SizeField,
    /// Fills contours with given corners.
    pub mesher: &'a dyn RegionMesher,
    /// Length thresholds of the run.
    pub tolerance: Tolerance,
    /// What is asked of a patch.
    pub rules: CavityRules,
}

/// What is asked of a cavity and its patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CavityRules {
    /// Most quads of a cavity. Larger: further pairs are found, at a cost that grows with the square.
    pub most_quads: usize,
    /// A patch must have a smallest scaled Jacobian of at least this, or of what was there before.
    pub min_sj: f64,
    /// The sum of the scaled Jacobians may fall by this for every irregular vertex that goes.
    pub mean_loss: f64,
    /// The number of quads with all edges of a length outside 0.7 to 1.4 of the wanted one may grow by this
    /// for every irregular vertex that goes (a quad with one such edge counts a quarter).
    pub size_loss: f64,
    /// Most patches tried per seed.
    pub patches: usize,
}

impl Default for CavityRules {
    fn default() -> Self {
        Self { most_quads: 160, min_sj: 0.5, mean_loss: 0.6, size_loss: 1.0, patches: 3 }
    }
}

/// What [`refill_cavities`] did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CavityReport {
    /// Irregular vertices at the start (with boundary vertices of a wrong number of quads).
    pub n_seeds: usize,
    /// Patches that were made and judged.
    pub tried: usize,
    /// Patches that were taken.
    pub taken: usize,
    /// Of those, small disks.
    pub small: usize,
    /// Why the others were not.
    pub rejected: Rejections,
    /// New number of each old vertex, or [`crate::REMOVED`]. Empty if no number changed.
    pub vertices: Vec<u32>,
    /// Likewise of each old quad.
    pub quads: Vec<u32>,
}

/// Why patches were not taken, and seeds not followed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rejections {
    /// Seeds whose own quads cannot be a cavity.
    pub blocked: usize,
    /// Seeds none of whose cavities promised anything.
    pub hopeless: usize,
    /// The mesher had no patch, or none with a lower potential.
    pub unfilled: usize,
    /// The smallest scaled Jacobian would have fallen.
    pub shape: usize,
    /// The mean scaled Jacobian would have fallen.
    pub mean: usize,
    /// Sizes would have got worse.
    pub size: usize,
}

/// Replaces cavities by patches with fewer irregular vertices. `topology` must be that of `mesh`; the result
/// needs a new one if `taken` > 0. All quads of a patch and around it are strictly convex by exact predicates.
///
/// Cost: a few words per vertex and quad, then some 100 us per irregular vertex.
pub fn refill_cavities(mesh: &mut QuadMesh, topology: &QuadTopology, task: &CavityTask<'_>) -> CavityReport {
    let mut report = CavityReport::default();
    if topology.n_bad_edges > 0 || !mesh.triangles.is_empty() {
        return report;
    }
    let mut site = Site::new(EditMesh::new(mesh, topology), task);
    let irregular: Vec<u32> = (0..site.mesh.n_vertices() as u32).filter(|&v| site.is_irregular(v)).collect();
    let mut seeds: Vec<(f64, u32)> =
        irregular.into_iter().map(|v| (worst_around(&site.mesh, v), v)).collect();
    seeds.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    report.n_seeds = seeds.len();
    let mut budget = TRIES_PER_SEED * seeds.len();
    let mut queue: VecDeque<u32> = seeds.iter().map(|s| s.1).collect();
    let mut queued = vec![false; site.mesh.n_vertices()];
    queue.iter().for_each(|&v| queued[v as usize] = true);
    let mut cavity = Cavity::default();
    let mut near = Vec::new();
    while let Some(seed) = queue.pop_front() {
        queued[seed as usize] = false;
        if budget == 0 {
            break;
        }
        budget -= 1;
        if !site.is_irregular(seed) {
            continue;
        }
        near.clear();
        let (mut tried, mut taken) = site.mend(seed, &mut cavity, &mut near);
        report.small += usize::from(taken);
        if !taken {
            let (more, also) = site.improve(seed, &mut cavity, &mut near);
            (tried, taken) = (tried + more, also);
        }
        report.tried += tried;
        report.taken += usize::from(taken);
        queued.resize(site.mesh.n_vertices(), false);
        for &v in &near {
            if site.is_irregular(v) && !std::mem::replace(&mut queued[v as usize], true) {
                queue.push_back(v);
            }
        }
    }
    report.rejected = site.rejected;
    (report.vertices, report.quads) = site.mesh.finish();
    report
}

/// Smallest scaled Jacobian of the quads at `v`.
fn worst_around(mesh: &EditMesh<'_>, v: u32) -> f64 {
    mesh.star(v)
        .iter()
        .map(|&h| Corners::new(&mesh.quad(h / 4).map(|w| mesh.point(w))).min_scaled())
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests;
