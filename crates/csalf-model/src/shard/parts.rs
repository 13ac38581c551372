//! Faces dealt out to parts of about the same work.
//!
//! ```text
//!   cost of a face = segments around it + area / h²      largest first, each to the part with the least so far
//! ```
//!
//! R. L. Graham, Bounds on multiprocessing timing anomalies, 1969: no part has more than 4/3 of what is best. Costs only
//! balance: no mesh depends on them.

use crate::Prepared;
use crate::brep::{Face, FaceShape};
use crate::geometry::Surface;
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The faces of each part, ascending.
pub(super) fn parts(prepared: &Prepared<'_>, count: u32) -> Vec<Vec<usize>> {
    let mut parts = vec![Vec::new(); count as usize];
    if !prepared.frame.able {
        return parts;
    }
    let costs: Vec<f64> = prepared.model.faces.iter().map(|f| cost(prepared, f)).collect();
    let mut order: Vec<usize> = (0..costs.len()).collect();
    order.sort_by(|a, b| costs[*b].total_cmp(&costs[*a]).then(a.cmp(b)));
    // Loads are not negative, so that their bits sort as they do.
    let mut loads: BinaryHeap<Reverse<(u64, usize)>> = (0..parts.len()).map(|k| Reverse((0, k))).collect();
    for f in order {
        let Some(Reverse((load, k))) = loads.pop() else { break };
        parts[k].push(f);
        loads.push(Reverse(((f64::from_bits(load) + costs[f]).to_bits(), k)));
    }
    parts.iter_mut().for_each(|p| p.sort_unstable());
    parts
}

/// Estimated work on a face: about its number of quads; positive and finite.
fn cost(prepared: &Prepared<'_>, face: &Face) -> f64 {
    /// No face costs less than this, whatever its size.
    const LEAST: f64 = 16.0;
    let edges = &prepared.plan.edges;
    let rings: Vec<Vec<DVec3>> = face
        .loops
        .iter()
        .map(|l| {
            let mut ring = Vec::new();
            for u in &l.uses {
                let points = &edges[u.edge].points;
                let n = points.len().saturating_sub(1);
                ring.extend((0..n).map(|i| points[if u.forward { i } else { n - i }]));
            }
            ring
        })
        .collect();
    let segments: usize = rings.iter().map(Vec::len).sum();
    let length: f64 =
        rings.iter().flat_map(|r| (0..r.len()).map(|i| r[i].distance(r[(i + 1) % r.len()]))).sum();
    let h = if segments > 0 { length / segments as f64 } else { prepared.rules.of_face(&face.name) };
    let quads = area(face, &rings) / (h * h);
    let cost = LEAST + segments as f64 + quads;
    if cost.is_finite() { cost } else { LEAST }
}

/// Roughly the area of a face within its rings of nodes.
fn area(face: &Face, rings: &[Vec<DVec3>]) -> f64 {
    let vector = |r: &Vec<DVec3>| (0..r.len()).map(|i| r[i].cross(r[(i + 1) % r.len()])).sum::<DVec3>();
    match &face.shape {
        FaceShape::Facets(p) => {
            let corners = p.triangles.iter().map(|t| t.map(|v| p.points[v as usize]));
            corners.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
        }
        FaceShape::Surface(Surface::Plane(_), _) => 0.5 * rings.iter().map(vector).sum::<DVec3>().length(),
        FaceShape::Surface(Surface::Sphere { radius, .. }, _) if rings.is_empty() => {
            4.0 * std::f64::consts::PI * radius * radius
        }
        FaceShape::Surface(Surface::Torus { major, minor, .. }, _) if rings.is_empty() => {
            4.0 * std::f64::consts::PI * std::f64::consts::PI * major * minor
        }
        // Half the surface of the box around the nodes.
        FaceShape::Surface(..) | FaceShape::Unread => {
            let (lo, hi) = rings
                .iter()
                .flatten()
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
            let d = (hi - lo).max(DVec3::ZERO);
            d.x * d.y + d.y * d.z + d.z * d.x
        }
    }
}
