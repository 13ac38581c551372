//! A sparse symmetric solver: L D Lᵀ by rows, in an order of nested dissection by position.
//!
//! ```text
//!    left │s│ right      vertices are divided by the median of their widest extent; those of the left half that
//!         │s│            touch the right one are the separator, numbered last; again in both halves
//! ```
//!
//! Of facets that span the whole extent, such as those of a bore, all would be separator: another axis is taken then, and
//! where the surface lies over itself in all of them, the distance along its edges from a far end.
//!
//! 1. [`Order::new`]: nested dissection.
//! 2. Elimination tree and column counts.
//! 3. Row k of L by a sparse triangular solve over the tree (the up-looking method; Davis, *Direct Methods
//!    for Sparse Linear Systems*, 2006, ch. 4).
//!
//! Written here and not taken from a library: see docs/decisions/0003. Same bits on every machine.

use glam::DVec3;

const NONE: u32 = u32::MAX;
/// Vertices of a part that is not divided any more. Any value from 4 to 64 costs about the same.
const LEAF: usize = 12;

/// A separator of more vertices than this many times the root of all is a poor one.
const POOR: f64 = 2.0;

/// An elimination order: position of each vertex.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    /// Position per vertex.
    pub(crate) rank: Vec<u32>,
}

impl Order {
    /// Orders the vertices of triangles by their position. Cost O(n log² n).
    pub(crate) fn new(points: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let n = points.len();
        let mut start = vec![0u32; n + 1];
        for t in triangles {
            t.iter().for_each(|&v| start[v as usize + 1] += 2);
        }
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut fill = start.clone();
        let mut near = vec![0u32; start[n] as usize];
        for t in triangles {
            for k in 0..3 {
                let f = &mut fill[t[k] as usize];
                near[*f as usize] = t[(k + 1) % 3];
                near[*f as usize + 1] = t[(k + 2) % 3];
                *f += 2;
            }
        }
        let graph = Graph { points, start, near };
        let mut out = Vec::with_capacity(n);
        let mut side = vec![0u32; n];
        let mut stamp = 0;
        graph.dissect((0..n as u32).collect(), &mut side, &mut stamp, &mut out);
        let mut rank = vec![0; n];
        for (i, &v) in out.iter().enumerate() {
            rank[v as usize] = i as u32;
        }
        Self { rank }
    }
}

struct Graph<'a> {
    points: &'a [DVec3],
    start: Vec<u32>,
    near: Vec<u32>,
}

impl Graph<'_> {
    fn dissect(&self, mut ids: Vec<u32>, side: &mut [u32], stamp: &mut u32, out: &mut Vec<u32>) {
        if ids.len() <= LEAF {
            out.append(&mut ids);
            return;
        }
        let p = |v: u32| self.points[v as usize];
        let (lo, hi) = ids
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &v| (lo.min(p(v)), hi.max(p(v))));
        let d = hi - lo;
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| d[b].total_cmp(&d[a]).then(a.cmp(&b)));
        let good = POOR * (ids.len() as f64).sqrt();
        let mut best: Option<[Vec<u32>; 3]> = None;
        for way in 0..4 {
            let parts = match axes.get(way) {
                Some(&axis) => self.divide(&mut ids, &|v| self.points[v as usize][axis], side, stamp),
                None => {
                    let depth = self.depths(&ids, side, stamp);
                    self.divide(&mut ids, &|v| f64::from(depth[v as usize]), side, stamp)
                }
            };
            let n = parts[1].len();
            if best.as_ref().is_none_or(|b| n < b[1].len()) {
                best = Some(parts);
            }
            if n as f64 <= good {
                break;
            }
        }
        let Some([left, separator, right]) = best else { return };
        self.dissect(left, side, stamp, out);
        self.dissect(right, side, stamp, out);
        out.extend(separator);
    }

    /// Steps from a vertex at the far end of the part to each vertex of it, other parts of the graph being out of bounds;
    /// what cannot be reached is farthest.
    fn depths(&self, ids: &[u32], side: &mut [u32], stamp: &mut u32) -> Vec<u32> {
        let mut depth = vec![u32::MAX; self.points.len()];
        let mut from = ids[0];
        // The end of one search is a far end, where the next begins.
        for _ in 0..2 {
            *stamp += 1;
            let open = *stamp;
            ids.iter().for_each(|&v| side[v as usize] = open);
            *stamp += 1;
            let mut queue = vec![from];
            (side[from as usize], depth[from as usize]) = (*stamp, 0);
            let mut at = 0;
            while let Some(&v) = queue.get(at) {
                at += 1;
                let (a, b) = (self.start[v as usize] as usize, self.start[v as usize + 1] as usize);
                for &w in &self.near[a..b] {
                    if side[w as usize] == open {
                        (side[w as usize], depth[w as usize]) = (*stamp, depth[v as usize] + 1);
                        queue.push(w);
                    }
                }
            }
            from = queue[queue.len() - 1];
        }
        depth
    }

    /// Left part, separator and right part by the median of a key.
    fn divide(
        &self,
        ids: &mut [u32],
        key: &dyn Fn(u32) -> f64,
        side: &mut [u32],
        stamp: &mut u32,
    ) -> [Vec<u32>; 3] {
        let half = ids.len() / 2;
        ids.select_nth_unstable_by(half, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
        *stamp += 1;
        let mark = *stamp;
        ids[half..].iter().for_each(|&v| side[v as usize] = mark);
        let touches = |v: u32| {
            let (a, b) = (self.start[v as usize] as usize, self.start[v as usize + 1] as usize);
            self.near[a..b].iter().any(|&w| side[w as usize] == mark)
        };
        let (separator, left): (Vec<u32>, Vec<u32>) = ids[..half].iter().partition(|&&v| touches(v));
        [left, separator, ids[half..].to_vec()]
    }
}

/// A symmetric matrix by its upper triangle: columns of (row <= column, value), duplicates adding up.
#[derive(Clone, Debug, Default)]
pub(crate) struct Symmetric {
    entries: Vec<(u32, u32, f64)>,
    n: usize,
}

/// Pivots below this share of the largest diagonal entry mean a singular matrix.
const SINGULAR: f64 = 1e-13;

/// Most operations of a factorisation, a second or two. Measured: 1.4e8 for the 22,000 unknowns of a machined part, 8e10
/// and more for heaps of needles (`fuzz-models`, seed 2026).
const MOST_WORK: f64 = 1.5e9;

impl Symmetric {
    pub(crate) fn new(n: usize) -> Self {
        Self { entries: Vec::new(), n }
    }

    /// Adds `x` at (i, j) and (j, i).
    #[inline]
    pub(crate) fn add(&mut self, i: u32, j: u32, x: f64) {
        self.entries.push((i.min(j), i.max(j), x));
    }

    /// L D Lᵀ; `None` unless the matrix is positive definite beyond rounding, and if it takes more than [`MOST_WORK`].
    pub(crate) fn factor(&self) -> Option<Factor> {
        let n = self.n;
        let mut start = vec![0usize; n + 1];
        self.entries.iter().for_each(|e| start[e.1 as usize + 1] += 1);
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut fill = start.clone();
        let mut row = vec![0u32; self.entries.len()];
        let mut value = vec![0f64; self.entries.len()];
        for &(i, j, x) in &self.entries {
            let f = &mut fill[j as usize];
            (row[*f], value[*f]) = (i, x);
            *f += 1;
        }
        let mut parent = vec![NONE; n];
        let mut flag = vec![NONE; n];
        let mut count = vec![0usize; n + 1];
        for k in 0..n {
            flag[k] = k as u32;
            for &i in &row[start[k]..start[k + 1]] {
                let mut i = i as usize;
                while flag[i] != k as u32 {
                    if parent[i] == NONE {
                        parent[i] = k as u32;
                    }
                    count[i + 1] += 1;
                    flag[i] = k as u32;
                    i = parent[i] as usize;
                }
            }
        }
        if count.iter().map(|&c| (c as f64).powi(2)).sum::<f64>() > MOST_WORK {
            return None;
        }
        for i in 0..n {
            count[i + 1] += count[i];
        }
        let first = count;
        let mut end = first.clone();
        let (mut lrow, mut lvalue) = (vec![0u32; first[n]], vec![0f64; first[n]]);
        let mut d = vec![0f64; n];
        let mut y = vec![0f64; n];
        let (mut stack, mut path) = (vec![0u32; n], Vec::new());
        flag.iter_mut().for_each(|f| *f = NONE);
        for k in 0..n {
            let mut top = n;
            flag[k] = k as u32;
            let mut largest = 0f64;
            for e in start[k]..start[k + 1] {
                let mut i = row[e];
                y[i as usize] += value[e];
                if i as usize == k {
                    largest = largest.max(value[e].abs());
                }
                path.clear();
                while flag[i as usize] != k as u32 {
                    path.push(i);
                    flag[i as usize] = k as u32;
                    i = parent[i as usize];
                }
                while let Some(i) = path.pop() {
                    top -= 1;
                    stack[top] = i;
                }
            }
            let mut dk = std::mem::take(&mut y[k]);
            for &i in &stack[top..] {
                let i = i as usize;
                let yi = std::mem::take(&mut y[i]);
                for p in first[i]..end[i] {
                    y[lrow[p] as usize] -= lvalue[p] * yi;
                }
                let l = yi / d[i];
                dk -= l * yi;
                (lrow[end[i]], lvalue[end[i]]) = (k as u32, l);
                end[i] += 1;
            }
            if !dk.is_finite() || dk <= SINGULAR * largest {
                return None;
            }
            d[k] = dk;
        }
        Some(Factor { first, row: lrow, value: lvalue, d })
    }
}

/// A factored matrix.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    first: Vec<usize>,
    row: Vec<u32>,
    value: Vec<f64>,
    d: Vec<f64>,
}

impl Factor {
    /// Solves in place.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        let n = self.d.len();
        for i in 0..n {
            let xi = x[i];
            for p in self.first[i]..self.first[i + 1] {
                x[self.row[p] as usize] -= self.value[p] * xi;
            }
        }
        x.iter_mut().zip(&self.d).for_each(|(x, d)| *x /= d);
        for i in (0..n).rev() {
            let mut xi = x[i];
            for p in self.first[i]..self.first[i + 1] {
                xi -= self.value[p] * x[self.row[p] as usize];
            }
            x[i] = xi;
        }
    }
}
