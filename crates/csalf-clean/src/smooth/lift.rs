//! Lifting the worst corners: the last word where corners are still poor, by their angles, and by their sides where these
//! are very uneven.
//!
//! ```text
//!   poor quads + rings, rim fixed ──▶ minimise  Σ (w0 / w)^p + µ Σ w0 t / 2D   p = 4, 8, 16 ──▶ worst corner better: kept
//!                                     w: worth of a corner, w0: the smallest; t, D as in `energy`
//!
//!   w = sine / sqrt(1 + κ (r² + 1/r²))      r: the sides of the corner, one over the other
//! ```
//!
//! 1. Seeds: quads with a poor corner of which at least one of the three vertices is free; no other can be helped.
//! 2. Free vertices within some rings around, in parts that share no quad.
//! 3. Per part L-BFGS on the sum, for growing p: the largest terms are those of the worst corners. Where a corner is not
//!    positive the sum is infinite, so that a step there is never taken.
//! 4. The positions with the largest smallest worth are written back.
//!
//! Shape and size energies weigh long thin quads as much as sharp corners; beside given nodes of very different distances
//! thin quads cannot be helped, corners can. But by sines alone a side may vanish while all corners look well: κ counts
//! sides of less than a thirtieth of their neighbours like poor angles, and µ draws on the others a little.

use super::lbfgs;
use super::region::{Region, Scratch, components, grow};
use csalf_geom::{Point2, VertexId};
use csalf_mesh::{QuadMesh, QuadTopology};
use rayon::prelude::*;

/// Times that the power is doubled, one after the other: p is 4, 8, 16. The larger, the nearer to the smallest worth.
/// Starting with the last ends in worse minima.
pub(crate) const DOUBLINGS: [u32; 3] = [1, 2, 3];

/// Share of the shape. Larger: shorter quads, worse corners; 0: edges vanish. *Arbitrary.*
const SHAPE: f64 = 1e-3;

/// κ: sides of 1 to κ^(-1/2) make a corner worth 0.7 of its sine. Larger: fewer very short sides, smaller sines. Of 198 jobs with
/// sizes of up to 1:1000, quads with a side below 1/1000 of the longest: 157 at 0, 81 at 1e-3, 46 at 1e-2; jobs with a sine
/// below 0.1 that is not forced: 3.2, 3.2, 5.0 %.
const UNEVEN: f64 = 1e-3;

/// Most L-BFGS iterations per power, for the mesh itself and for a trial.
const ITERATIONS: usize = 80;
/// See [`ITERATIONS`].
pub(crate) const TRIAL_ITERATIONS: usize = 30;
/// The relative decrease at which L-BFGS ends.
const STOP: f64 = 1e-4;

/// Lifts the corners worth at most `threshold`, moving free vertices within `rings` around them. Boundary vertices
/// and those of `fixed` stay. The smallest worth of no part falls. Returns how many parts were made better.
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
    let stays =
        |v: VertexId| topology.on_boundary[v.index()] || fixed.get(v.index()).copied().unwrap_or(false);
    let is_poor = |vs: &[VertexId; 4]| {
        (0..4).any(|k| {
            let at = [vs[k], vs[(k + 1) & 3], vs[(k + 3) & 3]];
            let [p, n, b] = at.map(|v| mesh.points[v.index()]);
            worth(p, n, b) <= threshold && !at.into_iter().all(stays)
        })
    };
    let seeds: Vec<u32> = (0u32..).zip(&mesh.quads).filter(|(_, vs)| is_poor(vs)).map(|(q, _)| q).collect();
    if seeds.is_empty() {
        return 0;
    }
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

/// The worth of the corner at `p` between the edges to `n` and `b`; -1 if one has no length.
pub(crate) fn worth(p: Point2, n: Point2, b: Point2) -> f64 {
    let (u, v) = (n - p, b - p);
    let l = lengths(u.length_squared(), v.length_squared()).sqrt();
    if l > 0.0 { u.perp_dot(v) / l } else { -1.0 }
}

/// The smallest worth of the corners of a quad.
pub(crate) fn worth_of(p: &[Point2; 4]) -> f64 {
    (0..4).map(|k| worth(p[k], p[(k + 1) & 3], p[(k + 3) & 3])).fold(1.0, f64::min)
}

/// What the square of a corner's area is divided by, of the squares of its sides.
fn lengths(le: f64, lf: f64) -> f64 {
    le * lf + UNEVEN * (le * le + lf * lf)
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
        let w0 = worst(part, &corners, &x);
        lbfgs::minimise(&mut x, iterations, 0.1 * length * w0, STOP, |x, g| {
            energy(part, &corners, x, w0, doublings, g)
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

/// Smallest worth of the corners.
fn worst(part: &Region, corners: &[[u32; 3]], x: &[Point2]) -> f64 {
    let at = |v: u32| x.get(v as usize).copied().unwrap_or_else(|| part.points[v as usize]);
    corners.iter().map(|c| worth(at(c[0]), at(c[1]), at(c[2]))).fold(1.0, f64::min)
}

/// The sum that is minimised, and its gradient; infinite if a corner is not positive.
fn energy(
    part: &Region,
    corners: &[[u32; 3]],
    x: &[Point2],
    w0: f64,
    doublings: u32,
    gradient: &mut [Point2],
) -> f64 {
    gradient.fill(Point2::ZERO);
    let at = |v: u32| x.get(v as usize).copied().unwrap_or_else(|| part.points[v as usize]);
    let mut value = 0.0;
    for &[v, n, w] in corners {
        let p = at(v);
        let (e, f) = (at(n) - p, at(w) - p);
        let d = e.perp_dot(f);
        if d <= 0.0 {
            return f64::INFINITY;
        }
        let (le, lf, r) = (e.length_squared(), f.length_squared(), d.recip());
        let b = lengths(le, lf);
        let power = (0..doublings).fold(w0 * w0 * b * r * r, |square, _| square * square);
        let shape = SHAPE * w0 * 0.5 * (le + lf) * r;
        value += power + shape;
        // By D, then by the edges.
        let m = f64::from(2u32 << doublings) * power;
        let by_d = -(m + shape) * r;
        let by = |l: f64, other: f64| m / b * (other + 2.0 * UNEVEN * l) + SHAPE * w0 * r;
        let ge = by(le, lf) * e + by_d * Point2::new(f.y, -f.x);
        let gf = by(lf, le) * f + by_d * Point2::new(-e.y, e.x);
        for (v, g) in [(n, ge), (w, gf), (v, -ge - gf)] {
            if let Some(s) = gradient.get_mut(v as usize) {
                *s += g;
            }
        }
    }
    value
}
