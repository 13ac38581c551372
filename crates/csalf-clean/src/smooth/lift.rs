//! Lifting the worst corners: the last word where corners are still poor, by their angles alone.
//!
//! ```text
//!   poor quads + rings, rim fixed ──▶ minimise  Σ (s0 / s)^p + µ Σ s0 t / 2D   p = 4, 8, 16 ──▶ worst corner better: kept
//!                                     s: sine of a corner, s0: the smallest; t, D as in `energy`
//! ```
//!
//! 1. Seeds: quads with a poor corner of which at least one of the three vertices is free; no other can be helped.
//! 2. Free vertices within some rings around, in parts that share no quad.
//! 3. Per part L-BFGS on the sum, for growing p: the largest terms are those of the worst corners. Where a corner is not
//!    positive the sum is infinite, so that a step there is never taken.
//! 4. The positions with the largest smallest sine are written back.
//!
//! Shape and size energies weigh long thin quads as much as sharp corners; beside given nodes of very different distances
//! thin quads cannot be helped, corners can. µ keeps edges from vanishing.

use super::region::{Region, Scratch, components, grow};
use super::{bad_quads, lbfgs};
use csalf_geom::Point2;
use csalf_mesh::{QuadMesh, QuadTopology};
use rayon::prelude::*;

/// Times that the power is doubled, one after the other: p is 4, 8, 16. The larger, the nearer to the smallest sine.
/// Starting with the last ends in worse minima.
pub(crate) const DOUBLINGS: [u32; 3] = [1, 2, 3];

/// Share of the shape. Larger: shorter quads, worse corners; 0: edges vanish. *Arbitrary.*
const SHAPE: f64 = 1e-3;

/// Most L-BFGS iterations per power, for the mesh itself and for a trial.
const ITERATIONS: usize = 80;
/// See [`ITERATIONS`].
pub(crate) const TRIAL_ITERATIONS: usize = 30;
/// The relative decrease at which L-BFGS ends.
const STOP: f64 = 1e-4;

/// Lifts the corners whose sine is at most `threshold`, moving free vertices within `rings` around them. Boundary vertices
/// and those of `fixed` stay. The smallest scaled Jacobian of no part falls. Returns how many parts were made better.
/// Cost: 10 ns per quad; then per quad of a part about 10 us.
pub fn lift(
    mesh: &mut QuadMesh,
    topology: &QuadTopology,
    fixed: &[bool],
    threshold: f64,
    rings: usize,
) -> usize {
    lift_by(mesh, topology, fixed, threshold, rings, (&DOUBLINGS, ITERATIONS))
}

/// [`lift`], by these [`DOUBLINGS`] of so many iterations.
pub(crate) fn lift_by(
    mesh: &mut QuadMesh,
    topology: &QuadTopology,
    fixed: &[bool],
    threshold: f64,
    rings: usize,
    (doublings, iterations): (&[u32], usize),
) -> usize {
    let mut seeds = bad_quads(mesh, threshold);
    if seeds.is_empty() {
        return 0;
    }
    let stays = |v: usize| topology.on_boundary[v] || fixed.get(v).copied().unwrap_or(false);
    seeds.retain(|&q| {
        let vs = mesh.quads[q as usize].map(|v| v.index());
        let p = vs.map(|v| mesh.points[v]);
        (0..4).any(|k| {
            let at = [vs[k], vs[(k + 1) & 3], vs[(k + 3) & 3]];
            sine(p[k], p[(k + 1) & 3], p[(k + 3) & 3]) <= threshold && !at.into_iter().all(stays)
        })
    });
    let free = grow(mesh, topology, fixed, &seeds, rings);
    if free.is_empty() {
        return 0;
    }
    let mut scratch = Scratch::new(mesh);
    let mut parts: Vec<Region> = components(mesh, topology, &free)
        .iter()
        .map(|free| Region::new(mesh, topology, free, &mut scratch))
        .collect();
    let better: Vec<bool> = parts.par_iter_mut().map(|p| solve(p, doublings, iterations)).collect();
    for (part, _) in parts.iter().zip(&better).filter(|(_, b)| **b) {
        part.write_back(mesh);
    }
    better.into_iter().filter(|&b| b).count()
}

/// The sine of the corner at `p` between the edges to `n` and `b`; -1 if one has no length.
fn sine(p: Point2, n: Point2, b: Point2) -> f64 {
    let (u, v) = (n - p, b - p);
    let l = (u.length_squared() * v.length_squared()).sqrt();
    if l > 0.0 { u.perp_dot(v) / l } else { -1.0 }
}

/// Lifts one part; false if that did not succeed.
fn solve(part: &mut Region, doublings: &[u32], iterations: usize) -> bool {
    let corners = movable(part);
    let start = worst(part, &corners, &part.points[..part.n_free]);
    if start <= 0.0 {
        return false;
    }
    let mut x = part.points[..part.n_free].to_vec();
    let (mut best, mut at_best) = (start, None);
    let length = (part.quads.len() as f64).recip()
        * part
            .quads
            .iter()
            .map(|q| part.points[q[0] as usize].distance(part.points[q[2] as usize]))
            .sum::<f64>();
    for &doublings in doublings {
        let s0 = worst(part, &corners, &x);
        lbfgs::minimise(&mut x, iterations, 0.1 * length * s0, STOP, |x, g| {
            energy(part, &corners, x, s0, doublings, g)
        });
        let now = worst(part, &corners, &x);
        if now > best {
            (best, at_best) = (now, Some(x.clone()));
        }
    }
    let Some(x) = at_best else { return false };
    part.points[..part.n_free].copy_from_slice(&x);
    true
}

/// The corners of which not all three vertices stay: (corner, next, previous).
fn movable(part: &Region) -> Vec<[u32; 3]> {
    let n = part.n_free as u32;
    let corners = part.quads.iter().flat_map(|q| (0..4).map(|k| [q[k], q[(k + 1) & 3], q[(k + 3) & 3]]));
    corners.filter(|c| c.iter().any(|&v| v < n)).collect()
}

/// Smallest sine of the corners.
fn worst(part: &Region, corners: &[[u32; 3]], x: &[Point2]) -> f64 {
    let at = |v: u32| x.get(v as usize).copied().unwrap_or_else(|| part.points[v as usize]);
    corners.iter().map(|c| sine(at(c[0]), at(c[1]), at(c[2]))).fold(1.0, f64::min)
}

/// The sum that is minimised, and its gradient; infinite if a corner is not positive.
fn energy(
    part: &Region,
    corners: &[[u32; 3]],
    x: &[Point2],
    s0: f64,
    doublings: u32,
    gradient: &mut [Point2],
) -> f64 {
    gradient.fill(Point2::ZERO);
    let at = |v: u32| x.get(v as usize).copied().unwrap_or_else(|| part.points[v as usize]);
    let mut value = 0.0;
    for &[v, n, b] in corners {
        let p = at(v);
        let (e, f) = (at(n) - p, at(b) - p);
        let d = e.perp_dot(f);
        if d <= 0.0 {
            return f64::INFINITY;
        }
        let (le, lf, r) = (e.length_squared(), f.length_squared(), d.recip());
        let power = (0..doublings).fold(s0 * s0 * le * lf * r * r, |square, _| square * square);
        let shape = SHAPE * s0 * 0.5 * (le + lf) * r;
        value += power + shape;
        // By D, then by the edges.
        let m = f64::from(2u32 << doublings) * power;
        let by_d = -(m + shape) * r;
        let by = |l: f64| m / l + SHAPE * s0 * r;
        let ge = by(le) * e + by_d * Point2::new(f.y, -f.x);
        let gf = by(lf) * f + by_d * Point2::new(-e.y, e.x);
        for (v, g) in [(n, ge), (b, gf), (v, -ge - gf)] {
            if let Some(s) = gradient.get_mut(v as usize) {
                *s += g;
            }
        }
    }
    value
}
