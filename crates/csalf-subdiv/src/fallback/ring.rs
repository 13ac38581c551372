//! The inner points, their distances from the contour, and the quads.
//!
//! A cell whose even end is `e`, odd end `d` (in either order along the contour), with `t` the middle of its inner
//! edge, `x` the middle of the odd spoke and `y` the middle of (e, x, t):
//!
//! ```text
//!        o_e ──── t ──── o_d        quads (e, d, x, y), (e, y, t, o_e), (y, x, o_d, t),
//!         │       │      │          mirrored if the odd end comes first
//!         │       y ──── x
//!         │    ╱         │
//!         e ──────────── d
//! ```
//!
//! Cost: O(n) per round of halving; rounds look only at what moved in the one before.

use super::{FallbackError, corners};
use csalf_geom::{Point2, angle::rotated, predicates::is_left};
use csalf_mesh::{Contour, Patch};
use std::f64::consts::{FRAC_PI_2, PI};

/// An odd occurrence wider than this gets two spokes: three quads instead of two. Halfway between the angles at
/// which three and two quads are square, less a little because 180° corners are worse than 75° ones.
pub(super) const WEDGE_ANGLE: f64 = 1.2 * PI;
/// First distance of an inner point, as a share of the shorter segment at its node.
const FIRST_DISTANCE: f64 = 0.4;
/// A triangle keeps at least this share of its area when its corners are pulled off the contour.
const AREA_SHARE: f64 = 0.1;
/// Most rounds of halving: 2^-60 of a segment is below the floating-point grid.
const MAX_ROUNDS: usize = 400;
/// A distance below this share of the coordinates is below the floating-point grid.
const GRID: f64 = 4.0 * f64::EPSILON;

/// Fills the contour. `inner_points`: with free points inside. `flip`: with the worse choice of the odd nodes.
pub(super) fn fill(contour: &Contour, inner_points: bool, flip: bool) -> Result<Patch, FallbackError> {
    let mut ring = Ring::new(contour, inner_points, flip)?;
    ring.settle()?;
    ring.emit()
}

struct Ring<'a> {
    contour: &'a Contour,
    inner: corners::Inner,
    /// Occurrences `i` with `(i + phase) % 2 == 1` are the odd ones.
    phase: usize,
    wide: Vec<bool>,
    /// Per inner point: where it starts, where it goes, how far, its occurrence.
    base: Vec<Point2>,
    direction: Vec<Point2>,
    distance: Vec<f64>,
    owner: Vec<u32>,
}

/// True if the quad is strictly convex and counter-clockwise. Exact.
fn convex(q: [Point2; 4]) -> bool {
    (0..4).all(|k| is_left(q[k], q[(k + 1) & 3], q[(k + 2) & 3]))
}

fn mid(a: Point2, b: Point2) -> Point2 {
    0.5 * (a + b)
}

fn centre(a: Point2, b: Point2, c: Point2) -> Point2 {
    a + ((b - a) + (c - a)) / 3.0
}

/// The three quads of a triangle with the middles of its sides (`m[k]` on side k, k+1) and `c` inside.
fn tripartition<T: Copy>(v: [T; 3], m: [T; 3], c: T) -> [[T; 4]; 3] {
    [[v[0], m[0], c, m[2]], [v[1], m[1], c, m[0]], [v[2], m[2], c, m[1]]]
}

/// The three quads of a cell, see the picture. `odd_first`: d comes before e along the contour.
fn cell<T: Copy>([e, d, o_d, o_e]: [T; 4], t: T, x: T, y: T, odd_first: bool) -> [[T; 4]; 3] {
    if odd_first {
        [[d, e, y, x], [e, o_e, t, y], [y, t, o_d, x]]
    } else {
        [[e, d, x, y], [e, y, t, o_e], [y, x, o_d, t]]
    }
}

impl<'a> Ring<'a> {
    fn new(contour: &'a Contour, inner_points: bool, flip: bool) -> Result<Self, FallbackError> {
        let n = contour.len();
        let p = &contour.points;
        let angle: Vec<f64> = (0..n).map(|i| contour.angle(i)).collect();
        // The phase that brings the angles closer to two quads at odd and four at even occurrences.
        let cost = |phase: usize| -> f64 {
            let of = |i: usize| {
                let odd = (i + phase) % 2 == 1;
                let k = if !odd {
                    4.0
                } else if angle[i] > WEDGE_ANGLE {
                    3.0
                } else {
                    2.0
                };
                (angle[i] / k - FRAC_PI_2).powi(2)
            };
            (0..n).map(of).sum()
        };
        let phase = usize::from((cost(1) < cost(0)) != flip);
        let wide: Vec<bool> = (0..n).map(|i| (i + phase) % 2 == 1 && angle[i] > WEDGE_ANGLE).collect();
        let out = |i: usize| (p[(i + 1) % n] - p[i]).normalize_or_zero();
        let bisector: Vec<Point2> = (0..n).map(|i| rotated(out(i), 0.5 * angle[i])).collect();
        let inner = corners::triangulate(contour, &wide, &bisector, inner_points)?;
        let mut ring = Self {
            contour,
            phase,
            base: Vec::new(),
            direction: Vec::new(),
            distance: Vec::new(),
            owner: Vec::new(),
            wide,
            inner,
        };
        for i in 0..n {
            let short = p[i].distance(p[(i + 1) % n]).min(p[i].distance(p[(i + n - 1) % n]));
            let m = if ring.wide[i] { 2 } else { 1 };
            for k in 1..=m {
                ring.base.push(p[i]);
                ring.direction.push(if m == 1 {
                    bisector[i]
                } else {
                    rotated(out(i), angle[i] * k as f64 / 3.0)
                });
                ring.distance.push(FIRST_DISTANCE * short);
                ring.owner.push(i as u32);
            }
        }
        for k in 0..ring.inner.free.len() {
            ring.base.push(ring.inner.free[k]);
            ring.direction.push(Point2::ZERO);
            ring.distance.push(0.0);
            ring.owner.push(u32::MAX);
        }
        Ok(ring)
    }

    fn at(&self, name: u32) -> Point2 {
        let k = name as usize;
        self.base[k] + self.distance[k] * self.direction[k]
    }

    fn is_odd(&self, i: usize) -> bool {
        (i + self.phase) % 2 == 1
    }

    /// `(odd end, even end, o_d, o_e)` of cell i.
    fn cell_names(&self, i: usize) -> (usize, usize, u32, u32) {
        let j = (i + 1) % self.contour.len();
        // The cell leaves i by its point a and enters j by its point b.
        let (leave, enter) = (self.inner.first[i], self.inner.first[j] + u32::from(self.wide[j]));
        if self.is_odd(i) { (i, j, leave, enter) } else { (j, i, enter, leave) }
    }

    fn cell_fits(&self, i: usize) -> bool {
        let (d, e, o_d, o_e) = self.cell_names(i);
        let (d, e) = (self.contour.points[d], self.contour.points[e]);
        let (o_d, o_e) = (self.at(o_d), self.at(o_e));
        let (t, x) = (mid(o_d, o_e), mid(d, o_d));
        cell([e, d, o_d, o_e], t, x, centre(e, x, t), self.is_odd(i)).into_iter().all(convex)
    }

    fn triangle_fits(&self, v: [u32; 3], area: f64) -> bool {
        let p = v.map(|k| self.at(k));
        if (p[1] - p[0]).perp_dot(p[2] - p[0]) < AREA_SHARE * area {
            return false;
        }
        // Middles are computed from the smaller name to the larger, as in `emit`.
        let m = [0, 1, 2].map(|k| self.middle(v[k], v[(k + 1) % 3]));
        tripartition(p, m, centre(p[0], p[1], p[2])).into_iter().all(convex)
    }

    fn middle(&self, a: u32, b: u32) -> Point2 {
        mid(self.at(a.min(b)), self.at(a.max(b)))
    }

    fn wedge_fits(&self, i: usize) -> bool {
        let (a, b) = (self.inner.first[i], self.inner.first[i] + 1);
        let p = [self.contour.points[i], self.at(a), self.at(b)];
        let m = [mid(p[0], p[1]), self.middle(a, b), mid(p[0], p[2])];
        tripartition(p, m, centre(p[0], p[1], p[2])).into_iter().all(convex)
    }

    /// Height of an inner point over a contour segment that starts or ends at its node.
    fn height(&self, name: u32, segment: usize) -> f64 {
        let p = &self.contour.points;
        let (a, b) = (p[segment], p[(segment + 1) % p.len()]);
        let k = name as usize;
        (b - a).normalize_or_zero().perp_dot(self.direction[k]).abs() * self.distance[k]
    }

    /// Halves distances until every element passes its exact check.
    fn settle(&mut self) -> Result<(), FallbackError> {
        let n = self.contour.len();
        let mut moved = vec![true; self.base.len()];
        let mut halve: Vec<u32> = Vec::new();
        for _ in 0..MAX_ROUNDS {
            halve.clear();
            for i in 0..n {
                let (_, _, d, e) = self.cell_names(i);
                if (moved[d as usize] || moved[e as usize]) && !self.cell_fits(i) {
                    // The higher one, or both if they are about equal.
                    let (hd, he) = (self.height(d, i), self.height(e, i));
                    if hd >= 0.7 * he {
                        halve.push(d);
                    }
                    if he >= 0.7 * hd {
                        halve.push(e);
                    }
                }
                if self.wide[i] {
                    let a = self.inner.first[i];
                    if (moved[a as usize] || moved[a as usize + 1]) && !self.wedge_fits(i) {
                        halve.extend([a, a + 1]);
                    }
                }
            }
            for (k, &v) in self.inner.triangles.iter().enumerate() {
                if v.iter().any(|&c| moved[c as usize]) && !self.triangle_fits(v, self.inner.area[k]) {
                    let far = v.map(|c| self.distance[c as usize]);
                    let most = far[0].max(far[1]).max(far[2]);
                    halve.extend((0..3).filter(|&c| far[c] > 0.0 && far[c] >= 0.5 * most).map(|c| v[c]));
                    if most == 0.0 {
                        return Err(FallbackError::NoRoom { at: 0 });
                    }
                }
            }
            if halve.is_empty() {
                return Ok(());
            }
            // The two points of a wide occurrence keep one distance: their edge keeps its direction.
            for k in 0..halve.len() {
                let i = self.owner[halve[k] as usize] as usize;
                if i < n && self.wide[i] {
                    halve.extend([self.inner.first[i], self.inner.first[i] + 1]);
                }
            }
            halve.sort_unstable();
            halve.dedup();
            moved.fill(false);
            for &k in &halve {
                let k = k as usize;
                self.distance[k] *= 0.5;
                moved[k] = true;
                if self.distance[k] < GRID * self.base[k].abs().max_element() || self.distance[k] == 0.0 {
                    return Err(FallbackError::NoRoom { at: self.owner[k] as usize });
                }
            }
        }
        Err(FallbackError::NoRoom { at: 0 })
    }

    /// Writes the quads, and checks each of them on its final points.
    fn emit(&self) -> Result<Patch, FallbackError> {
        let n = self.contour.len();
        let n32 = n as u32;
        let n_inner = self.base.len() as u32;
        let mut patch =
            Patch { points: (0..n_inner).map(|k| self.at(k)).collect(), n_fallbacks: 1, ..Patch::default() };
        let add = |points: &mut Vec<Point2>, p: Point2| {
            points.push(p);
            n32 + points.len() as u32 - 1
        };
        // One middle per inner edge: triangle sides in sorted order.
        let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * self.inner.triangles.len());
        for (t, v) in self.inner.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (v[k], v[(k + 1) % 3]);
                sides.push((a.min(b), a.max(b), (3 * t + k) as u32));
            }
        }
        sides.sort_unstable();
        let mut middle = vec![0u32; sides.len()];
        let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(sides.len());
        for &(a, b, at) in &sides {
            match edges.last() {
                Some(l) if (l.0, l.1) == (a, b) => {}
                _ => edges.push((a, b, add(&mut patch.points, self.middle(a, b)))),
            }
            middle[at as usize] = edges[edges.len() - 1].2;
        }
        let middle_of = |a: u32, b: u32| {
            let key = (a.min(b), a.max(b));
            edges.binary_search_by_key(&key, |e| (e.0, e.1)).map(|k| edges[k].2)
        };
        for (t, &v) in self.inner.triangles.iter().enumerate() {
            let p = v.map(|k| self.at(k));
            let c = add(&mut patch.points, centre(p[0], p[1], p[2]));
            let m = [middle[3 * t], middle[3 * t + 1], middle[3 * t + 2]];
            patch.quads.extend(tripartition(v.map(|k| n32 + k), m, c));
        }
        // Middles of the odd spokes, per inner point.
        let mut spoke = vec![0u32; n_inner as usize];
        for i in (0..n).filter(|&i| self.is_odd(i)) {
            for k in self.inner.first[i]..self.inner.first[i + 1] {
                spoke[k as usize] = add(&mut patch.points, mid(self.contour.points[i], self.at(k)));
            }
        }
        for i in 0..n {
            let broken = |_| FallbackError::NotSimple { at: i };
            let (d, e, o_d, o_e) = self.cell_names(i);
            let t = middle_of(o_d, o_e).map_err(broken)?;
            let x = spoke[o_d as usize];
            let [pt, px] = [t, x].map(|k| patch.points[(k - n32) as usize]);
            let y = add(&mut patch.points, centre(self.contour.points[e], px, pt));
            patch.quads.extend(cell([e as u32, d as u32, n32 + o_d, n32 + o_e], t, x, y, self.is_odd(i)));
            if self.wide[i] {
                let (a, b) = (self.inner.first[i], self.inner.first[i] + 1);
                let t = middle_of(a, b).map_err(broken)?;
                let c = add(&mut patch.points, centre(self.contour.points[i], self.at(a), self.at(b)));
                let m = [spoke[a as usize], t, spoke[b as usize]];
                patch.quads.extend(tripartition([i as u32, n32 + a, n32 + b], m, c));
            }
        }
        let fails = |q: &&[u32; 4]| !convex(q.map(|k| patch.point(self.contour, k)));
        match patch.quads.iter().find(fails) {
            Some(q) => {
                let at = q.iter().find(|&&k| k < n32).map_or(0, |&k| k as usize);
                Err(FallbackError::NoRoom { at })
            }
            None => Ok(patch),
        }
    }
}
