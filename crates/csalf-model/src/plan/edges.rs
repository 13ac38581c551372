//! Nodes on edges, each edge once: counts by the size field, repaired so that every face's total is even, positions by
//! equidistribution.
//!
//! ```text
//!   N* = ∫ ds / h      n = max(least, round N*)      ∫ ds / h from node to node the same (handbook 10.1)
//! ```

use super::parity::{self, Column};
use super::size::{STATIONS, Sizes};
use crate::brep::Model;
use glam::DVec3;

/// The nodes of one edge.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct EdgeNodes {
    /// Shares of the edge's range (0 to 1), both ends included, ascending.
    pub shares: Vec<f64>,
    /// Positions; the ends are the vertices, bit for bit.
    pub points: Vec<DVec3>,
}

impl EdgeNodes {
    /// Number of segments.
    pub fn count(&self) -> usize {
        self.shares.len().saturating_sub(1)
    }
}

/// A face whose boundary has an odd number of segments that no allowed change makes even.
#[derive(Clone, Debug, PartialEq)]
pub struct Infeasible {
    /// The faces, one of which is odd.
    pub faces: Vec<usize>,
    /// The frozen edges around them, any one of which would cure it by one segment more or less.
    pub frozen: Vec<usize>,
}

/// Counts and nodes of all edges.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Per edge; empty of edges that no face uses.
    pub edges: Vec<EdgeNodes>,
    /// Edges whose count was changed to make faces even.
    pub changed: Vec<usize>,
    /// Where that failed.
    pub infeasible: Vec<Infeasible>,
}

/// What is asked of single edges, per edge; lists may be shorter.
#[derive(Clone, Debug, Default)]
pub struct Limits {
    /// Least number of segments, per edge.
    pub least: Vec<usize>,
    /// Number of segments that must not change, per edge.
    pub frozen: Vec<Option<usize>>,
    /// Size, whatever the curvature and the rules say, per edge.
    pub sizes: Vec<Option<f64>>,
}

/// Plans all edges. Cost O(edges log edges) and the matching of odd faces.
pub fn plan(model: &Model, rules: &super::SizeRules, limits: &Limits) -> Plan {
    let sizes = super::size::sizes(model, rules, &limits.sizes);
    let uses = model.edge_uses();
    let wanted: Vec<f64> =
        (0..model.edges.len()).map(|e| cumulative(model, &sizes, e)[STATIONS - 1]).collect();
    let least = |e: usize| limits.least.get(e).copied().unwrap_or(1).max(1);
    let frozen = |e: usize| limits.frozen.get(e).copied().flatten().map(|n| n.max(1));
    let mut counts: Vec<usize> = (0..model.edges.len())
        .map(|e| {
            // More segments than this on one edge are a mistake in the units.
            const MOST: f64 = 1e5;
            frozen(e).unwrap_or_else(|| least(e).max(wanted[e].clamp(0.0, MOST).round() as usize))
        })
        .collect();
    fill_short_loops(model, &wanted, &mut counts, &|e| frozen(e).is_some());
    let columns: Vec<Column> = (0..model.edges.len())
        .map(|e| {
            let faces = parity::odd_faces(&uses[e]);
            Column { faces, cost: change(counts[e], wanted[e], least(e), frozen(e).is_some()).map(|c| c.1) }
        })
        .collect();
    let odd: Vec<bool> = model
        .faces
        .iter()
        .map(|f| f.loops.iter().flat_map(|l| &l.uses).map(|u| counts[u.edge]).sum::<usize>() % 2 == 1)
        .collect();
    let solution = parity::solve(model.faces.len(), &columns, &odd);
    let mut plan = Plan { changed: solution.toggled, ..Plan::default() };
    for &e in &plan.changed {
        if let Some((n, _)) = change(counts[e], wanted[e], least(e), false) {
            counts[e] = n;
        }
    }
    plan.infeasible = solution
        .odd_components
        .into_iter()
        .map(|faces| {
            let mut edges: Vec<usize> = faces
                .iter()
                .flat_map(|&f| &model.faces[f].loops)
                .flat_map(|l| &l.uses)
                .map(|u| u.edge)
                .collect();
            edges.sort_unstable();
            edges.dedup();
            edges.retain(|&e| frozen(e).is_some() && !columns[e].faces.is_empty());
            Infeasible { faces, frozen: edges }
        })
        .collect();
    plan.edges = (0..model.edges.len())
        .map(|e| if uses[e].is_empty() { EdgeNodes::default() } else { place(model, &sizes, e, counts[e]) })
        .collect();
    plan
}

/// Loops need four segments between them: the longest edges give more.
fn fill_short_loops(model: &Model, wanted: &[f64], counts: &mut [usize], frozen: &dyn Fn(usize) -> bool) {
    const LEAST: usize = 4;
    for l in model.faces.iter().flat_map(|f| &f.loops).filter(|l| !l.uses.is_empty()) {
        let mut total: usize = l.uses.iter().map(|u| counts[u.edge]).sum();
        while total < LEAST {
            let load = |e: usize| wanted[e] / counts[e] as f64;
            let free = l.uses.iter().map(|u| u.edge).filter(|&e| !frozen(e));
            let Some(e) = free.max_by(|a, b| load(*a).total_cmp(&load(*b)).then(b.cmp(a))) else { break };
            counts[e] += 1;
            total += l.uses.iter().filter(|u| u.edge == e).count();
        }
    }
}

/// The count one beside `n` that is nearer to the wanted one by ratio, and what it costs (handbook 10.2). `None` of a
/// frozen edge.
fn change(n: usize, wanted: f64, least: usize, frozen: bool) -> Option<(usize, f64)> {
    if frozen {
        return None;
    }
    // Costs below this count as this much, so that each change costs something.
    const FREE: f64 = 1e-3;
    let wanted = wanted.max(0.25);
    let off = |n: usize| (n as f64 / wanted).ln().abs();
    let best = if n > least && n > 1 && off(n - 1) < off(n + 1) { n - 1 } else { n + 1 };
    Some((best, (off(best) - off(n)).max(FREE)))
}

/// ∫ ds / h from the start to each station.
fn cumulative(model: &Model, sizes: &Sizes, e: usize) -> [f64; STATIONS] {
    let h = &sizes.at[e];
    let lengths = stations(model, e, sizes.lengths[e]);
    let mut sum = [0.0; STATIONS];
    for k in 1..STATIONS {
        // The size is linear between stations: the logarithmic mean, which the arithmetic one is close to.
        sum[k] = sum[k - 1] + (lengths[k] - lengths[k - 1]) * 0.5 * (1.0 / h[k - 1] + 1.0 / h[k]);
    }
    sum
}

/// Length from the start to each station.
fn stations(model: &Model, e: usize, length: f64) -> [f64; STATIONS] {
    use crate::geometry::Curve;
    let edge = &model.edges[e];
    let mut at = [0.0; STATIONS];
    let even = match &edge.curve {
        Curve::Line { .. } | Curve::Polyline(_) => true,
        Curve::Ellipse { a, b, .. } => a == b,
        Curve::Nurbs(_) => false,
    };
    let step = 1.0 / (STATIONS - 1) as f64;
    for k in 1..STATIONS {
        at[k] = if even {
            length * k as f64 * step
        } else {
            at[k - 1] + piece(edge, (k - 1) as f64 * step, k as f64 * step)
        };
    }
    at
}

/// Length between two shares of the range, by four chords.
fn piece(edge: &crate::brep::Edge, from: f64, to: f64) -> f64 {
    let at = |k: u32| edge.at(from + (to - from) * f64::from(k) / 4.0).point;
    (0..4).map(|k| at(k).distance(at(k + 1))).sum()
}

/// Places `n` segments.
fn place(model: &Model, sizes: &Sizes, e: usize, n: usize) -> EdgeNodes {
    let edge = &model.edges[e];
    let sum = cumulative(model, sizes, e);
    let total = sum[STATIONS - 1];
    let mut shares = Vec::with_capacity(n + 1);
    shares.push(0.0);
    let mut k = 0;
    for i in 1..n {
        let wanted = total * i as f64 / n as f64;
        while k + 2 < STATIONS && sum[k + 1] < wanted {
            k += 1;
        }
        let span = sum[k + 1] - sum[k];
        let within = if span > 0.0 { ((wanted - sum[k]) / span).clamp(0.0, 1.0) } else { 0.5 };
        shares.push((k as f64 + within) / (STATIONS - 1) as f64);
    }
    shares.push(1.0);
    let [a, b] = edge.ends.map(|v| model.vertices[v].point);
    let last = shares.len() - 1;
    let points = shares
        .iter()
        .enumerate()
        .map(|(i, &s)| match i {
            0 => a,
            i if i == last => b,
            _ => edge.at(s).point,
        })
        .collect();
    EdgeNodes { shares, points }
}
