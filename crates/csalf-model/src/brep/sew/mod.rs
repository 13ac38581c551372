//! Sewing: what lies at one place becomes one. Without it the mesh of a model whose faces do not share their edges
//! cannot be conforming.
//!
//! ```text
//!   E3 ●───────────────● E3          E3 ●──────●────────●  E3_2      face A
//!   E8 ●──────●────────●  E9   ─▶    the same two edges              face B
//! ```
//!
//! 1. merge vertices within the tolerance (grid of cells, lowest index wins); an edge whose ends become one by that, and
//!    that goes nowhere in between, leaves its loops;
//! 2. cut edges of one face alone where such edges of others end ([`cut`]);
//! 3. group edges by their ends; compare courses, both ways round; closed edges only where their vertices agree;
//! 4. faces whose loops are now nothing but edges there and back, on surfaces that do not close in themselves (whose
//!    seams are such edges), are slivers thinner than the tolerance: they are left out, and their neighbours meet.

mod cut;

use super::{EdgeUse, Face, FaceShape, Model};
use glam::DVec3;
use std::collections::BTreeMap;

/// Points of an edge that are compared.
const PROBES: u32 = 7;

/// An edge whose ends were merged is a point if it is not longer than so many tolerances, else a closed curve. (A
/// circle of that diameter is π long.)
const POINT: f64 = 3.0;

/// Tolerances that [`sew_closed`] tries, as shares of the model's diagonal.
const SHARES: [f64; 3] = [1e-6, 1e-5, 1e-4];

/// What was sewn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sewn {
    /// Within which distance, length.
    pub tolerance: f64,
    /// Edges that became others.
    pub n_edges: usize,
    /// Times that an edge was cut where another ends.
    pub n_cuts: usize,
    /// Names of the faces that were thinner than the tolerance, and are no longer in the model.
    pub slivers: Vec<String>,
}

/// Sews within 1e-6 of the model's diagonal; or, where that leaves edges of one face alone and 1e-5 or 1e-4 leaves
/// none, within that: a model that a tolerance closes was drawn with it. A sheet has a rim, and stays as near as it was
/// drawn. Cost: [`sew`], and twice more if the model is open.
pub fn sew_closed(model: &mut Model) -> Sewn {
    let diagonal = model.diagonal();
    let [near, wider @ ..] = SHARES;
    let sewn = sew(model, near * diagonal);
    let is_open = |m: &Model| !has_facets(m) && m.free_edges().next().is_some();
    for share in wider.into_iter().take_while(|_| is_open(model)) {
        let mut trial = model.clone();
        let more = sew(&mut trial, share * diagonal);
        if !is_open(&trial) {
            *model = trial;
            return Sewn {
                tolerance: more.tolerance,
                n_edges: sewn.n_edges + more.n_edges,
                n_cuts: sewn.n_cuts + more.n_cuts,
                slivers: [sewn.slivers, more.slivers].concat(),
            };
        }
    }
    sewn
}

/// Merges vertices closer than `tolerance` (length) and edges that run within `tolerance` of each other; edges of one
/// face alone are cut for it where others of that kind end. The model keeps its order; parts of a cut edge are named
/// after it, with `_2`, `_3`, ... Faces thinner than the tolerance are taken out. Nothing is done for a tolerance that
/// is not positive, nor to models of facets, which were welded when they were made. Cost O(n log n).
pub fn sew(model: &mut Model, tolerance: f64) -> Sewn {
    let mut sewn = Sewn { tolerance, ..Sewn::default() };
    if tolerance.is_nan() || tolerance <= 0.0 || has_facets(model) {
        return sewn;
    }
    let had_sides: Vec<bool> = model.faces.iter().map(has_sides).collect();
    let of = merge_vertices(model, tolerance);
    let mut is_point = vec![false; model.edges.len()];
    for (e, is_point) in model.edges.iter_mut().zip(&mut is_point) {
        let was_closed = e.is_closed();
        e.ends = e.ends.map(|v| of[v]);
        *is_point = !was_closed && e.is_closed() && e.length() <= POINT * tolerance;
    }
    for l in model.faces.iter_mut().flat_map(|f| &mut f.loops) {
        l.vertex = l.vertex.map(|v| of[v]);
        l.uses.retain(|u| !is_point[u.edge]);
    }
    sewn.n_cuts = cut::cut(model, tolerance);
    let becomes = match_edges(model, tolerance);
    sewn.n_edges = becomes.iter().enumerate().filter(|(i, b)| b.0 != *i).count();
    for l in model.faces.iter_mut().flat_map(|f| &mut f.loops) {
        for u in &mut l.uses {
            let (edge, same) = becomes[u.edge];
            *u = EdgeUse { edge, forward: u.forward == same };
        }
    }
    let is_sliver = |(f, had): (&Face, bool)| had && !has_sides(f) && !may_close(&f.shape);
    let gone: Vec<bool> = model.faces.iter().zip(had_sides).map(is_sliver).collect();
    sewn.slivers = take_out(model, &gone);
    sewn
}

fn has_facets(model: &Model) -> bool {
    model.faces.iter().any(|f| matches!(f.shape, FaceShape::Facets(_)))
}

/// False for a face whose loops run along each of their edges as often one way as the other: it has no area, or is
/// closed in itself.
fn has_sides(face: &Face) -> bool {
    let mut balance: BTreeMap<usize, i32> = BTreeMap::new();
    for u in face.loops.iter().flat_map(|l| &l.uses) {
        *balance.entry(u.edge).or_default() += if u.forward { 1 } else { -1 };
    }
    balance.values().any(|&b| b != 0)
}

/// True if a face of this shape may have an area within its seams alone.
fn may_close(shape: &FaceShape) -> bool {
    match shape {
        FaceShape::Surface(s, _) => s.periods().iter().any(Option::is_some),
        FaceShape::Facets(_) | FaceShape::Unread => true,
    }
}

/// Takes faces out of the model and its bodies; returns their names.
fn take_out(model: &mut Model, gone: &[bool]) -> Vec<String> {
    let mut kept = 0;
    let becomes: Vec<Option<usize>> = gone
        .iter()
        .map(|&gone| {
            kept += usize::from(!gone);
            (!gone).then(|| kept - 1)
        })
        .collect();
    for b in &mut model.bodies {
        b.faces = b.faces.iter().filter_map(|&f| becomes.get(f).copied().flatten()).collect();
    }
    let names =
        model.faces.iter().zip(gone).filter(|(_, gone)| **gone).map(|(f, _)| f.name.clone()).collect();
    let mut gone = gone.iter();
    model.faces.retain(|_| !gone.next().copied().unwrap_or(false));
    names
}

/// For each edge the one that it becomes, and whether that runs the same way.
fn match_edges(model: &mut Model, tolerance: f64) -> Vec<(usize, bool)> {
    let uses = model.edge_uses();
    let mut by_ends: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for (i, e) in model.edges.iter().enumerate().filter(|(i, _)| !uses[*i].is_empty()) {
        let [a, b] = e.ends;
        by_ends.entry([a.min(b), a.max(b)]).or_default().push(i);
    }
    let mut becomes: Vec<(usize, bool)> = (0..model.edges.len()).map(|i| (i, true)).collect();
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
            }
        }
    }
    becomes
}

/// For each vertex the lowest one within the tolerance (chains are followed once).
fn merge_vertices(model: &Model, tolerance: f64) -> Vec<usize> {
    let n = model.vertices.len();
    let mut of: Vec<usize> = (0..n).collect();
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
