//! A size field that is linear on the triangles of a background mesh (the paper's eqs. 18 and 19).
//!
//! ```text
//!    query p ──▶ hint ──walk──▶ owner ──▶ h = N0 h0 + N1 h1 + N2 h2     p on a side:   linear along it
//!                 │ far away                                            p on a node:   its value
//!                 ▼                                                     p outside:     value at the nearest
//!               cell of a grid ──walk──▶ owner                                         boundary point
//!                 │ too dense there
//!                 ▼
//!               rstar: nearest centroid ──walk──▶ owner
//! ```
//!
//! 1. The whole convex hull is triangulated, holes and notches too, so that a walk is never blocked by a hole and
//!    its end proves where the point lies. Triangles inside the domain come first.
//! 2. [`Background::locate`] walks over neighbours by exact predicates. Where it starts changes its path, not its
//!    end: a point strictly inside a triangle has one owner, and points on sides and nodes are evaluated from the
//!    side or node alone. So a query gives the same bits whatever the hint was.
//! 3. A grid holds the owner of the centre of each cell, where walks start; an R-tree of centroids (rstar) hashes
//!    the triangles where the grid is too coarse for them.
//! 4. Points outside take the value of the nearest boundary point, found by an R-tree of the boundary sides.
//!
//! Cost of a query: a few steps of a walk, each about 5 ns. Memory: 72 bytes per triangle, 24 per node, 4 per cell,
//! and the trees when used.

use crate::triangulate::NONE;
use crate::{Hint, SizeField};
use csalf_geom::{Point2, predicates::orient2d};
use rstar::RTree;
use rstar::primitives::{GeomWithData, Line};
use std::sync::OnceLock;

mod assemble;

/// Steps that a walk from the hint may take before the grid is asked. More: long walks where a query jumps;
/// fewer: needless grid starts. Measured best between 8 and 32.
const HINT_STEPS: usize = 16;
/// Grid cells between a hint and a point, beyond which the hint is stale. A walk through as many cells costs more
/// than a look into the grid (measured: 10 times more at 100 cells, because every step misses the cache).
const NEAR_CELLS: f64 = 6.0;
/// Steps that a walk from the grid's start may take before the R-tree is asked.
const GRID_STEPS: usize = 48;

#[derive(Clone, Copy, Debug)]
struct Node {
    /// Position times `scale`.
    p: Point2,
    h: f64,
}

/// With its own copy of the corners' places, so that a step of a walk looks at one place in memory.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    p: [Point2; 3],
    corners: [u32; 3],
    across: [u32; 3],
}

/// A centroid, relative to the box of the nodes, and its triangle.
type Centroid = GeomWithData<[f32; 2], u32>;
/// A side of the domain's boundary (scaled) and its two nodes.
type RimSide = GeomWithData<Line<[f64; 2]>, [u32; 2]>;

/// Where a point lies.
enum Place {
    /// In the closed triangle, with the (exact signs, approximate values) of the three corner areas.
    In(u32, [f64; 3]),
    /// Outside the convex hull.
    OffHull,
}

/// Linear interpolation on a triangulation. See the [module](self) for the rules.
pub struct Background {
    nodes: Vec<Node>,
    /// Triangles of the hull; the first `n_inside` are those of the domain.
    triangles: Vec<Triangle>,
    n_inside: u32,
    /// Power of two that the points are multiplied by.
    scale: f64,
    /// Box of the (scaled) nodes.
    low: Point2,
    high: Point2,
    range: (f64, f64),
    /// Per cell a triangle near its centre, to start walks from: no result depends on it. Made when it is first asked.
    cells: OnceLock<Vec<u32>>,
    columns: u32,
    rows: u32,
    /// Cells per (scaled) unit length.
    per_unit: Point2,
    centroids: OnceLock<RTree<Centroid>>,
    rim: OnceLock<RTree<RimSide>>,
}

impl std::fmt::Debug for Background {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Background")
            .field("n_nodes", &self.nodes.len())
            .field("n_triangles", &self.n_inside)
            .field("range", &self.range)
            .finish_non_exhaustive()
    }
}

impl Background {
    /// The same mesh with other values, one per node, which must be sizes.
    pub(crate) fn with_values(mut self, values: &[f64]) -> Self {
        debug_assert!(values.len() == self.nodes.len() && values.iter().all(|h| *h > 0.0), "not sizes");
        for (n, &h) in self.nodes.iter_mut().zip(values) {
            n.h = h;
        }
        self.settle();
        self
    }

    /// Number of triangles in the domain.
    pub fn n_triangles(&self) -> usize {
        self.n_inside as usize
    }

    /// Distinct nodes, in model units, in order of their first occurrence.
    pub fn points(&self) -> impl Iterator<Item = Point2> + '_ {
        self.nodes.iter().map(|n| n.p / self.scale)
    }

    /// Value per node, in model units.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.nodes.iter().map(|n| n.h)
    }

    /// Corners of the triangles in the domain, counter-clockwise, as indices of [`Self::points`].
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.triangles[..self.n_inside as usize].iter().map(|t| t.corners)
    }

    /// The owner of a scaled point in the box of the nodes. Pure but for points on sides and nodes, where any of
    /// the triangles that meet there may be named.
    fn locate(&self, p: Point2, start: u32) -> (u32, Place) {
        if (start as usize) < self.triangles.len()
            && self.is_near(start, p)
            && let Some(found) = self.walk(start, p, HINT_STEPS)
        {
            return found;
        }
        if let Some(found) = self.walk(self.cells()[self.cell(p)], p, GRID_STEPS) {
            return found;
        }
        self.locate_by_tree(p)
    }

    #[cold]
    fn locate_by_tree(&self, p: Point2) -> (u32, Place) {
        let first = self.centroids().nearest_neighbor(self.unit(p)).map_or(0, |c| c.data);
        self.walk(first, p, GRID_STEPS).unwrap_or_else(|| self.search(first, p))
    }

    /// A corner of the triangle is at most [`NEAR_CELLS`] cells away. Of a needle it may not be, though the point is
    /// near: then the grid is as good.
    #[inline]
    fn is_near(&self, t: u32, p: Point2) -> bool {
        let corner = self.triangles[t as usize].p[0];
        ((p - corner) * self.per_unit).abs().max_element() <= NEAR_CELLS
    }

    /// Visibility walk from triangle `t`: across the side that sees the point with the largest area. `None` after
    /// `steps` steps (in a constrained triangulation such a walk may run in circles).
    #[inline]
    fn walk(&self, mut t: u32, p: Point2, steps: usize) -> Option<(u32, Place)> {
        // No triangle, nor the other side of the hull.
        let mut from = NONE - 1;
        for _ in 0..=steps {
            let tri = &self.triangles[t as usize];
            let [a, b, c] = tri.p;
            // The side that the walk came through does not see the point.
            let o = [
                if tri.across[0] == from { 0.0 } else { orient2d(b, c, p) },
                if tri.across[1] == from { 0.0 } else { orient2d(c, a, p) },
                if tri.across[2] == from { 0.0 } else { orient2d(a, b, p) },
            ];
            let k = if o[0] <= o[1] {
                if o[0] <= o[2] { 0 } else { 2 }
            } else if o[1] <= o[2] {
                1
            } else {
                2
            };
            if o[k] >= 0.0 {
                return Some((t, Place::In(t, self.areas(t, p))));
            }
            match tri.across[k] {
                NONE => return Some((t, Place::OffHull)),
                next => (from, t) = (t, next),
            }
        }
        None
    }

    /// Stochastic walk, then a scan of all triangles: always finds the point. The random numbers are a fixed
    /// sequence. Source: O. Devillers, S. Pion, M. Teillaud, *Walking in a triangulation*, SoCG 2001.
    #[cold]
    fn search(&self, mut t: u32, p: Point2) -> (u32, Place) {
        let mut seed = 0x2545_f491u32;
        for _ in 0..4 * self.triangles.len() + 64 {
            let o = self.areas(t, p);
            seed ^= seed << 13;
            seed ^= seed >> 17;
            seed ^= seed << 5;
            let turn = (seed >> 8) as usize % 3;
            let Some(k) = (0..3).map(|k| (k + turn) % 3).find(|&k| o[k] < 0.0) else {
                return (t, Place::In(t, o));
            };
            match self.triangles[t as usize].across[k] {
                NONE => return (t, Place::OffHull),
                next => t = next,
            }
        }
        let all = 0..self.triangles.len() as u32;
        all.map(|t| (t, self.areas(t, p)))
            .find(|(_, o)| o.iter().all(|&o| o >= 0.0))
            .map_or((t, Place::OffHull), |(t, o)| (t, Place::In(t, o)))
    }

    /// Twice the areas that `p` spans with the sides opposite to the corners; exact signs.
    #[inline]
    fn areas(&self, t: u32, p: Point2) -> [f64; 3] {
        let [a, b, c] = self.triangles[t as usize].p;
        [orient2d(b, c, p), orient2d(c, a, p), orient2d(a, b, p)]
    }

    /// The value at `p`, which lies in the closed triangle `t` with these areas. On a side or a node only what
    /// belongs to it is used, so that all triangles that meet there give the same bits.
    #[inline]
    fn value(&self, t: u32, o: [f64; 3], p: Point2) -> f64 {
        let tri = &self.triangles[t as usize];
        let [a, b, c] = tri.corners.map(|v| self.nodes[v as usize].h);
        if o[0] > 0.0 && o[1] > 0.0 && o[2] > 0.0 {
            if t >= self.n_inside {
                return self.outside(p);
            }
            let h = (o[0] * a + o[1] * b + o[2] * c) / (o[0] + o[1] + o[2]);
            return h.clamp(a.min(b).min(c), a.max(b).max(c));
        }
        match [o[0] > 0.0, o[1] > 0.0, o[2] > 0.0] {
            [true, false, false] => return a,
            [false, true, false] => return b,
            [false, false, true] => return c,
            _ => {}
        }
        let k = if o[0] <= 0.0 {
            0
        } else if o[1] <= 0.0 {
            1
        } else {
            2
        };
        if t < self.n_inside || tri.across[k] < self.n_inside {
            self.on_side(tri.corners[(k + 1) % 3], tri.corners[(k + 2) % 3], p)
        } else {
            self.outside(p)
        }
    }

    /// Linear along the side `ab` at the foot of `p`; the same bits for `ba`.
    #[inline]
    fn on_side(&self, a: u32, b: u32, p: Point2) -> f64 {
        let (a, b) = (self.nodes[a.min(b) as usize], self.nodes[a.max(b) as usize]);
        let d = b.p - a.p;
        // Distinct scaled nodes are far enough apart (1e-58) that the square is not 0.
        let t = ((p - a.p).dot(d) / d.length_squared()).clamp(0.0, 1.0);
        (a.h + t * (b.h - a.h)).clamp(a.h.min(b.h), a.h.max(b.h))
    }

    /// The value at the boundary point nearest to `p`.
    #[cold]
    fn outside(&self, p: Point2) -> f64 {
        match self.rim().nearest_neighbor([p.x, p.y]) {
            Some(side) => self.on_side(side.data[0], side.data[1], p),
            None => self.range.0,
        }
    }

    fn centroids(&self) -> &RTree<Centroid> {
        self.centroids.get_or_init(|| {
            let list = self.triangles.iter().enumerate().map(|(t, tri)| {
                let [a, b, c] = tri.p;
                GeomWithData::new(self.unit((a + b + c) / 3.0), t as u32)
            });
            RTree::bulk_load(list.collect())
        })
    }

    /// Sides of the domain's triangles that have no neighbour in the domain.
    fn rim(&self) -> &RTree<RimSide> {
        self.rim.get_or_init(|| {
            let mut list = Vec::new();
            for tri in &self.triangles[..self.n_inside as usize] {
                for k in (0..3).filter(|&k| tri.across[k] >= self.n_inside) {
                    let [a, b] = [tri.corners[(k + 1) % 3], tri.corners[(k + 2) % 3]];
                    let xy = |v: u32| self.nodes[v as usize].p.to_array();
                    list.push(GeomWithData::new(Line::new(xy(a), xy(b)), [a, b]));
                }
            }
            RTree::bulk_load(list)
        })
    }

    /// A scaled point relative to the box, in single precision: good enough to start a walk from.
    #[inline]
    fn unit(&self, p: Point2) -> [f32; 2] {
        let u = (p - self.low) / (self.high - self.low).max_element();
        [u.x as f32, u.y as f32]
    }

    /// The grid cell of a scaled point in the box.
    #[inline]
    fn cell(&self, p: Point2) -> usize {
        let u = (p - self.low) * self.per_unit;
        let (i, j) = ((u.x as u32).min(self.columns - 1), (u.y as u32).min(self.rows - 1));
        j as usize * self.columns as usize + i as usize
    }
}

impl SizeField for Background {
    fn h(&self, p: Point2, hint: &mut Hint) -> f64 {
        if !p.is_finite() {
            return self.range.0;
        }
        let p = p * self.scale;
        if p.cmplt(self.low).any() || p.cmpgt(self.high).any() {
            // Beyond two boxes the direction is what matters; this also keeps the squares finite.
            let size = 2.0 * (self.high - self.low);
            return self.outside(p.clamp(self.low - size, self.high + size));
        }
        // Hint 0 is a new one; k + 1 stands for triangle k.
        let (t, place) = self.locate(p, hint.owner.wrapping_sub(1));
        hint.owner = t.wrapping_add(1);
        match place {
            Place::In(t, o) => self.value(t, o, p),
            Place::OffHull => self.outside(p),
        }
    }

    fn range(&self) -> (f64, f64) {
        self.range
    }
}

#[cfg(test)]
mod tests;
