//! Lifting the worst corners: the last word where corners are still poor, by their angles alone.
//!
//! ```text
//!   poor quads + rings, rim fixed ──▶ minimise  Σ (s0 / s)^p + Σ (s0 / u)^p + µ Σ s0 t / 2D   p = 4, 8, 16
//!                                            │                                ──▶ worst corner better: kept
//!        ●───●        s: sine of a corner, s0: the smallest; t, D as in `energy`
//!       ╱     ╲  l2   u = 1 / sqrt(κ (l1²/l2² + l2²/l1²)) of two opposite sides:
//!      ●───────● l1       below 1 if one is less than a thirtieth of the other
//! ```
//!
//! 1. Seeds: quads with a poor corner of which at least one of the three vertices is free; no other can be helped. And those
//!    with a side that has nearly vanished.
//! 2. Free vertices within some rings around, in parts that share no quad.
//! 3. Per part L-BFGS on the sum, for growing p: the largest terms are those of the worst corners. Where a corner is not
//!    positive the sum is infinite, so that a step there is never taken.
//! 4. The positions with the largest smallest sine are written back; or, where a side had nearly vanished, those where it
//!    is longest and no sine is poorer than before or than is enough.
//!
//! Shape and size energies weigh long thin quads as much as sharp corners; beside given nodes of very different distances
//! thin quads cannot be helped, corners can. But by sines alone a side may vanish, and the quad become a triangle, while
//! all corners look well: the second sum keeps sides from it, and µ draws on the others a little. (Sides at one corner
//! are not compared: in a narrow gap they have to differ, and slanting them would be no better.)

use super::region::{Region, Scratch, components, grow};
use super::{lbfgs, quads_where};
use csalf_geom::{Point2, VertexId};
use csalf_mesh::{QuadMesh, QuadTopology};
use rayon::prelude::*;

/// Times that the power is doubled, one after the other: p is 4, 8, 16. The larger, the nearer to the smallest sine.
/// Starting with the last ends in worse minima.
pub(crate) const DOUBLINGS: [u32; 3] = [1, 2, 3];

/// Share of the shape. Larger: shorter quads, worse corners; 0: edges vanish. *Arbitrary.*
const SHAPE: f64 = 1e-3;

/// κ: opposite sides of 1 to κ^(-1/2) have a u of 1. Larger: fewer very short sides, smaller sines. Of 198 jobs with sizes of
/// up to 1:1000, quads with a side below 1/1000 of the longest: 157 without the second sum, 28 at 1e-3; sines alike.
const UNEVEN: f64 = 1e-3;
/// Above this u does not matter. (1 to 126.)
const EVEN: f64 = 0.25;
/// So much longer is worth a smaller sine, if that is at least enough.
const OPENED: f64 = 1.5;
/// See [`OPENED`].
const ENOUGH: f64 = 0.4;

/// Most L-BFGS iterations per power, for the mesh itself and for a trial.
const ITERATIONS: usize = 80;
/// See [`ITERATIONS`].
pub(crate) const TRIAL_ITERATIONS: usize = 30;
/// The relative decrease at which L-BFGS ends.
const STOP: f64 = 1e-4;

/// Lifts the corners whose sine is at most `threshold`, moving free vertices within `rings` around them. Boundary vertices
/// and those of `fixed` stay. The smallest scaled Jacobian of a part falls only where a side that had nearly
/// vanished is opened, and then not below 0.4. Returns how many parts were made better.
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
        let p = vs.map(|v| mesh.points[v.index()]);
        let corner = |k: usize| {
            let at = [k, (k + 1) & 3, (k + 3) & 3];
            sine(p[k], p[at[1]], p[at[2]]) <= threshold && !at.into_iter().all(|k| stays(vs[k]))
        };
        (0..4).any(corner) || (tapers(&p).into_iter().any(|u| u <= EVEN) && !vs.iter().all(|&v| stays(v)))
    };
    let seeds = quads_where(mesh, is_poor);
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

/// The sine of the corner at `p` between the edges to `n` and `b`; -1 if one has no length.
fn sine(p: Point2, n: Point2, b: Point2) -> f64 {
    let (u, v) = (n - p, b - p);
    let l = (u.length_squared() * v.length_squared()).sqrt();
    if l > 0.0 { u.perp_dot(v) / l } else { -1.0 }
}

/// u of two opposite sides; 0 if one has no length.
fn taper([a, b]: [Point2; 2], [c, d]: [Point2; 2]) -> f64 {
    let r = a.distance_squared(b) / c.distance_squared(d);
    let uneven = UNEVEN * (r + r.recip());
    if uneven.is_finite() { uneven.sqrt().recip() } else { 0.0 }
}

/// u of the two pairs of opposite sides of a quad: 0 and 2, 1 and 3.
fn tapers(p: &[Point2; 4]) -> [f64; 2] {
    [0, 1].map(|k| taper([p[k], p[k + 1]], [p[k + 2], p[(k + 3) & 3]]))
}

/// What a quad is worth: the least of the sines of its corners and of its pairs of sides.
pub(crate) fn worth(p: &[Point2; 4]) -> f64 {
    tapers(p).into_iter().fold(least_sine(p), f64::min)
}

/// The smallest sine of the corners of a quad.
pub(crate) fn least_sine(p: &[Point2; 4]) -> f64 {
    (0..4).map(|k| sine(p[k], p[(k + 1) & 3], p[(k + 3) & 3])).fold(1.0, f64::min)
}

/// Lifts one part; false if that did not succeed.
fn solve(part: &mut Region, doublings: &[u32], iterations: usize) -> bool {
    let terms = Terms::new(part);
    let (start, sides) = terms.worst(part, &part.points[..part.n_free]);
    if start <= 0.0 {
        return false;
    }
    let mut x = part.points[..part.n_free].to_vec();
    let (mut best, mut at_best, mut s0) = ((start, sides), None, start);
    let length = (part.quads.len() as f64).recip()
        * part
            .quads
            .iter()
            .map(|q| part.points[q[0] as usize].distance(part.points[q[2] as usize]))
            .sum::<f64>();
    for &doublings in doublings {
        lbfgs::minimise(&mut x, iterations, 0.1 * length * s0, STOP, |x, g| {
            terms.energy(part, x, s0, doublings, g)
        });
        let (now, sides_now) = terms.worst(part, &x);
        let opened = sides < EVEN && sides_now > OPENED * best.1 && now >= start.min(ENOUGH);
        if (now > best.0 && sides_now >= best.1.min(EVEN)) || opened {
            (best, at_best) = ((now, sides_now), Some(x.clone()));
        }
        s0 = now;
    }
    let Some(x) = at_best else { return false };
    part.points[..part.n_free].copy_from_slice(&x);
    true
}

/// What can be lifted in a part: that of which not all vertices stay.
struct Terms {
    /// Corner, next, previous.
    corners: Vec<[u32; 3]>,
    /// Two opposite sides.
    sides: Vec<[[u32; 2]; 2]>,
}

impl Terms {
    fn new(part: &Region) -> Self {
        let n = part.n_free as u32;
        let corners = part.quads.iter().flat_map(|q| (0..4).map(|k| [q[k], q[(k + 1) & 3], q[(k + 3) & 3]]));
        let sides =
            part.quads.iter().flat_map(|q| [0, 1].map(|k| [[q[k], q[k + 1]], [q[k + 2], q[(k + 3) & 3]]]));
        Self {
            corners: corners.filter(|c| c.iter().any(|&v| v < n)).collect(),
            sides: sides.filter(|s| s.iter().flatten().any(|&v| v < n)).collect(),
        }
    }

    /// The smallest sine, and the smallest u.
    fn worst(&self, part: &Region, x: &[Point2]) -> (f64, f64) {
        let at = |v: u32| x.get(v as usize).copied().unwrap_or_else(|| part.points[v as usize]);
        let corners = self.corners.iter().map(|c| sine(at(c[0]), at(c[1]), at(c[2])));
        let pair = |s: &[[u32; 2]; 2]| taper(s[0].map(at), s[1].map(at));
        (corners.fold(1.0, f64::min), self.sides.iter().map(pair).fold(1.0, f64::min))
    }

    /// The sum that is minimised, and its gradient; infinite if a corner is not positive or a side has no length.
    fn energy(&self, part: &Region, x: &[Point2], s0: f64, doublings: u32, gradient: &mut [Point2]) -> f64 {
        gradient.fill(Point2::ZERO);
        let at = |v: u32| x.get(v as usize).copied().unwrap_or_else(|| part.points[v as usize]);
        let mut add = |v: u32, g: Point2| {
            if let Some(s) = gradient.get_mut(v as usize) {
                *s += g;
            }
        };
        let raise = |square: f64| (0..doublings).fold(square, |square, _| square * square);
        let exponent = f64::from(2u32 << doublings);
        let mut value = 0.0;
        for &[v, n, b] in &self.corners {
            let p = at(v);
            let (e, f) = (at(n) - p, at(b) - p);
            let d = e.perp_dot(f);
            if d <= 0.0 {
                return f64::INFINITY;
            }
            let (le, lf, r) = (e.length_squared(), f.length_squared(), d.recip());
            let power = raise(s0 * s0 * le * lf * r * r);
            let shape = SHAPE * s0 * 0.5 * (le + lf) * r;
            value += power + shape;
            // By D, then by the edges.
            let m = exponent * power;
            let by_d = -(m + shape) * r;
            let by = |l: f64| m / l + SHAPE * s0 * r;
            let ge = by(le) * e + by_d * Point2::new(f.y, -f.x);
            let gf = by(lf) * f + by_d * Point2::new(-e.y, e.x);
            add(n, ge);
            add(b, gf);
            add(v, -ge - gf);
        }
        for &[[a, b], [c, d]] in &self.sides {
            let (e, f) = (at(b) - at(a), at(d) - at(c));
            let (le, lf) = (e.length_squared(), f.length_squared());
            if le <= 0.0 || lf <= 0.0 {
                return f64::INFINITY;
            }
            let r = le / lf;
            let sum = r + r.recip();
            let power = raise(s0 * s0 * UNEVEN * sum);
            value += power;
            // sum grows by 2 (r - 1/r) / le e with e, and falls by as much with f.
            let m = exponent * power / sum * (r - r.recip());
            let (ge, gf) = (m / le * e, -m / lf * f);
            add(b, ge);
            add(a, -ge);
            add(d, gf);
            add(c, -gf);
        }
        value
    }
}
