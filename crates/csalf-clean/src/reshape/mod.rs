//! Reshaping: where moving vertices does not help a poor quad, some quads around it are replaced by others.
//!
//! ```text
//!   poor quad ──▶ small disks of quads with it ──▶ all quadrangulations of their rims, most promising first
//!       ▲                                                │ each: lay out, untangle, lift the worst corners
//!       └───────────── next pass ◀── the least worth around is larger: taken
//! ```
//!
//! 1. Seeds: quads with a poor corner that is not forced by given nodes, the worst first.
//! 2. [`cavities`](cavity): disks of one to about ten quads at the seed.
//! 3. Candidates: quadrangulations of the rim by the table of small disks, rated by valences and by the angles
//!    that given nodes leave to each quad.
//! 4. [`trial`]: the best few are laid out in a copy of the surroundings, untangled and lifted. The list of what
//!    the quads there are worth, ascending, decides: the first clear difference must be a gain. A quad is worth its
//!    scaled Jacobian, or less if a side is far shorter than the one opposite (`smooth::lift`); the smallest scaled
//!    Jacobian must not fall.
//! 5. What is accepted in a pass shares no vertex; it is applied at once, and the next pass begins.
//!
//! **Termination.** The sorted list of what all quads are worth grows in lexicographic order by a factor with every change;
//! passes and trials are limited besides. Nothing depends on the number of threads. Cost: one look at every quad where
//! nothing is poor; else about a millisecond per trial.

mod cavity;
mod trial;

use crate::driver::{apply, compose};
use crate::ops::{Edit, Site};
use csalf_geom::{Tolerance, VertexId};
use csalf_mesh::quality::Corners;
use csalf_mesh::{QuadMesh, QuadTopology};
use csalf_sizemap::SizeField;

/// Quads below this scaled Jacobian are seeds.
pub const POOR: f64 = 0.25;
/// Passes at most.
const PASSES: usize = 8;
/// Below this more is tried.
const BAD: f64 = 0.12;
/// Trials per seed and pass, for bad ones and for others.
const TRIALS: (usize, usize) = (8, 4);
/// Trials in all: so many, and one for so many quads more; in a large mesh so many, and one for so many more. Small meshes are
/// often parts of something that is meshed again and again.
const ALL_TRIALS: [(usize, usize); 2] = [(40, 6), (300, 60)];

/// Where one quad in so many is poor, the outline asks for it: half of the trials are made, and fewer the more there are.
const HOPELESS: usize = 10;

/// What may be changed.
#[derive(Clone, Copy, Debug)]
pub struct ReshapeTask<'a> {
    /// Edges that must stay (scars).
    pub kept: &'a [[VertexId; 2]],
    /// The size field.
    pub size: &'a dyn SizeField,
    /// Length thresholds of the run.
    pub tolerance: Tolerance,
}

/// What [`reshape`] did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReshapeReport {
    /// Poor quads at the start.
    pub n_seeds: usize,
    /// Layouts tried.
    pub tried: usize,
    /// Taken.
    pub taken: usize,
    /// New number of each old vertex, or [`crate::REMOVED`]. Empty if no number changed.
    pub vertices: Vec<u32>,
    /// Likewise of each old quad.
    pub quads: Vec<u32>,
}

/// Replaces quads around poor ones where that raises the smallest scaled Jacobians. `fixed` and `protected` follow the new
/// numbers; `topology` is made anew when something was changed. Protected quads and the edges in `kept` stay.
pub fn reshape(
    mesh: &mut QuadMesh,
    topology: &mut QuadTopology,
    fixed: &mut Vec<bool>,
    protected: &mut Vec<bool>,
    task: &ReshapeTask<'_>,
) -> ReshapeReport {
    let mut report = ReshapeReport::default();
    fixed.resize(mesh.n_vertices(), false);
    protected.resize(mesh.n_quads(), false);
    let mut kept: Vec<[VertexId; 2]> = task.kept.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    kept.sort_unstable();
    let budget = ALL_TRIALS.map(|(base, each)| base + mesh.n_quads() / each);
    let mut left = budget[0].min(budget[1]);
    // Seeds that no trial has helped, by their points: they are not tried again before something moves.
    let mut hopeless: Vec<u64> = Vec::new();
    for pass in 0..PASSES {
        let site = Site { mesh, topology, fixed, kept: &kept };
        let seeds = seeds(&site);
        if pass == 0 {
            report.n_seeds = seeds.len();
            left /= 1 + HOPELESS * seeds.len() / mesh.n_quads().max(1);
        }
        let mut taken = vec![false; mesh.n_vertices()];
        let mut edits: Vec<trial::Change> = Vec::new();
        for &(worst, q) in &seeds {
            if left == 0 {
                break;
            }
            let key = key(mesh, q);
            if mesh.quads[q as usize].iter().any(|v| taken[v.index()]) || hopeless.contains(&key) {
                continue;
            }
            let most = if worst < BAD { TRIALS.0 } else { TRIALS.1 };
            let found = trial::best(&site, protected, &taken, q, most.min(left), task);
            left -= found.tried;
            report.tried += found.tried;
            match found.change {
                Some(change) => {
                    for &v in &change.touched {
                        taken[v as usize] = true;
                    }
                    edits.push(change);
                }
                None if !found.blocked => hopeless.push(key),
                None => {}
            }
        }
        if edits.is_empty() {
            break;
        }
        report.taken += edits.len();
        for change in &edits {
            for &(v, p) in &change.moved {
                mesh.points[v as usize] = p;
            }
        }
        let list: Vec<&Edit> = edits.iter().map(|c| &c.edit).collect();
        let (vertices, quads) = apply(mesh, fixed, protected, &list);
        *topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
        for e in &mut kept {
            *e = e.map(|v| VertexId(vertices[v.index()]));
        }
        kept.sort_unstable();
        compose(&mut report.vertices, &vertices);
        compose(&mut report.quads, &quads);
    }
    report
}

/// The points of a quad as a number.
fn key(mesh: &QuadMesh, q: u32) -> u64 {
    let mix = |x: u64| (x ^ x >> 31).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let bits =
        mesh.quads[q as usize].map(|v| mesh.points[v.index()]).map(|p| mix(p.x.to_bits()) ^ p.y.to_bits());
    bits.into_iter().fold(0, |sum, b| mix(sum ^ b))
}

/// Poor quads with their scaled Jacobian, the worst first, but for those that given nodes force.
fn seeds(site: &Site<'_>) -> Vec<(f64, u32)> {
    let mut out: Vec<(f64, u32)> = Vec::new();
    for (q, vs) in site.mesh.quads.iter().enumerate() {
        let sines = Corners::new(&vs.map(|v| site.mesh.points[v.index()])).scaled;
        let poor = (0..4).filter(|&k| sines[k] < POOR);
        let worst = poor.filter(|&k| !is_forced(site, q as u32, k)).map(|k| sines[k]).fold(POOR, f64::min);
        if worst < POOR {
            out.push((worst, q as u32));
        }
    }
    out.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    out
}

/// True if corner k of quad q lies between two edges that stay, and is not larger than a right angle: no mesh has a better
/// one there.
fn is_forced(site: &Site<'_>, q: u32, k: usize) -> bool {
    let vs = site.mesh.quads[q as usize];
    let stays = |from: usize| {
        let h = 4 * q as usize + (from & 3);
        site.topology.twin[h] == QuadTopology::NONE || site.keeps(vs[from & 3].0, vs[(from + 1) & 3].0)
    };
    let p = |i: usize| site.mesh.points[vs[i & 3].index()];
    stays(k) && stays(k + 3) && (p(k + 1) - p(k)).dot(p(k + 3) - p(k)) >= 0.0
}

#[cfg(test)]
mod tests;
