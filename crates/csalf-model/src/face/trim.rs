//! The loops of a face in the parameters of its surface.
//!
//! ```text
//!   cylinder, u from left to right     ●──●──●──●──●      a loop round the axis: it ends one period from where it
//!                                      u0          u0+2π  began (winding +1)
//! ```
//!
//! 1. Seams go: an edge that one face uses in both directions, on a surface that closes, is taken out; its loop falls
//!    into two, or two loops become one.
//! 2. Each node is inverted near the one before it; the curve is sampled between nodes so that no turn is missed.
//! 3. At a pole, u is taken from the node before and the node after: two places, one node.

use super::{NodeName, NodeTable};
use crate::brep::{EdgeUse, Loop, Model};
use crate::geometry::{Inverter, Surface};
use crate::plan::EdgeNodes;
use glam::{DVec2, DVec3};

/// A node in the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvNode {
    pub(super) name: NodeName,
    pub(super) uv: DVec2,
    pub(super) point: DVec3,
}

/// A loop in the parameters, the material on its left (seen against the surface's normal).
#[derive(Clone, Debug, PartialEq, Default)]
pub(super) struct UvLoop {
    pub(super) nodes: Vec<UvNode>,
    /// Turns made in u and in v.
    pub(super) winding: [i32; 2],
    /// Index of the loop of the face that it came from.
    pub(super) source: usize,
}

/// Loops without the seams of a closed surface, each with the index of the loop it came from.
pub(super) fn without_seams(loops: &[Loop], surface: &Surface) -> Vec<(usize, Vec<EdgeUse>)> {
    let mut out: Vec<(usize, Vec<EdgeUse>)> =
        loops.iter().enumerate().map(|(k, l)| (k, l.uses.clone())).collect();
    if surface.periods() == [None, None] {
        return out;
    }
    // Each round takes one edge out, so that this ends.
    while let Some((a, b)) = twice_used(&out) {
        if a.0 == b.0 {
            let (source, uses) = out[a.0].clone();
            let inner = uses[a.1 + 1..b.1].to_vec();
            let rest = uses[b.1 + 1..].iter().chain(&uses[..a.1]).copied().collect();
            out[a.0] = (source, rest);
            out.insert(a.0 + 1, (source, inner));
        } else {
            let (_, second) = out.remove(b.0);
            let first = out[a.0].1.clone();
            let chain =
                first[..a.1].iter().chain(&second[b.1 + 1..]).chain(&second[..b.1]).chain(&first[a.1 + 1..]);
            out[a.0].1 = chain.copied().collect();
        }
    }
    out.retain(|(_, uses)| !uses.is_empty());
    out
}

/// The two places (loop, position) of the first edge that is used in both directions.
fn twice_used(loops: &[(usize, Vec<EdgeUse>)]) -> Option<((usize, usize), (usize, usize))> {
    let places = || {
        loops
            .iter()
            .enumerate()
            .flat_map(|(i, (_, uses))| uses.iter().enumerate().map(move |(j, u)| (u, (i, j))))
    };
    let mut sorted: Vec<(EdgeUse, (usize, usize))> = places().map(|(u, at)| (*u, at)).collect();
    sorted.sort_unstable();
    let pairs = sorted.windows(2).filter(|w| w[0].0.edge == w[1].0.edge && w[0].0.forward != w[1].0.forward);
    pairs.map(|w| (w[0].1.min(w[1].1), w[0].1.max(w[1].1))).min()
}

/// The nodes of a chain of edge uses, in the direction of the loop, the last of each edge left out.
pub(super) fn chain_nodes(
    model: &Model,
    edges: &[EdgeNodes],
    table: &NodeTable,
    uses: &[EdgeUse],
) -> Vec<(u32, DVec3, Vec<DVec3>)> {
    /// Samples of the curve between two nodes.
    const BETWEEN: u32 = 3;
    let mut out = Vec::new();
    for u in uses {
        let (e, nodes) = (&model.edges[u.edge], &edges[u.edge]);
        let n = nodes.count();
        for i in 0..n {
            let (k, next) = if u.forward { (i, i + 1) } else { (n - i, n - i - 1) };
            let (s, t) = (nodes.shares[k], nodes.shares[next]);
            let sample = |j: u32| e.at(s + (t - s) * f64::from(j) / f64::from(BETWEEN + 1)).point;
            let number = table.of_edge[u.edge][k];
            // The table's position, which merged vertices share.
            out.push((number, table.points[number as usize], (1..=BETWEEN).map(sample).collect()));
        }
    }
    out
}

/// A loop in the parameters. `forward` is false if the face's normal is against the surface's: the loop is reversed.
pub(super) fn trim_loop(
    inverter: &Inverter<'_>,
    nodes: &[(u32, DVec3, Vec<DVec3>)],
    source: usize,
    forward: bool,
    tolerance: f64,
) -> UvLoop {
    let surface = inverter.surface();
    let poles = surface.poles();
    // A point at a pole: the line of u through it is shorter than this.
    let pole_of = |uv: DVec2| {
        poles.iter().flatten().copied().find(|&v| {
            let at_pole = surface.eval(DVec2::new(uv.x, v)).point;
            at_pole.distance(surface.eval(uv).point) <= tolerance
        })
    };
    let mut loop_ = UvLoop { source, ..UvLoop::default() };
    // Places in order, poles with no u yet.
    let mut places: Vec<(NodeName, DVec3, Option<DVec2>, f64)> = Vec::new();
    let mut hint: Option<DVec2> = None;
    let mut first: Option<DVec2> = None;
    for (number, point, between) in nodes {
        let (uv, _) = inverter.invert(*point, hint, tolerance);
        match pole_of(uv) {
            Some(v) => places.push((NodeName::Model(*number), *point, None, v)),
            None => {
                places.push((NodeName::Model(*number), *point, Some(uv), 0.0));
                first = first.or(Some(uv));
                hint = Some(uv);
            }
        }
        for p in between {
            let (uv, _) = inverter.invert(*p, hint, tolerance);
            if pole_of(uv).is_none() {
                hint = Some(uv);
                first = first.or(Some(uv));
            }
        }
    }
    // Where the loop ends, against where it began.
    if let Some((start, last)) = places.iter().find_map(|p| p.2).zip(hint) {
        let back = inverter.near(start, last);
        let periods = surface.periods();
        let turns = |d: f64, p: Option<f64>| p.map_or(0, |p| (d / p).round() as i32);
        loop_.winding = [turns(back.x - start.x, periods[0]), turns(back.y - start.y, periods[1])];
    }
    let n = places.len();
    for i in 0..n {
        let (name, point, uv, v) = places[i];
        if let Some(uv) = uv {
            loop_.nodes.push(UvNode { name, uv, point });
            continue;
        }
        let before = (1..n).find_map(|k| places[(i + n - k) % n].2);
        let after = (1..n).find_map(|k| places[(i + k) % n].2);
        let (Some(b), Some(a)) = (before, after) else { continue };
        loop_.nodes.push(UvNode { name, uv: DVec2::new(b.x, v), point });
        loop_.nodes.push(UvNode { name, uv: DVec2::new(a.x, v), point });
    }
    if !forward {
        loop_.nodes.reverse();
        loop_.winding = loop_.winding.map(|w| -w);
    }
    loop_
}
