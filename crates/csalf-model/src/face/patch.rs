//! Meshes a patch of facets: the mesh nodes of its edges are put into the facets, then `csalf_surface` does the rest.
//!
//! ```text
//!     facet edges on the patch's boundary   ●────────────●──────●      ○ mesh nodes on them: the facet beside each is
//!                                           ●──○────○────●──○───●        split into a fan
//! ```

use super::NodeName;
use super::mesh::{Context, MeshedFace, layers_of, name_nodes, vertex_sizes};
use super::points::{Hard, nearest_facet};
use crate::facets::Patch;
use csalf_surface::{FaceInput, FaceLoop, FaceSize, Facets, mesh_face};
use std::collections::BTreeMap;

/// A triangle whose area is this share of the square of a side is a line, with rounding.
const NO_AREA: f64 = 1e-12;

pub(super) fn mesh_patch(
    cx: &Context<'_>,
    index: usize,
    patch: &Patch,
    hard: &[Hard],
) -> Result<MeshedFace, String> {
    let face = &cx.model.faces[index];
    let has_area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| patch.points[v as usize]);
        (b - a).cross(c - a).length() > NO_AREA * a.distance(b).max(b.distance(c)).powi(2)
    };
    if !patch.triangles.iter().any(has_area) {
        return Err("its facets have no area".into());
    }
    let mut facets = Facets { points: patch.points.clone(), triangles: patch.triangles.clone() };
    let (spots, hard) = add_points(&mut facets, patch, hard);
    let mut names: Vec<Option<NodeName>> = vec![None; facets.points.len()];
    for (&v, &(_, k)) in spots.iter().zip(&hard) {
        names[v as usize] = Some(NodeName::Own(k));
    }
    let mut loops: Vec<FaceLoop> = Vec::new();
    // New vertices on sides of the patch's boundary, in the direction of the loop.
    let mut splits: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for (source, (l, chains)) in face.loops.iter().zip(&patch.chains).enumerate() {
        let mut nodes = Vec::new();
        for (u, chain) in l.uses.iter().zip(chains) {
            let edge = &cx.plan.edges[u.edge];
            let numbers = &cx.table.of_edge[u.edge];
            let n = edge.count();
            if n == 0 || chain.len() < 2 {
                return Err("an edge of it has no nodes".into());
            }
            let mut length = vec![0.0];
            for w in chain.windows(2) {
                let d = patch.points[w[0] as usize].distance(patch.points[w[1] as usize]);
                length.push(length[length.len() - 1] + d);
            }
            let total = length[length.len() - 1];
            let mut k = 0;
            for i in 0..n {
                let at = if u.forward { i } else { n - i };
                let number = numbers[at];
                if i == 0 {
                    nodes.push((chain[0], number));
                    continue;
                }
                let wanted = total * if u.forward { edge.shares[at] } else { 1.0 - edge.shares[at] };
                while k + 2 < chain.len() && length[k + 1] < wanted {
                    k += 1;
                }
                // A node at a facet vertex takes it over; nearer than this share of the side is there.
                const AT: f64 = 1e-6;
                let span = length[k + 1] - length[k];
                let within = (wanted - length[k]) / span;
                let v = if within <= AT && k > 0 {
                    chain[k]
                } else if within >= 1.0 - AT && k + 2 < chain.len() {
                    chain[k + 1]
                } else {
                    facets.points.push(cx.table.points[number as usize]);
                    names.push(None);
                    let v = facets.points.len() as u32 - 1;
                    splits.entry([chain[k], chain[k + 1]]).or_default().push(v);
                    v
                };
                nodes.push((v, number));
            }
        }
        for &(v, number) in &nodes {
            names[v as usize] = Some(NodeName::Model(number));
            facets.points[v as usize] = cx.table.points[number as usize];
        }
        let layers = layers_of(cx, index, source);
        loops.push(FaceLoop { nodes: nodes.iter().map(|n| n.0).collect(), layers });
    }
    split_sides(&mut facets, &splits);
    let sizes = if loops.is_empty() { Vec::new() } else { vertex_sizes(cx, face, &facets, &loops, &|_| 0.0) };
    let input = FaceInput {
        facets: &facets,
        loops: &loops,
        scars: &[],
        points: &spots,
        size: if loops.is_empty() {
            FaceSize::Uniform(cx.rules.of_face(&face.name))
        } else {
            FaceSize::Vertices(&sizes)
        },
        flat: None,
        surface: None,
    };
    let sources: Vec<usize> = (0..loops.len()).collect();
    let mesh = mesh_face(&input, cx.options).map_err(|e| e.to_string())?;
    let mut out = name_nodes(&mesh, &names, &sources, spots.len() as u32);
    for (&v, &(_, k)) in spots.iter().zip(&hard) {
        out.own[k as usize] = facets.points[v as usize];
    }
    out.hard = hard;
    Ok(out)
}

/// Puts hard points into the facets that they lie on: each facet falls into three. Returns the new vertices, and for each
/// which of the given points it is and its number.
fn add_points(facets: &mut Facets, patch: &Patch, hard: &[Hard]) -> (Vec<u32>, Vec<(usize, u32)>) {
    let (mut spots, mut numbers) = (Vec::new(), Vec::new());
    for h in hard {
        // The facets as they are by now: a second point may fall into a part of the first one's facet.
        let now =
            Patch { points: facets.points.clone(), triangles: facets.triangles.clone(), ..Patch::default() };
        let Some((_, i, at)) = nearest_facet(if spots.is_empty() { patch } else { &now }, h.point) else {
            continue;
        };
        let v = facets.points.len() as u32;
        facets.points.push(at);
        let t = facets.triangles[i];
        facets.triangles[i] = [t[0], t[1], v];
        facets.triangles.extend([[t[1], t[2], v], [t[2], t[0], v]]);
        spots.push(v);
        numbers.push((h.index, numbers.len() as u32));
    }
    (spots, numbers)
}

/// Splits the facets beside sides with new vertices: a fan from the corner opposite; of two or three such sides one
/// after the other.
fn split_sides(facets: &mut Facets, splits: &BTreeMap<[u32; 2], Vec<u32>>) {
    let mut todo = std::mem::take(&mut facets.triangles);
    todo.reverse();
    while let Some(t) = todo.pop() {
        let side = (0..3).find_map(|k| {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let forward = splits.get(&[a, b]).cloned();
            let backward = || splits.get(&[b, a]).map(|v| v.iter().rev().copied().collect());
            forward.or_else(backward).map(|new: Vec<u32>| (k, new))
        });
        let Some((k, new)) = side else {
            facets.triangles.push(t);
            continue;
        };
        let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
        let chain: Vec<u32> = [a].into_iter().chain(new).chain([b]).collect();
        // The parts have no split side of this name any more; their other sides may have one.
        todo.extend(chain.windows(2).rev().map(|w| [w[0], w[1], c]));
    }
}
