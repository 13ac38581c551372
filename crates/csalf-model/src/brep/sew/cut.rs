//! Cuts edges of one face alone where others end, so that both sides of a joint have the same edges.
//!
//! 1. free edges: in use once; their ends are the vertices to cut at;
//! 2. a tree of boxes around pieces of the free edges tells which a vertex may lie on;
//! 3. those whose curve passes within the tolerance of it, away from their ends, are cut at the nearest parameter;
//! 4. loops that used the edge use its parts in order.

use super::super::{Edge, EdgeUse, Model, VertexIndex};
use glam::DVec3;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::collections::BTreeSet;

/// Pieces of an edge with a box each. More: fewer edges looked at in vain.
const PIECES: u32 = 8;
/// Points within a piece that its box holds.
const WITHIN: u32 = 4;

type Piece = GeomWithData<Rectangle<[f64; 3]>, usize>;

/// Cuts free edges of the model, whose vertices are merged already, at the vertices of others within `tolerance`.
/// Returns how many cuts were made.
pub(super) fn cut(model: &mut Model, tolerance: f64) -> usize {
    let free: Vec<usize> = model.free_edges().collect();
    if free.len() < 2 {
        return 0;
    }
    let tree = RTree::bulk_load(free.iter().flat_map(|&i| boxes(&model.edges[i], i, tolerance)).collect());
    let vertices: BTreeSet<VertexIndex> = free.iter().flat_map(|&i| model.edges[i].ends).collect();
    let mut at: Vec<(usize, f64, VertexIndex)> = Vec::new();
    for v in vertices {
        let p = model.vertices[v].point;
        if !p.is_finite() {
            continue;
        }
        let near: BTreeSet<usize> =
            tree.locate_all_at_point(p.to_array()).map(|piece: &Piece| piece.data).collect();
        at.extend(near.into_iter().filter_map(|i| {
            let e = &model.edges[i];
            if e.ends.contains(&v) {
                return None;
            }
            let t = e.curve.nearest(p, e.range);
            let q = e.curve.eval(t).point;
            let away = e.ends.iter().all(|&w| model.vertices[w].point.distance(q) > tolerance);
            (away && q.distance(p) <= tolerance).then_some((
                i,
                (t - e.range[0]) / (e.range[1] - e.range[0]),
                v,
            ))
        }));
    }
    at.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut parts: Vec<Vec<usize>> = (0..model.edges.len()).map(|i| vec![i]).collect();
    let mut n_cuts = 0;
    for cuts in at.chunk_by(|a, b| a.0 == b.0) {
        let i = cuts[0].0;
        let whole = model.edges[i].clone();
        let mut stops = vec![(0.0, whole.ends[0])];
        for &(_, s, v) in cuts {
            let (last, w) = stops[stops.len() - 1];
            // Two vertices at one place of the curve: the first stands for both.
            if s > last && s < 1.0 && whole.at(s).point.distance(model.vertices[w].point) > tolerance {
                stops.push((s, v));
            }
        }
        n_cuts += stops.len() - 1;
        stops.push((1.0, whole.ends[1]));
        let t = |s: f64| if s < 1.0 { whole.parameter(s) } else { whole.range[1] };
        for (k, w) in stops.windows(2).enumerate() {
            let part = Edge { range: [t(w[0].0), t(w[1].0)], ends: [w[0].1, w[1].1], ..whole.clone() };
            if k == 0 {
                model.edges[i] = part;
            } else {
                parts[i].push(model.edges.len());
                model.edges.push(Edge { name: format!("{}_{}", whole.name, k + 1), ..part });
            }
        }
    }
    for l in model.faces.iter_mut().flat_map(|f| &mut f.loops) {
        if l.uses.iter().all(|u| parts[u.edge].len() == 1) {
            continue;
        }
        let split = |u: &EdgeUse| {
            let mut of: Vec<EdgeUse> =
                parts[u.edge].iter().map(|&edge| EdgeUse { edge, forward: u.forward }).collect();
            if !u.forward {
                of.reverse();
            }
            of
        };
        l.uses = l.uses.iter().flat_map(split).collect();
    }
    n_cuts
}

/// Boxes around the pieces of edge `i`, wider by the tolerance and by what the curve may bulge between its points.
fn boxes(e: &Edge, i: usize, tolerance: f64) -> Vec<Piece> {
    let n = PIECES * WITHIN;
    let points: Vec<DVec3> = (0..=n).map(|k| e.at(f64::from(k) / f64::from(n)).point).collect();
    if points.iter().any(|p| !p.is_finite()) {
        return Vec::new();
    }
    let piece = |p: &[DVec3]| {
        let (lo, hi) = p.iter().fold((p[0], p[0]), |(lo, hi), q| (lo.min(*q), hi.max(*q)));
        let bulge = p.windows(2).map(|w| w[0].distance(w[1])).fold(0.0, f64::max);
        let wider = DVec3::splat(tolerance + 0.5 * bulge);
        let of = Rectangle::from_aabb(AABB::from_corners((lo - wider).to_array(), (hi + wider).to_array()));
        GeomWithData::new(of, i)
    };
    points.windows(WITHIN as usize + 1).step_by(WITHIN as usize).map(piece).collect()
}
