//! Sewing: different vertices at one place become one, and different edges with the same ends and the same course
//! become one. Without it the mesh of a model whose faces do not share their edges cannot be conforming.
//!
//! ```text
//!   E3 ●────────● E3         E3 ●────────●        same ends, same points at 1/4, 1/2, 3/4
//!   E8 ●────────●     ─▶     E3 (used by both)
//! ```
//!
//! 1. merge vertices within the tolerance (grid of cells, lowest index wins);
//! 2. group edges by their ends;
//! 3. compare courses, both ways round; closed edges only where their vertices agree.

use super::{EdgeUse, Model};
use glam::DVec3;
use std::collections::BTreeMap;

/// Points of an edge that are compared.
const PROBES: u32 = 7;

/// Merges vertices closer than `tolerance` and edges that run within `tolerance` of each other. Returns how many
/// edges were merged. Edges of no length after that are taken out of their loops. Cost O(n log n).
pub fn sew(model: &mut Model, tolerance: f64) -> usize {
    let of = merge_vertices(model, tolerance);
    for e in &mut model.edges {
        e.ends = e.ends.map(|v| of[v]);
    }
    for v in model.faces.iter_mut().flat_map(|f| &mut f.loops).filter_map(|l| l.vertex.as_mut()) {
        *v = of[*v];
    }
    let uses = model.edge_uses();
    let mut by_ends: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for (i, e) in model.edges.iter().enumerate().filter(|(i, _)| !uses[*i].is_empty()) {
        let [a, b] = e.ends;
        by_ends.entry([a.min(b), a.max(b)]).or_default().push(i);
    }
    // For each edge, the one that it becomes and whether it runs the same way.
    let mut becomes: Vec<(usize, bool)> = (0..model.edges.len()).map(|i| (i, true)).collect();
    let mut merged = 0;
    for list in by_ends.values() {
        for (k, &i) in list.iter().enumerate() {
            let first = list[..k]
                .iter()
                .copied()
                .filter(|&j| becomes[j].0 == j)
                .find_map(|j| same_course(model, i, j, tolerance).map(|same| (j, same)));
            if let Some((j, same)) = first {
                becomes[i] = (j, same);
                model.edges[j].tolerance = model.edges[j].tolerance.max(model.edges[i].tolerance);
                merged += 1;
            }
        }
    }
    for l in model.faces.iter_mut().flat_map(|f| &mut f.loops) {
        for u in &mut l.uses {
            let (edge, same) = becomes[u.edge];
            *u = EdgeUse { edge, forward: u.forward == same };
        }
    }
    merged
}

/// For each vertex the lowest one within the tolerance (chains are followed once).
fn merge_vertices(model: &Model, tolerance: f64) -> Vec<usize> {
    let n = model.vertices.len();
    let mut of: Vec<usize> = (0..n).collect();
    if tolerance <= 0.0 {
        return of;
    }
    let cell = |p: DVec3| (p / (2.0 * tolerance)).floor().to_array().map(|x| x as i64);
    let mut cells: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for (i, v) in model.vertices.iter().enumerate() {
        if !v.point.is_finite() {
            continue;
        }
        let c = cell(v.point);
        let mut found: Option<usize> = None;
        for d in 0..27_i64 {
            let key = [
                c[0].saturating_add(d % 3 - 1),
                c[1].saturating_add(d / 3 % 3 - 1),
                c[2].saturating_add(d / 9 - 1),
            ];
            for &j in cells.get(&key).map_or(&[][..], Vec::as_slice) {
                if model.vertices[j].point.distance(v.point) <= tolerance && found.is_none_or(|f| j < f) {
                    found = Some(j);
                }
            }
        }
        match found {
            Some(j) => of[i] = j,
            None => cells.entry(c).or_default().push(i),
        }
    }
    of
}

/// Whether two edges with the same ends run along each other, and if so whether the same way.
fn same_course(model: &Model, i: usize, j: usize, tolerance: f64) -> Option<bool> {
    let (a, b) = (&model.edges[i], &model.edges[j]);
    let tolerance = tolerance.max(a.tolerance).max(b.tolerance);
    let share = |k: u32| f64::from(k) / f64::from(PROBES + 1);
    // Parameters need not run alike: the nearest point of the other curve counts.
    let near = |same: bool| {
        (1..=PROBES).all(|k| {
            let p = a.at(share(k)).point;
            let straight = b.at(if same { share(k) } else { 1.0 - share(k) }).point;
            straight.distance(p) <= tolerance
                || b.curve.eval(b.curve.nearest(p, b.range)).point.distance(p) <= tolerance
        })
    };
    if a.is_closed() {
        let quarter = |e: &super::Edge| e.at(0.25).point;
        let same = quarter(a).distance(quarter(b)) <= quarter(a).distance(b.at(0.75).point);
        return near(same).then_some(same);
    }
    let same = a.ends == b.ends;
    near(same).then_some(same)
}
