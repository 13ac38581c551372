//! Fills a ring of nodes with a subdivided pattern.
//!
//! ```text
//!   pattern (coarse)             patch (fine)
//!    o-------o                    o-+-+-+-o
//!    |       |      x = 4, 2      | | | | |      block inner nodes: transfinite interpolation
//!    |       |     ──────────▶    +-+-+-+-+      edge inner nodes: on the straight edge, spaced like h
//!    o-------o                    o-+-+-+-o      ring nodes: as given
//! ```
//!
//! 1. Pattern vertices on the boundary lie at the cumulative chord counts of the ring.
//! 2. Inner pattern vertices: weighted Tutte, weight 1 / (x h) per edge (a small dense system).
//! 3. Inner pattern edges: straight, spaced geometrically between the sizes at their ends.
//! 4. Blocks: [`crate::coons`].
//! 5. With irregular vertices, or where the blocks fold: relaxation sweeps ([`crate::relax`]).
//!
//! Source: handbook 5.5. Cost: under 40 ns per quad of one big block, checks included; 50 with a relaxed band.

use crate::coons::{Side, interpolate};
use crate::pattern::{Chords, MAX_INNER, MAX_VERTICES, Pattern};
use csalf_geom::Point2;
use csalf_sizemap::{Hint, SizeField};

/// Patches of more quads are relaxed only within [`BAND`] rows of the inner pattern edges: further away the
/// blocks are smooth as they are.
const BAND_FROM: u64 = 300;
/// Rows on each side of an inner pattern edge. More: smoother, dearer.
const BAND: u32 = 4;

/// Buffers of the filler; reused from patch to patch.
#[derive(Clone, Debug, Default)]
pub struct Filler {
    /// The ring, then the new points.
    pub points: Vec<Point2>,
    /// Quads; names below the length of the ring are ring nodes.
    pub quads: Vec<[u32; 4]>,
    sides: [Side; 4],
    edge_base: Vec<u32>,
    active: Vec<u32>,
    relaxation: crate::relax::Relaxation,
    n_ring: usize,
    /// In a coarse trial: how many real edges the edges along sides 0 and 2, 1 and 3 of each quad stand for.
    pub factor: Vec<[f64; 2]>,
}

impl Filler {
    /// Number of ring nodes of the last fill.
    pub fn n_ring(&self) -> usize {
        self.n_ring
    }

    /// Relaxes by some sweeps: all inner nodes of a small patch, those near the inner pattern edges of a
    /// big one.
    pub fn relax(&mut self, size: &dyn SizeField, sweeps: usize) {
        let n = self.n_ring;
        self.relaxation.prepare(&self.points, &self.quads, n, &self.active, size, &self.factor);
        for _ in 0..sweeps {
            self.relaxation.sweep(&mut self.points, &self.active);
        }
    }

    /// Fills the ring; its node `start` is the pattern's boundary vertex 0, and it has as many nodes as the
    /// boundary edges of the pattern have subdivisions by `x`. `real` are the subdivisions of the mesh that
    /// is forecast (`x` itself, unless this is a coarse trial): they pull the inner vertices of the
    /// pattern.
    pub fn fill(
        &mut self,
        pattern: &Pattern,
        x: &Chords,
        ring: impl Iterator<Item = Point2>,
        start: u32,
        size: &dyn SizeField,
        real: &Chords,
    ) {
        self.points.clear();
        self.quads.clear();
        self.factor.clear();
        self.points.extend(ring);
        let n = self.points.len();
        let nb = pattern.n_boundary;
        let count = |e: usize| x[pattern.chord[e] as usize];
        // Boundary vertices of the pattern.
        let mut name = [0u32; MAX_VERTICES];
        let (mut at, ring) = (0, n as u32);
        for (k, slot) in name.iter_mut().enumerate().take(nb) {
            *slot = (start + at) % ring;
            at += count(k);
        }
        self.n_ring = n;
        debug_assert_eq!(at as usize, n, "the ring fits the pattern");
        let mut xy = [Point2::ZERO; MAX_VERTICES];
        (0..nb).for_each(|k| xy[k] = self.points[name[k] as usize]);
        let mut hint = Hint::default();
        if pattern.n_vertices > nb {
            tutte(pattern, real, &mut xy, None, &mut hint);
            if size.constant().is_none() {
                tutte(pattern, real, &mut xy, Some(size), &mut hint);
            }
            for k in nb..pattern.n_vertices {
                name[k] = self.points.len() as u32;
                self.points.push(xy[k]);
            }
        }
        self.edge_base.clear();
        self.edge_base.resize(nb, 0);
        for e in nb..pattern.edges.len() {
            self.edge_base.push(self.points.len() as u32);
            let [a, b] = pattern.edges[e].map(|v| xy[v as usize]);
            space(a, b, count(e), size, &mut hint, &mut self.points);
        }
        let band = pattern.n_irregular > 0 && pattern.n_quads(x) > BAND_FROM;
        self.active.clear();
        if band {
            self.active.extend(n as u32..self.points.len() as u32);
        }
        for quad_edges in &pattern.quad_edges {
            let mut sides = std::mem::take(&mut self.sides);
            for k in 0..4 {
                let (e, back) = quad_edges[k];
                // Sides 2 and 3 are read backwards, so that bottom and top run along i, left and right
                // along j.
                let back = back != (k >= 2);
                let side = &mut sides[k];
                side.clear();
                let m = count(e as usize);
                let [va, vb] = pattern.edges[e as usize].map(|v| name[v as usize]);
                for i in 0..=m {
                    let i = if back { m - i } else { i };
                    let v = match i {
                        0 => va,
                        i if i == m => vb,
                        i if (e as usize) < nb => {
                            if va + i < ring {
                                va + i
                            } else {
                                va + i - ring
                            }
                        }
                        i => self.edge_base[e as usize] + i - 1,
                    };
                    side.names.push(v);
                    side.points.push(self.points[v as usize]);
                }
                side.measure();
            }
            let base = self.points.len() as u32;
            if band {
                let inner = quad_edges.map(|(e, _)| e as usize >= nb);
                near(
                    sides[0].names.len() as u32 - 1,
                    sides[3].names.len() as u32 - 1,
                    base,
                    inner,
                    &mut self.active,
                );
            }
            let [bot, right, top, left] = &sides;
            interpolate(bot, top, left, right, &mut self.points);
            emit(&sides, base, &mut self.quads);
            if x != real {
                let f = [0, 1].map(|k| {
                    let c = pattern.chord[quad_edges[k].0 as usize] as usize;
                    f64::from(real[c]) / f64::from(x[c])
                });
                self.factor.resize(self.quads.len(), f);
            }
            self.sides = sides;
        }
        if !band {
            self.active.extend(n as u32..self.points.len() as u32);
        }
    }
}

/// Adds the inner nodes of an a x b block within [`BAND`] rows of those of its sides that are inner pattern
/// edges.
fn near(a: u32, b: u32, base: u32, inner: [bool; 4], out: &mut Vec<u32>) {
    for j in 1..b {
        let row = base + (j - 1) * (a - 1);
        if inner[0] && j <= BAND || inner[2] && b - j <= BAND {
            out.extend(row..row + a - 1);
            continue;
        }
        let low = if inner[3] { BAND.min(a - 1) } else { 0 };
        let high = if inner[1] { (a - 1).saturating_sub(BAND).max(low) } else { a - 1 };
        out.extend((row..row + low).chain(row + high..row + a - 1));
    }
}

/// Writes the quads of one block, row by row.
fn emit(sides: &[Side; 4], base: u32, quads: &mut Vec<[u32; 4]>) {
    let [bot, right, top, left] = sides;
    let (a, b) = (bot.names.len() - 1, left.names.len() - 1);
    quads.reserve(a * b);
    let row = (a - 1) as u32;
    for j in 0..b {
        let (l0, l1) = (left.names[j], left.names[j + 1]);
        let (r0, r1) = (right.names[j], right.names[j + 1]);
        let low = base + j.saturating_sub(1) as u32 * row;
        let high = base + j as u32 * row;
        let (mut d0, mut d1) = (l0, l1);
        for i in 1..=a {
            let c0 = if j == 0 {
                bot.names[i]
            } else if i == a {
                r0
            } else {
                low + i as u32 - 1
            };
            let c1 = if j + 1 == b {
                top.names[i]
            } else if i == a {
                r1
            } else {
                high + i as u32 - 1
            };
            quads.push([d0, c0, c1, d1]);
            (d0, d1) = (c0, c1);
        }
    }
}

/// Inner nodes of a straight edge of `m` segments, in geometric progression between the sizes at its ends.
fn space(a: Point2, b: Point2, m: u32, size: &dyn SizeField, hint: &mut Hint, out: &mut Vec<Point2>) {
    if m < 2 {
        return;
    }
    let q =
        if size.constant().is_some() { 1.0 } else { (size.h(b, hint) / size.h(a, hint)).clamp(0.1, 10.0) };
    let k = 1.0 / f64::from(m);
    // With h linear along the edge, nodes are at (q^(i/m) - 1) / (q - 1).
    let even = (q - 1.0).abs() < 0.01;
    let ratio = if even { 1.0 } else { q.powf(k) };
    let mut power = 1.0;
    for i in 1..m {
        power *= ratio;
        let t = if even { f64::from(i) * k } else { (power - 1.0) / (q - 1.0) };
        out.push(a.lerp(b, t));
    }
}

/// Moves the inner vertices of the pattern to the weighted mean of their neighbours, weight 1 / (x h) per
/// edge (h = 1 without a field). Dense Gaussian elimination: the matrix is diagonally dominant, no pivoting
/// is needed.
pub fn tutte(
    pattern: &Pattern,
    x: &Chords,
    xy: &mut [Point2; MAX_VERTICES],
    size: Option<&dyn SizeField>,
    hint: &mut Hint,
) {
    const M: usize = MAX_INNER;
    let nb = pattern.n_boundary;
    let n = pattern.n_vertices - nb;
    let mut m = [[0.0f64; M]; M];
    let mut rhs = [Point2::ZERO; M];
    for (e, &[a, b]) in pattern.edges.iter().enumerate().skip(nb) {
        let (a, b) = (a as usize, b as usize);
        let h = size.map_or(1.0, |s| s.h(xy[a].midpoint(xy[b]), hint));
        let w = 1.0 / (f64::from(x[pattern.chord[e] as usize]) * h);
        for (p, q) in [(a, b), (b, a)] {
            if p < nb {
                continue;
            }
            m[p - nb][p - nb] += w;
            if q < nb {
                rhs[p - nb] += w * xy[q];
            } else {
                m[p - nb][q - nb] -= w;
            }
        }
    }
    for i in 0..n {
        let d = 1.0 / m[i][i];
        let row = m[i];
        for j in i + 1..n {
            let f = m[j][i] * d;
            if f != 0.0 {
                m[j][i..n].iter_mut().zip(&row[i..n]).for_each(|(a, b)| *a -= f * b);
                let r = rhs[i];
                rhs[j] -= r * f;
            }
        }
    }
    for i in (0..n).rev() {
        let mut s = rhs[i];
        for k in i + 1..n {
            s -= xy[nb + k] * m[i][k];
        }
        xy[nb + i] = s / m[i][i];
    }
}
