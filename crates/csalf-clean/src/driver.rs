//! Applies topological changes until there are none left, smoothing in between.
//!
//! 1. All operations look for sites on the mesh as it is.
//! 2. Their changes are applied in order ([`choose`], [`apply`]), as far as they share no vertex with one
//!    already applied in this pass. The mesh is renumbered, keeping the order of what stays.
//! 3. The mesh is smoothed. Changes that are not mandatory are undone if they did not help.
//! 4. Next pass, at most [`PASSES`].

use crate::ops::{CleanOp, Doublet, Edit, Singlet, Site};
use crate::smooth::{FinishReport, SmoothOptions, finish, smooth};
use csalf_geom::VertexId;
use csalf_mesh::{QuadMesh, QuadTopology, quality::Corners, quality::FLAT};
use csalf_sizemap::SizeField;

/// Most passes. A pass is cheap beside the mesh only if something was found; chains of doublets need one
/// each.
const PASSES: usize = 24;

/// No entity: it was removed.
pub const REMOVED: u32 = u32::MAX;

/// What [`repair`] did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RepairReport {
    /// Changes made, by operation.
    pub applied: Vec<(&'static str, usize)>,
    /// New number of each old vertex, or [`REMOVED`]. Empty if no number changed. Order is kept, new ones
    /// come last.
    pub vertices: Vec<u32>,
    /// Likewise of each old quad.
    pub quads: Vec<u32>,
    /// The last smoothing.
    pub finish: FinishReport,
}

/// Removes doublets and opens boundary singlets, then [`finish`]es the mesh. `fixed` has one entry per vertex
/// and follows the renumbering. Quads with `protected` set (one entry per quad, follows too) are never
/// edited; both lists are filled up with `false` if too short. Edges in `kept` (scars), whose ends are `fixed`, stay
/// edges. Boundary vertices are never moved, merged or
/// removed. Also returns the topology of the result.
///
/// Cost: that of [`finish`] and O(n) per pass; nothing found: one look at every vertex.
pub fn repair(
    mesh: &mut QuadMesh,
    fixed: &mut Vec<bool>,
    protected: &mut Vec<bool>,
    kept: &[[VertexId; 2]],
    size: &dyn SizeField,
    options: &SmoothOptions,
) -> (RepairReport, QuadTopology) {
    let ops: [&dyn CleanOp; 2] = [&Doublet, &Singlet];
    let mut report =
        RepairReport { applied: ops.iter().map(|o| (o.name(), 0)).collect(), ..Default::default() };
    fixed.resize(mesh.n_vertices(), false);
    protected.resize(mesh.n_quads(), false);
    let mut topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
    let mut kept = sorted(kept.iter().copied());
    // Set when no mandatory change can be made: the others may still help.
    let mut stuck = false;
    // Set when the untangler has failed. Mandatory changes do not need its help, and it is tried again at the end.
    let mut tangled = false;
    for _ in 0..PASSES {
        let site = Site { mesh, topology: &topology, fixed, kept: &kept };
        let found: Vec<(usize, Edit)> = ops
            .iter()
            .enumerate()
            .flat_map(|(i, o)| o.find(&site).into_iter().map(move |e| (i, e)))
            .collect();
        let forced = !stuck && found.iter().any(|(_, e)| e.mandatory);
        let chosen = choose(mesh, protected, found.into_iter().filter(|(_, e)| e.mandatory == forced));
        if chosen.is_empty() {
            if !forced {
                break;
            }
            stuck = true;
            continue;
        }
        let before = (mesh.clone(), fixed.clone(), protected.clone(), topology.clone());
        let worst_before = worst(mesh);
        let edits: Vec<&Edit> = chosen.iter().map(|(_, e)| e).collect();
        let (vertices, quads) = apply(mesh, fixed, protected, &edits);
        topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
        if forced && tangled {
            smooth(mesh, &topology, fixed, size, options);
        } else {
            tangled = !finish(mesh, &topology, fixed, size, options).untangle.is_positive();
        }
        if !forced && worse(worst(mesh), worst_before) {
            (*mesh, *fixed, *protected, topology) = before;
            break;
        }
        kept = sorted(kept.iter().map(|e| e.map(|v| VertexId(vertices[v.index()]))));
        compose(&mut report.vertices, &vertices);
        compose(&mut report.quads, &quads);
        for (op, _) in &chosen {
            report.applied[*op].1 += 1;
        }
    }
    report.finish = finish(mesh, &topology, fixed, size, options);
    (report, topology)
}

/// Edges as [`Site::kept`] wants them.
fn sorted(edges: impl Iterator<Item = [VertexId; 2]>) -> Vec<[VertexId; 2]> {
    let mut out: Vec<_> = edges.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    out.sort_unstable();
    out
}

/// Number of quads that are not convex, and the smallest scaled Jacobian.
fn worst(mesh: &QuadMesh) -> (usize, f64) {
    mesh.quads.iter().fold((0, 1.0), |(n, least), q| {
        let s = Corners::new(&q.map(|v| mesh.points[v.index()])).min_scaled();
        (n + usize::from(s <= FLAT), f64::min(least, s))
    })
}

fn worse(now: (usize, f64), before: (usize, f64)) -> bool {
    now.0 > before.0 || (now.0 == before.0 && now.1 < before.1)
}

/// The changes that can be made together: no protected quad, no vertex in two of them.
fn choose(
    mesh: &QuadMesh,
    protected: &[bool],
    found: impl Iterator<Item = (usize, Edit)>,
) -> Vec<(usize, Edit)> {
    let mut taken = vec![false; mesh.n_vertices()];
    let mut out = Vec::new();
    for (op, edit) in found {
        let touched = || edit.remove.iter().flat_map(|&q| mesh.quads[q as usize]);
        if edit.remove.iter().any(|&q| protected[q as usize]) || touched().any(|v| taken[v.index()]) {
            continue;
        }
        for v in touched() {
            taken[v.index()] = true;
        }
        out.push((op, edit));
    }
    out
}

/// Makes the changes, drops vertices that lost their last quad, and returns the new numbers of vertices and
/// quads.
pub(crate) fn apply(
    mesh: &mut QuadMesh,
    fixed: &mut Vec<bool>,
    protected: &mut Vec<bool>,
    edits: &[&Edit],
) -> (Vec<u32>, Vec<u32>) {
    let (n, n_quads) = (mesh.n_vertices(), mesh.n_quads());
    let mut gone = vec![false; n_quads];
    let mut touched = vec![false; n];
    for e in edits {
        for &q in &e.remove {
            gone[q as usize] = true;
            for v in mesh.quads[q as usize] {
                touched[v.index()] = true;
            }
        }
        // New points of each edit are numbered from n; move them behind those of the edits before.
        let shift = (mesh.points.len() - n) as u32;
        mesh.points.extend_from_slice(&e.points);
        for q in &e.add {
            mesh.quads.push(q.map(|v| VertexId(if (v as usize) < n { v } else { v + shift })));
        }
    }
    gone.resize(mesh.n_quads(), false);
    protected.resize(mesh.n_quads(), false);
    fixed.resize(mesh.n_vertices(), false);
    let mut used = vec![false; mesh.n_vertices()];
    for (q, vs) in mesh.quads.iter().enumerate() {
        if !gone[q] {
            for v in vs {
                used[v.index()] = true;
            }
        }
    }
    // Only what an edit has touched may vanish: an unused vertex of the caller is his.
    let kept_vertex: Vec<bool> = (0..mesh.n_vertices()).map(|v| used[v] || (v < n && !touched[v])).collect();
    let kept_quad: Vec<bool> = gone.iter().map(|g| !g).collect();
    let (vertices, quads) = (numbers(&kept_vertex), numbers(&kept_quad));
    retain(&mut mesh.points, &kept_vertex);
    retain(fixed, &kept_vertex);
    retain(&mut mesh.quads, &kept_quad);
    retain(protected, &kept_quad);
    for v in mesh.quads.iter_mut().flatten().chain(mesh.triangles.iter_mut().flatten()) {
        *v = VertexId(vertices[v.index()]);
    }
    (vertices[..n].to_vec(), quads[..n_quads].to_vec())
}

fn retain<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut k = kept.iter();
    list.retain(|_| k.next().copied().unwrap_or(true));
}

/// New numbers of what is kept.
fn numbers(kept: &[bool]) -> Vec<u32> {
    let mut next = 0;
    kept.iter()
        .map(|&k| {
            next += u32::from(k);
            if k { next - 1 } else { REMOVED }
        })
        .collect()
}

/// First `map`, then `then`.
pub(crate) fn compose(map: &mut Vec<u32>, then: &[u32]) {
    if map.is_empty() {
        map.extend_from_slice(then);
        return;
    }
    for m in map {
        *m = then.get(*m as usize).copied().unwrap_or(REMOVED);
    }
}

#[cfg(test)]
mod tests;
