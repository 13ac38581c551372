//! The certificate: what every mesh is checked for before it is handed out.

use crate::MeshError;
use crate::mend::is_bad;
use csalf_geom::arrangement::Arrangement;
use csalf_geom::{QuadId, VertexId};
use csalf_mesh::{QuadMesh, QuadTopology, is_strictly_convex, validate};
use rayon::prelude::*;

/// Quads, or sides, that one task of the certificate looks at.
const CHUNK: usize = 1 << 14;

/// The certificate that every mesh carries: strictly convex quads by exact predicates, conforming, the given boundary
/// and nothing else, the area of the domain (together these exclude overlaps and gaps), scars and hard points kept.
///
/// `exact`: predicates alone decide about shapes; else flat quads, and those with two vertices that are one by the
/// tolerance, are refused as well.
pub(crate) fn certify(
    mesh: &QuadMesh,
    topology: &QuadTopology,
    arrangement: &Arrangement,
    exact: bool,
) -> Result<(), MeshError> {
    let fail = |detail: String| Err(MeshError::Internal { stage: "certify", detail });
    let refused = |q: &[VertexId; 4]| {
        let p = q.map(|v| mesh.points[v.index()]);
        if exact { !is_strictly_convex(&p) } else { is_bad(&p, arrangement.tolerance) }
    };
    let position =
        |(c, quads): (usize, &[[VertexId; 4]])| quads.iter().position(refused).map(|q| c * CHUNK + q);
    if let Some(q) = mesh.quads.par_chunks(CHUNK).enumerate().filter_map(position).min() {
        let p = mesh.corners(QuadId::new(q));
        return fail(format!("quad {q} at {:?} is not convex, flat, or has two vertices in one place", p[0]));
    }
    if topology.n_bad_edges > 0 {
        return fail(format!("{} edges do not conform", topology.n_bad_edges));
    }
    certify_curves(mesh, topology, arrangement)?;
    // About a point of the domain, so that the digits are kept far from the origin.
    let o = mesh.points.first().copied().unwrap_or_default();
    let twice = |a: VertexId, b: VertexId, c: VertexId, d: VertexId| {
        let p = |v: VertexId| mesh.points[v.index()] - o;
        (p(c) - p(a)).perp_dot(p(d) - p(b))
    };
    // Chunk by chunk, so that the sum does not depend on the number of threads.
    let chunk = |quads: &[[VertexId; 4]]| quads.iter().map(|q| twice(q[0], q[1], q[2], q[3])).sum::<f64>();
    let quads: f64 = mesh.quads.par_chunks(CHUNK).map(chunk).collect::<Vec<_>>().iter().sum();
    let triangles: f64 = mesh.triangles.iter().map(|t| twice(t[0], t[1], t[2], t[0])).sum();
    let area = 0.5 * (quads + triangles);
    if (area - arrangement.area).abs() > validate::AREA_TOLERANCE * arrangement.area {
        return fail(format!("the area is {area}, that of the domain {}", arrangement.area));
    }
    Ok(())
}

/// The part of [`certify`] that looks at curves: the edges used once are exactly the given segments, in direction;
/// every scar segment is an edge; every hard point is used.
fn certify_curves(
    mesh: &QuadMesh,
    topology: &QuadTopology,
    arrangement: &Arrangement,
) -> Result<(), MeshError> {
    let fail = |detail: String| Err(MeshError::Internal { stage: "certify", detail });
    let mut next = vec![None; arrangement.points.len()];
    for l in &arrangement.loops {
        for (i, &v) in l.iter().enumerate() {
            next[v as usize] = Some(VertexId(l[(i + 1) % l.len()]));
        }
    }
    let given = |a: VertexId, b: VertexId| next.get(a.index()).is_some_and(|&n| n == Some(b));
    let ends = |h: usize| (mesh.quads[h / 4][h & 3], mesh.quads[h / 4][(h + 1) & 3]);
    let sides = || mesh.triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3])));
    let mut n_given = sides().filter(|&(a, b)| given(a, b)).count();
    let open = topology.twin.par_iter().with_min_len(CHUNK).enumerate();
    let open: Vec<usize> = open.filter(|&(_, &t)| t == QuadTopology::NONE).map(|(h, _)| h).collect();
    for (a, b) in open.into_iter().map(ends) {
        if given(a, b) {
            n_given += 1;
        } else if !sides().any(|side| side == (b, a)) {
            return fail(format!(
                "edge {a} {b} is on the boundary of the mesh and not on that of the domain"
            ));
        }
    }
    let n_segments = arrangement.loops.iter().map(Vec::len).sum::<usize>();
    if n_given != n_segments {
        return fail(format!("{n_given} of {n_segments} boundary segments are edges"));
    }
    let is_edge = |a: VertexId, b: VertexId| topology.star(a).iter().any(|&h| ends(h as usize).1 == b);
    for s in arrangement.scars.iter().flat_map(|s| s.windows(2)) {
        let (a, b) = (VertexId(s[0]), VertexId(s[1]));
        if !is_edge(a, b) && !is_edge(b, a) && !sides().any(|side| side == (a, b) || side == (b, a)) {
            return fail(format!("scar segment {a} {b} is not an edge"));
        }
    }
    for v in arrangement.hard_points.iter().map(|&v| VertexId(v)) {
        if topology.n_quads_at(v) == 0 && !sides().any(|side| side.0 == v) {
            return fail(format!("hard point {v} is not used"));
        }
    }
    Ok(())
}
