//! Target sizes on edges: global, by curvature, by name; graded along edges and through vertices.
//!
//! ```text
//!   h = min(size of the model, of the face, of the edge, 2π / (k n))     k: curvature, n: elements per full turn
//!   h <= h(other end) + g * length                                       gradation, over the graph of edges
//! ```
//!
//! Handbook 8.2, 8.3, 10.1.

use crate::brep::{Edge, FaceShape, Model};
use crate::geometry::{Curve, Inverter, Surface};
use glam::DVec3;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

/// Stations per edge at which its size is known.
pub(crate) const STATIONS: usize = 17;

/// A point of a surface stands for the station of an edge if it is nearer than this share of the smallest size: edges of
/// files miss their surfaces by more than their tolerance, and then the whole surface is searched.
const NEAR: f64 = 0.1;

/// What sizes are asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeRules {
    /// Edge length where nothing else asks for less, > 0.
    pub size: f64,
    /// Curvature asks for no less than this.
    pub min_size: f64,
    /// Elements per full turn of a curve or surface; 0: curvature does not matter.
    pub per_turn: f64,
    /// Largest growth of the size per length.
    pub gradation: f64,
    /// Sizes of faces, by pattern of names; the smallest counts.
    pub faces: Vec<(String, f64)>,
    /// Sizes of edges, by pattern of names; the last that fits counts, whatever the curvature.
    pub edges: Vec<(String, f64)>,
}

impl SizeRules {
    /// Rules with one size, the rest by default: 12 elements per turn, growth 0.3, curvature down to a tenth.
    pub const fn of(size: f64) -> Self {
        Self {
            size,
            min_size: size * 0.1,
            per_turn: 12.0,
            gradation: 0.3,
            faces: Vec::new(),
            edges: Vec::new(),
        }
    }

    /// Rules for a model of which nothing is asked: a fortieth of its diagonal.
    pub fn of_model(model: &Model) -> Self {
        const SHARE: f64 = 1.0 / 40.0;
        Self::of(model.diagonal() * SHARE)
    }

    /// The size for a curvature (1/length), at most `most`.
    pub fn for_curvature(&self, k: f64, most: f64) -> f64 {
        if self.per_turn <= 0.0 || k <= 0.0 {
            return most;
        }
        (TAU / (k * self.per_turn)).max(self.min_size).min(most)
    }

    /// The size asked for on a face by name.
    pub fn of_face(&self, name: &str) -> f64 {
        let named = self.faces.iter().filter(|(p, _)| crate::names::matches(p, name));
        named.map(|(_, h)| *h).fold(self.size, f64::min)
    }
}

/// Sizes at the stations of every edge.
#[derive(Clone, Debug)]
pub(crate) struct Sizes {
    /// `STATIONS` values per edge, at even shares of its range.
    pub(crate) at: Vec<[f64; STATIONS]>,
    /// Length of each edge.
    pub(crate) lengths: Vec<f64>,
}

/// Sizes of all edges; `given` are those of single edges, which go before all others. Cost O(uses), and inversions for
/// NURBS faces.
pub(crate) fn sizes(model: &Model, rules: &SizeRules, given: &[Option<f64>]) -> Sizes {
    let share = |k: usize| k as f64 / (STATIONS - 1) as f64;
    let lengths: Vec<f64> = model.edges.iter().map(Edge::length).collect();
    let mut at: Vec<[f64; STATIONS]> = model
        .edges
        .iter()
        .map(|e| {
            let mut h = [rules.size; STATIONS];
            match &e.curve {
                Curve::Line { .. } => {}
                Curve::Polyline(_) => {
                    for (h, k) in h.iter_mut().zip(bends(e)) {
                        *h = rules.for_curvature(k, rules.size);
                    }
                }
                _ => {
                    for (k, h) in h.iter_mut().enumerate() {
                        *h = rules.for_curvature(e.at(share(k)).curvature(), rules.size);
                    }
                }
            }
            h
        })
        .collect();
    for face in &model.faces {
        let most = rules.of_face(&face.name);
        let FaceShape::Surface(surface, _) = &face.shape else {
            for u in face.loops.iter().flat_map(|l| &l.uses) {
                at[u.edge].iter_mut().for_each(|h| *h = h.min(most));
            }
            continue;
        };
        let inverter = Inverter::new(surface);
        for u in face.loops.iter().flat_map(|l| &l.uses) {
            let mut hint = None;
            for (k, h) in at[u.edge].iter_mut().enumerate() {
                let wanted = match surface {
                    Surface::Plane(_) => most,
                    Surface::Cylinder { radius, .. } | Surface::Sphere { radius, .. } => {
                        rules.for_curvature(1.0 / radius.abs(), most)
                    }
                    _ if rules.per_turn <= 0.0 => most,
                    _ => {
                        let edge = &model.edges[u.edge];
                        // Curvature changes little over a hundredth of the size.
                        let good = edge.tolerance.max(NEAR * rules.min_size);
                        let (uv, _) = inverter.invert(edge.at(share(k)).point, hint, good);
                        hint = Some(uv);
                        rules.for_curvature(surface.eval(uv).max_curvature(), most)
                    }
                };
                *h = h.min(wanted);
            }
        }
    }
    for (e, (edge, h)) in model.edges.iter().zip(&mut at).enumerate() {
        let named = || rules.edges.iter().rev().find(|(p, _)| crate::names::matches(p, &edge.name));
        if let Some(wanted) = given.get(e).copied().flatten().or_else(|| named().map(|n| n.1)) {
            *h = [wanted; STATIONS];
        }
    }
    let mut sizes = Sizes { at, lengths };
    grade(model, rules.gradation, &mut sizes);
    sizes
}

/// The curvature of a polyline at the stations: the turn from the chord before to the chord behind, over their mean
/// length. Noise shorter than that does not count.
fn bends(edge: &Edge) -> [f64; STATIONS] {
    const LAST: usize = STATIONS - 1;
    let points: [DVec3; STATIONS] = std::array::from_fn(|k| edge.at(k as f64 / LAST as f64).point);
    let mut out = [0.0; STATIONS];
    for k in 0..=LAST {
        let (before, behind) = match k {
            0 | LAST if edge.is_closed() => (LAST - 1, 1),
            0 | LAST => continue,
            k => (k - 1, k + 1),
        };
        let (a, b) = (points[k] - points[before], points[behind] - points[k]);
        let length = 0.5 * (a.length() + b.length());
        if length > 0.0 {
            out[k] = a.cross(b).length().atan2(a.dot(b)) / length;
        }
    }
    if !edge.is_closed() {
        (out[0], out[LAST]) = (out[1], out[LAST - 1]);
    }
    out
}

/// Limits the growth along edges and through vertices: Dijkstra over the vertices.
fn grade(model: &Model, g: f64, sizes: &mut Sizes) {
    let within = |h: &mut [f64; STATIONS], step: f64| {
        for k in 1..STATIONS {
            h[k] = h[k].min(h[k - 1] + g * step);
        }
        for k in (0..STATIONS - 1).rev() {
            h[k] = h[k].min(h[k + 1] + g * step);
        }
    };
    let step = |e: usize, lengths: &[f64]| lengths[e] / (STATIONS - 1) as f64;
    let mut at_vertex = vec![f64::INFINITY; model.vertices.len()];
    let mut edges_at = vec![Vec::new(); model.vertices.len()];
    for (e, edge) in model.edges.iter().enumerate() {
        within(&mut sizes.at[e], step(e, &sizes.lengths));
        for (end, h) in [(0, sizes.at[e][0]), (1, sizes.at[e][STATIONS - 1])] {
            let v = edge.ends[end];
            at_vertex[v] = at_vertex[v].min(h);
            edges_at[v].push(e);
        }
    }
    // Smallest size first; sizes are positive, so that their bits sort as they do.
    let mut heap: BinaryHeap<(std::cmp::Reverse<u64>, usize)> =
        (0..at_vertex.len()).map(|v| (std::cmp::Reverse(at_vertex[v].to_bits()), v)).collect();
    while let Some((std::cmp::Reverse(bits), v)) = heap.pop() {
        if bits != at_vertex[v].to_bits() {
            continue;
        }
        for &e in &edges_at[v] {
            let [a, b] = model.edges[e].ends;
            let other = if a == v { b } else { a };
            let h = at_vertex[v] + g * sizes.lengths[e];
            if h < at_vertex[other] {
                at_vertex[other] = h;
                heap.push((std::cmp::Reverse(h.to_bits()), other));
            }
        }
    }
    for (e, edge) in model.edges.iter().enumerate() {
        let h = &mut sizes.at[e];
        h[0] = h[0].min(at_vertex[edge.ends[0]]);
        h[STATIONS - 1] = h[STATIONS - 1].min(at_vertex[edge.ends[1]]);
        within(h, step(e, &sizes.lengths));
    }
}
