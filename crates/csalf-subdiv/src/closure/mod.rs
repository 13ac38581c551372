//! Closes contours of 4, 6 and 8 nodes by the stencil that suits their angles best.
//!
//! ```text
//!   5──────4──────3      5─────4─────3      how many quads does each node want (its angle / 90°),
//!   │      │      │       ╲    │   ╱        how many does it get? Left 211211 in a rectangle,
//!   │      │      │        ╲   6  ╱         right a stencil with one inner node of valence 3,
//!   │      │      │         ╲╱  ╲╱          121212 in a triangle.
//!   0──────1──────2          0   2
//!                             ╲ ╱
//!                              1
//! ```
//!
//! 1. Every placement (stencil, rotation, reflection) costs sum (d_i - wanted_i)² over the rim plus sum (d - 4)² +
//!    0.15 over its inner nodes.
//! 2. In order of that cost: put the inner nodes at the limit of Laplace sweeps (weights known beforehand, one small
//!    matrix product), measure the smallest scaled Jacobian, add -2 min(SJ, 0.5). Stop when no later one can win.
//! 3. If the winner is poor, or none is valid: move inner nodes by a pattern search for the largest smallest SJ.
//! 4. Accept if SJ >= [`LEAST_SJ`] and every corner is strictly convex by exact `orient2d`.
//!
//! No allocation after the first call, which builds the placements.
//! Source: handbook 4.9.

#[cfg(test)]
mod generate;
mod table;
#[cfg(test)]
mod tests;

use csalf_geom::{Point2, predicates::is_left};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};
use table::{MAX_INNER, MAX_QUADS, MAX_RIM, Placement, placements};

/// Stencils with a smaller scaled Jacobian are refused (handbook 4.9).
pub const LEAST_SJ: f64 = 0.05;
/// A winner below this is improved by moving its inner nodes. Larger: better quads, more time; at 0.4 few need it.
const POOR_SJ: f64 = 0.4;
/// SJ above this earns nothing in the choice: the valences decide (handbook 4.9).
const ENOUGH_SJ: f64 = 0.5;
/// So many of the cheapest placements are tried with a pattern search when none is valid without.
const N_RESCUES: usize = 4;

/// A closed contour: local name `i < n` is rim node i, `n + k` is new point k.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClosureResult {
    points: [Point2; MAX_INNER],
    n_points: usize,
    quads: [[u8; 4]; MAX_QUADS],
    n_quads: usize,
}

impl ClosureResult {
    /// The new points.
    pub fn points(&self) -> &[Point2] {
        &self.points[..self.n_points]
    }

    /// The quads in local names, counter-clockwise.
    pub fn quads(&self) -> &[[u8; 4]] {
        &self.quads[..self.n_quads]
    }
}

/// Closes the contour `rim` of 4, 6 or 8 nodes, material on the left. `wanted[i]`: how many quads node i should get,
/// a real number: angle / 90° at a node of the geometry, 4 less the quads it has already at a free node.
/// Returns the smallest scaled Jacobian, in [[`LEAST_SJ`], 1], and writes the quads to `out`; `None` if no stencil
/// is good enough, or for other numbers of nodes. `out` is then unchanged.
///
/// Cost: about 0.3 µs for 6 nodes, 1.3 µs for 8; 2 µs and more where inner nodes must be moved.
pub fn close(rim: &[Point2], wanted: &[f64], out: &mut ClosureResult) -> Option<f64> {
    let found = select(rim, wanted)?;
    let p = found.placement;
    let exact = p.quads[..p.n_quads].iter().all(|q| {
        let v = q.map(|v| p.at(rim, &found.inner, v));
        (0..4).all(|k| is_left(v[k], v[(k + 1) & 3], v[(k + 2) & 3]))
    });
    if !exact {
        return None;
    }
    *out = ClosureResult { points: found.inner, n_points: p.n_inner, quads: p.quads, n_quads: p.n_quads };
    Some(found.sj)
}

/// As [`close`], but of any shape: the quads may overlap and turn over. For contours that lie between nodes which may
/// still move, before an untangler has run: the valences count most. False for other numbers of nodes.
pub fn close_loosely(rim: &[Point2], wanted: &[f64], out: &mut ClosureResult) -> bool {
    let n = rim.len();
    let all = placements(n);
    if wanted.len() != n {
        return false;
    }
    let mut best: Option<(f64, Found)> = None;
    for p in all {
        let found = smooth(p, rim);
        let rim_cost: f64 = (0..n).map(|i| (p.valence[i] - wanted[i]).powi(2)).sum();
        let score = p.cost + rim_cost - 2.0 * found.sj.min(ENOUGH_SJ);
        if best.is_none_or(|b| score < b.0) {
            best = Some((score, found));
        }
    }
    let Some((_, Found { placement: p, inner, .. })) = best else { return false };
    *out = ClosureResult { points: inner, n_points: p.n_inner, quads: p.quads, n_quads: p.n_quads };
    true
}

/// What [`close`] would return, and the number of quads, without the exact check. Cost as of [`close`].
pub fn appraise(rim: &[Point2], wanted: &[f64]) -> Option<(f64, usize)> {
    select(rim, wanted).map(|found| (found.sj, found.placement.n_quads))
}

/// True if a stencil exists whose quads all have a scaled Jacobian of `least` or more; inner nodes may move. As
/// [`appraise`], but stops at the first, and tries none that the angles of the rim forbid.
pub fn can_reach(rim: &[Point2], wanted: &[f64], least: f64) -> bool {
    let n = rim.len();
    let all = placements(n);
    if all.is_empty() || wanted.len() != n {
        return false;
    }
    // The best that d quads at one rim node can have is the sine of its d-th part.
    let allowed = |p: &&Placement| {
        (0..n).all(|i| {
            let part = wanted[i] / p.valence[i];
            part < 2.0 && (part * FRAC_PI_2).sin() >= least
        })
    };
    if all.iter().filter(allowed).any(|p| smooth_above(p, rim, least.next_down()).sj >= least) {
        return true;
    }
    all.iter().filter(allowed).filter(|p| p.n_inner > 0).take(N_RESCUES).any(|p| {
        let mut found = smooth(p, rim);
        improve_to(&mut found, rim, least);
        found.sj >= least
    })
}

/// A placement with its inner points.
#[derive(Clone, Copy)]
struct Found {
    placement: &'static Placement,
    inner: [Point2; MAX_INNER],
    sj: f64,
}

/// At least the number of placements for 8 nodes, 66.
const MAX_PLACEMENTS: usize = 72;

fn select(rim: &[Point2], wanted: &[f64]) -> Option<Found> {
    let n = rim.len();
    let all = placements(n);
    if all.is_empty() || wanted.len() != n || all.len() > MAX_PLACEMENTS {
        return None;
    }
    let mut cost = [f64::INFINITY; MAX_PLACEMENTS];
    for (c, p) in cost.iter_mut().zip(all) {
        *c = p.cost + (0..n).map(|i| (p.valence[i] - wanted[i]).powi(2)).sum::<f64>();
    }
    // Valid ones in order of cost, until none can win any more.
    let mut left = cost;
    let mut best: Option<(f64, Found)> = None;
    loop {
        let (k, c) = least(&left);
        if !c.is_finite() || best.is_some_and(|b| c - 2.0 * ENOUGH_SJ >= b.0) {
            break;
        }
        left[k] = f64::INFINITY;
        let found = smooth(&all[k], rim);
        let score = c - 2.0 * found.sj.min(ENOUGH_SJ);
        if found.sj >= LEAST_SJ && best.is_none_or(|b| score < b.0) {
            best = Some((score, found));
        }
    }
    match best {
        Some((_, mut found)) => {
            if found.sj < POOR_SJ {
                improve(&mut found, rim);
            }
            Some(found)
        }
        None => rescue(&cost, all, rim),
    }
}

/// Index and value of the smallest entry, the first of equal ones.
fn least(cost: &[f64; MAX_PLACEMENTS]) -> (usize, f64) {
    let mut best = (0, f64::INFINITY);
    for (k, &c) in cost.iter().enumerate() {
        if c < best.1 {
            best = (k, c);
        }
    }
    best
}

/// The best of the cheapest placements after a pattern search.
fn rescue(cost: &[f64; MAX_PLACEMENTS], all: &'static [Placement], rim: &[Point2]) -> Option<Found> {
    let mut left = *cost;
    for (c, _) in left.iter_mut().zip(all).filter(|(_, p)| p.n_inner == 0) {
        *c = f64::INFINITY;
    }
    let mut best: Option<(f64, Found)> = None;
    for _ in 0..N_RESCUES {
        let (k, c) = least(&left);
        if !c.is_finite() {
            break;
        }
        left[k] = f64::INFINITY;
        let mut found = smooth(&all[k], rim);
        improve(&mut found, rim);
        let score = c - 2.0 * found.sj.min(ENOUGH_SJ);
        if found.sj >= LEAST_SJ && best.is_none_or(|b| score < b.0) {
            best = Some((score, found));
        }
    }
    best.map(|b| b.1)
}

/// Inner nodes at the limit of Laplace sweeps.
fn smooth(placement: &'static Placement, rim: &[Point2]) -> Found {
    smooth_above(placement, rim, f64::NEG_INFINITY)
}

/// As [`smooth`]; the SJ need not be exact if it is `bar` or less.
fn smooth_above(placement: &'static Placement, rim: &[Point2], bar: f64) -> Found {
    let mut inner = [Point2::ZERO; MAX_INNER];
    // Relative to the first node, to keep the digits far from the origin.
    let o = rim[0];
    for (q, w) in inner.iter_mut().zip(&placement.weight).take(placement.n_inner) {
        *q = o + rim.iter().zip(w).map(|(&r, &w)| w * (r - o)).sum::<Point2>();
    }
    let sj = min_sj(placement, rim, &inner, bar);
    Found { placement, inner, sj }
}

/// Smallest scaled Jacobian of the quads; -1 if a side has no length. If it is `bar` or less, any number up to `bar`.
fn min_sj(p: &Placement, rim: &[Point2], inner: &[Point2; MAX_INNER], bar: f64) -> f64 {
    let mut least = 1.0f64;
    for q in &p.quads[..p.n_quads] {
        if least <= bar {
            return least;
        }
        let v = q.map(|v| p.at(rim, inner, v));
        let e: [Point2; 4] = std::array::from_fn(|k| v[(k + 1) & 3] - v[k]);
        let l = e.map(|e| e.length());
        for k in 0..4 {
            let (i, j) = (k, (k + 1) & 3);
            let scale = l[i] * l[j];
            if scale == 0.0 {
                return -1.0;
            }
            least = least.min(e[i].perp_dot(e[j]) / scale);
        }
    }
    least
}

/// Pattern search for the largest smallest SJ: each inner node tries eight directions; the step halves when none
/// helps. The directions turn with the contour.
fn improve(found: &mut Found, rim: &[Point2]) {
    improve_to(found, rim, 1.0);
}

/// As [`improve`], until the smallest SJ is `enough`.
fn improve_to(found: &mut Found, rim: &[Point2], enough: f64) {
    let p = found.placement;
    if p.n_inner == 0 {
        return;
    }
    let n = rim.len();
    let mean = (0..n).map(|i| rim[i].distance(rim[(i + 1) % n])).sum::<f64>() / n as f64;
    let axis = (rim[1] - rim[0]).normalize_or(Point2::X);
    let mut step = 0.5 * mean;
    for _ in 0..N_STEPS {
        if found.sj >= enough {
            return;
        }
        let mut helped = false;
        for k in 0..p.n_inner {
            let start = found.inner[k];
            let mut best = (found.sj, start);
            let mut trial = found.inner;
            let mut d = axis * step;
            for _ in 0..8 {
                trial[k] = start + d;
                let sj = min_sj(p, rim, &trial, best.0);
                if sj > best.0 {
                    best = (sj, trial[k]);
                }
                d = Point2::new(d.x - d.y, d.x + d.y) * FRAC_1_SQRT_2; // by 45 degrees
            }
            helped |= best.0 > found.sj;
            (found.sj, found.inner[k]) = best;
        }
        if !helped {
            step *= 0.5;
        }
    }
}

/// Steps of the pattern search: halvings down to a hundredth of a segment and as many moves.
const N_STEPS: usize = 14;

// Local names are bytes, and `points` of a result are as many as the table allows.
const _: () = assert!(MAX_RIM + MAX_INNER <= u8::MAX as usize);
