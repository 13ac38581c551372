//! Unrolling a patch without curvature: facet by facet, each laid beside its neighbour in its true shape.

use super::Flat;
use crate::patch::{Chart, NONE, next};
use glam::DVec2;

/// Largest angle (radians) that may be missing round an inner vertex, or be too much.
const CURVED: f64 = 1e-5;
/// Largest gap where two ways round meet, as a share of the diagonal.
const GAP: f64 = 1e-6;

/// The unrolled chart, or `None` if it has curvature or does not close round its holes. Cost O(n).
pub(crate) fn unroll(chart: &Chart) -> Option<Flat> {
    if is_curved(chart) {
        return None;
    }
    let gap = GAP * chart.diagonal();
    let mut flat = vec![DVec2::NAN; chart.vertex.len()];
    let mut done = vec![false; chart.triangles.len()];
    let p = |v: u32| chart.points[v as usize];
    // Start with the facet of the longest side: the least rounding.
    let h0 = (0..chart.across.len() as u32).max_by(|&g, &h| {
        let l = |h: u32| p(chart.tail(h)).distance_squared(p(chart.tail(next(h))));
        l(g).total_cmp(&l(h)).then(h.cmp(&g))
    })?;
    let (a, b) = (chart.tail(h0), chart.tail(next(h0)));
    flat[a as usize] = DVec2::ZERO;
    flat[b as usize] = DVec2::new(p(a).distance(p(b)), 0.0);
    let mut queue = std::collections::VecDeque::from([h0]);
    done[h0 as usize / 3] = true;
    while let Some(h) = queue.pop_front() {
        // Ends of side h are laid; lay the corner opposite.
        let (a, b, c) = (chart.tail(h), chart.tail(next(h)), chart.tail(next(next(h))));
        let (e, f) = (p(b) - p(a), p(c) - p(a));
        let l = e.length();
        if l <= 0.0 {
            return None;
        }
        let (along, height) = (f.dot(e) / l, f.cross(e).length() / l);
        let x = (flat[b as usize] - flat[a as usize]).normalize_or_zero();
        let at = flat[a as usize] + along * x + height * x.perp();
        let slot = &mut flat[c as usize];
        if slot.is_nan() {
            *slot = at;
        } else if slot.distance(at) > gap {
            return None;
        }
        for g in [h, next(h), next(next(h))].map(|s| chart.across[s as usize]) {
            if g != NONE && !std::mem::replace(&mut done[g as usize / 3], true) {
                queue.push_back(g);
            }
        }
    }
    flat.iter().all(|p| p.is_finite()).then_some(flat)
}

/// Whether the angles round some inner vertex do not sum to a full turn.
fn is_curved(chart: &Chart) -> bool {
    missing(chart).iter().any(|a| a.abs() > CURVED)
}

/// The integral of the absolute value of the curvature over the inside: the angles missing round vertices.
pub(super) fn total_curvature(chart: &Chart) -> f64 {
    missing(chart).iter().map(|a| a.abs()).sum()
}

/// The angle missing to a full turn round each inner vertex; 0 on the boundary.
fn missing(chart: &Chart) -> Vec<f64> {
    let mut left = vec![std::f64::consts::TAU; chart.vertex.len()];
    for t in &chart.triangles {
        let p = t.map(|v| chart.points[v as usize]);
        for k in 0..3 {
            let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            left[t[k] as usize] -= u.cross(v).length().atan2(u.dot(v));
        }
    }
    for &h in chart.loops.iter().flatten() {
        left[chart.tail(h) as usize] = 0.0;
    }
    left
}
