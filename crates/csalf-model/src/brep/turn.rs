//! Turns faces that are the other way round than their neighbours: such files have normals that point in and out by
//! turns.
//!
//! ```text
//!   A ──▶──        both run along their edge in the same way:        A ──▶──
//!   B ──▶──        one of them is turned                      ─▶     B ──◀──
//! ```
//!
//! 1. faces that share an edge, of two uses each, make components; each face is held against the first of its own;
//! 2. a component in which all agree, or that cannot agree (a Möbius strip), stays as it is;
//! 3. else a closed component is turned outside out: where its edges reach farthest in 26 directions, normals are to
//!    point that way; of an open one the fewer faces are turned.

use super::{EdgeUse, Face, FaceIndex, FaceShape, Model};
use crate::geometry::Inverter;
use glam::DVec3;

/// Points of an edge that are looked at.
const SAMPLES: u32 = 8;

/// Turns faces so that neighbours agree. Returns how many were turned. Cost O(n), and some dozens of inversions per
/// component with faces to turn.
pub fn turn_alike(model: &mut Model) -> usize {
    let n = model.faces.len();
    let uses = model.edge_uses();
    let mut neighbours: Vec<Vec<(FaceIndex, bool)>> = vec![Vec::new(); n];
    for u in &uses {
        if let [(f, a), (g, b)] = u[..]
            && f != g
        {
            let agree = a.forward != b.forward;
            neighbours[f].push((g, agree));
            neighbours[g].push((f, agree));
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; n];
    let mut n_turned = 0;
    for first in 0..n {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        let (mut faces, mut consistent) = (vec![first], true);
        let mut k = 0;
        while let Some(&f) = faces.get(k) {
            k += 1;
            let is = turned[f] == Some(true);
            for &(g, agree) in &neighbours[f] {
                match turned[g] {
                    None => {
                        turned[g] = Some(is == agree);
                        faces.push(g);
                    }
                    Some(other) => consistent &= other == (is == agree),
                }
            }
        }
        let mut wrong: Vec<FaceIndex> = faces.iter().copied().filter(|&f| turned[f] == Some(true)).collect();
        let is_facets = |f: &FaceIndex| matches!(model.faces[*f].shape, FaceShape::Facets(_));
        if wrong.is_empty() || !consistent || faces.iter().any(is_facets) {
            continue;
        }
        let is_closed = faces.iter().flat_map(|&f| edges(&model.faces[f])).all(|e| uses[e].len() == 2);
        let others = || faces.iter().copied().filter(|&f| turned[f] == Some(false)).collect();
        let inside_out = match is_closed.then(|| outward(model, &uses, &faces, &turned)).flatten() {
            Some(outward) => !outward,
            None => 2 * wrong.len() > faces.len(),
        };
        if inside_out {
            wrong = others();
        }
        n_turned += wrong.len();
        for f in wrong {
            turn(&mut model.faces[f]);
        }
    }
    n_turned
}

/// The edges of a face.
fn edges(face: &Face) -> impl Iterator<Item = usize> + '_ {
    face.loops.iter().flat_map(|l| &l.uses).map(|u| u.edge)
}

/// Turns a face on a surface round.
fn turn(face: &mut Face) {
    if let FaceShape::Surface(_, forward) = &mut face.shape {
        *forward = !*forward;
    }
    for l in &mut face.loops {
        l.uses.reverse();
        l.uses.iter_mut().for_each(|u| u.forward = !u.forward);
    }
}

/// Whether the normals of a closed component point outward, once its faces are turned as said; `None` if that cannot be
/// told.
fn outward(
    model: &Model,
    uses: &[Vec<(FaceIndex, EdgeUse)>],
    faces: &[FaceIndex],
    turned: &[Option<bool>],
) -> Option<bool> {
    let samples: Vec<(usize, DVec3)> = faces
        .iter()
        .flat_map(|&f| edges(&model.faces[f]))
        .flat_map(|e| (0..=SAMPLES).map(move |k| (e, f64::from(k) / f64::from(SAMPLES))))
        .map(|(e, s)| (e, model.edges[e].at(s).point))
        .filter(|(_, p)| p.is_finite())
        .collect();
    let mut votes = 0;
    for k in (0..27).filter(|k| *k != 13) {
        let d = DVec3::new(f64::from(k % 3 - 1), f64::from(k / 3 % 3 - 1), f64::from(k / 9 - 1));
        let &(edge, p) = samples.iter().max_by(|a, b| a.1.dot(d).total_cmp(&b.1.dot(d)))?;
        let normals = uses[edge].iter().filter_map(|&(f, _)| {
            let FaceShape::Surface(surface, forward) = &model.faces[f].shape else { return None };
            let inverter = Inverter::new(surface);
            let n = surface.eval(inverter.invert(p, None, 0.0).0).normal();
            Some(if *forward == (turned[f] == Some(true)) { -n } else { n })
        });
        let along: f64 = normals.map(|n| n.dot(d)).sum();
        votes += i32::from(along > 0.0) - i32::from(along < 0.0);
    }
    (votes != 0).then_some(votes > 0)
}
