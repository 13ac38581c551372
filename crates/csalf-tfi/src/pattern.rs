//! N-sided patterns: tiny quad meshes of a disk whose **chords** are subdivided to fit the sides of a
//! contour.
//!
//! ```text
//!        4                 s1 = x1 + x2      a chord runs through opposite edges of quads; giving it x
//!       / \                s2 = x2 + x3      subdivisions makes a px * py lattice of every quad
//!      5   3               s3 = x3 + x1
//!     / \6/ \
//!    0---1---2     tri: corners 0 2 4, one 3-valent vertex (6)
//! ```
//!
//! 1. Edges of the pattern are numbered, boundary edges first; opposite edges of quads are joined to chords.
//! 2. Side i is the sum of the chords of its edges: S x = s, with every x >= 1 (handbook 5.4).
//! 3. S is reduced once per pattern to a form in which the pivots follow from s and the free chords.
//! 4. Solving enumerates (or samples, if there are too many) the free chords.

/// Most chords of a pattern.
pub const MAX_CHORDS: usize = 16;
/// Most logical sides of a pattern.
pub const MAX_SIDES: usize = 6;
/// Most vertices of a pattern.
pub const MAX_VERTICES: usize = 40;
/// Most inner vertices of a pattern.
pub const MAX_INNER: usize = 12;

/// A pattern as it stands in the table: boundary vertices `0..n_boundary` counter-clockwise from the first
/// corner, then the inner ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PatternData {
    /// Name in reports and snapshots.
    pub name: &'static str,
    /// Number of true corners (boundary vertices of one quad); 0 for the disk, whose four `sides` are
    /// virtual.
    pub n_corners: u8,
    /// Boundary vertices where the sides begin; the first is 0.
    pub sides: &'static [u8],
    /// Number of boundary vertices.
    pub n_boundary: u8,
    /// Quads, counter-clockwise.
    pub quads: &'static [[u8; 4]],
}

/// One row of the reduced system: `den * x[pivot] = by_side . s - by_free . x`.
#[derive(Clone, Debug)]
struct Row {
    pivot: usize,
    den: i64,
    by_side: [i64; MAX_SIDES],
    by_free: [i64; MAX_CHORDS],
}

/// A pattern with everything derived from its quads.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// Name in the table, with `'` appended if mirrored.
    pub name: String,
    /// True corners: 0 to 6.
    pub n_corners: usize,
    /// Boundary vertices where the sides begin.
    pub sides: Vec<u8>,
    /// Number of boundary vertices (and edges).
    pub n_boundary: usize,
    /// Number of vertices.
    pub n_vertices: usize,
    /// Quads, counter-clockwise.
    pub quads: Vec<[u8; 4]>,
    /// Edges; edge k < n_boundary runs from boundary vertex k to k + 1.
    pub edges: Vec<[u8; 2]>,
    /// Edge and direction (true: against the edge) of side k of each quad.
    pub quad_edges: Vec<[(u8, bool); 4]>,
    /// Chord of each edge.
    pub chord: Vec<u8>,
    /// Number of chords.
    pub n_chords: usize,
    /// Number of inner vertices whose valence is not 4.
    pub n_irregular: usize,
    /// True if turning it by one side gives the pattern again.
    pub symmetric: bool,
    /// How often each chord ends on each side.
    pub by_side: Vec<[u8; MAX_CHORDS]>,
    rows: Vec<Row>,
    conditions: Vec<[i64; MAX_SIDES]>,
    free: Vec<usize>,
}

/// Number of subdivisions per chord.
pub type Chords = [u32; MAX_CHORDS];

impl Pattern {
    /// Derives edges, chords and the reduced system. The data must be a valid pattern (the table is tested).
    pub fn new(data: &PatternData) -> Self {
        Self::derive(
            data.name.into(),
            data.n_corners,
            data.sides.to_vec(),
            data.n_boundary,
            data.quads.to_vec(),
        )
    }

    /// The mirror image: boundary vertex k becomes -k.
    pub fn mirrored(&self) -> Self {
        let nb = self.n_boundary as u8;
        let map = |v: u8| if v < nb { (nb - v) % nb } else { v };
        let quads = self.quads.iter().map(|q| [map(q[3]), map(q[2]), map(q[1]), map(q[0])]).collect();
        let mut sides: Vec<u8> = self.sides.iter().map(|&v| map(v)).collect();
        sides.sort_unstable();
        Self::derive(format!("{}'", self.name), self.n_corners as u8, sides, nb, quads)
    }

    fn derive(name: String, n_corners: u8, sides: Vec<u8>, n_boundary: u8, quads: Vec<[u8; 4]>) -> Self {
        let nb = n_boundary as usize;
        let n_vertices = quads.iter().flatten().map(|&v| v as usize + 1).max().unwrap_or(0);
        let mut edges: Vec<[u8; 2]> = (0..nb).map(|k| [k as u8, ((k + 1) % nb) as u8]).collect();
        let mut quad_edges = Vec::with_capacity(quads.len());
        for q in &quads {
            let mut sides = [(0u8, false); 4];
            for k in 0..4 {
                let (a, b) = (q[k], q[(k + 1) % 4]);
                sides[k] = match edges.iter().position(|e| *e == [a, b] || *e == [b, a]) {
                    Some(e) => (e as u8, edges[e] != [a, b]),
                    None => {
                        edges.push([a, b]);
                        ((edges.len() - 1) as u8, false)
                    }
                };
            }
            quad_edges.push(sides);
        }
        // Chords: the smallest edge number of each class, then renumbered.
        let mut class: Vec<usize> = (0..edges.len()).collect();
        let mut changed = true;
        while changed {
            changed = false;
            for s in &quad_edges {
                for k in 0..2 {
                    let (a, b) = (s[k].0 as usize, s[k + 2].0 as usize);
                    let m = class[a].min(class[b]);
                    changed |= class[a] != m || class[b] != m;
                    (class[a], class[b]) = (m, m);
                }
            }
        }
        let mut n_chords = 0;
        let mut number = vec![0u8; edges.len()];
        for e in 0..edges.len() {
            if class[e] == e {
                number[e] = n_chords as u8;
                n_chords += 1;
            }
        }
        let chord: Vec<u8> = class.iter().map(|&c| number[c]).collect();
        let mut by_side = Vec::new();
        for (i, &a) in sides.iter().enumerate() {
            let b = if i + 1 < sides.len() { sides[i + 1] as usize } else { nb };
            let mut row = [0u8; MAX_CHORDS];
            for e in a as usize..b {
                row[chord[e] as usize] += 1;
            }
            by_side.push(row);
        }
        let mut valence = vec![0; n_vertices];
        quads.iter().flatten().for_each(|&v| valence[v as usize] += 1);
        let n_irregular = valence[nb..].iter().filter(|&&d| d != 4).count();
        let mut out = Self {
            name,
            n_corners: n_corners as usize,
            sides,
            n_boundary: nb,
            n_vertices,
            quads,
            edges,
            quad_edges,
            chord,
            n_chords,
            n_irregular,
            symmetric: false,
            by_side,
            rows: Vec::new(),
            conditions: Vec::new(),
            free: Vec::new(),
        };
        out.reduce();
        out.symmetric = out.is_rotation_of(&out, out.sides.get(1).map_or(0, |&s| s as usize));
        out
    }

    /// True if turning this pattern by `r` boundary vertices makes `other`.
    pub fn is_rotation_of(&self, other: &Self, r: usize) -> bool {
        let nb = self.n_boundary;
        if nb != other.n_boundary
            || self.n_vertices != other.n_vertices
            || self.quads.len() != other.quads.len()
        {
            return false;
        }
        // Grow the map of vertices from the boundary inwards, quad by quad.
        let mut map = [u8::MAX; MAX_VERTICES];
        (0..nb).for_each(|v| map[v] = ((v + r) % nb) as u8);
        let mut done = vec![false; self.quads.len()];
        for _ in 0..self.quads.len() {
            for (i, q) in self.quads.iter().enumerate() {
                let known = |k: usize| map[q[k] as usize] != u8::MAX;
                let Some(k) = (0..4).find(|&k| !done[i] && known(k) && known((k + 1) % 4)) else { continue };
                let (a, b) = (map[q[k] as usize], map[q[(k + 1) % 4] as usize]);
                let twin = other.quads.iter().find_map(|o| {
                    (0..4)
                        .find(|&j| o[j] == a && o[(j + 1) % 4] == b)
                        .map(|j| [o[(j + 2) % 4], o[(j + 3) % 4]])
                });
                let Some(twin) = twin else { return false };
                for (j, t) in twin.into_iter().enumerate() {
                    let m = &mut map[q[(k + 2 + j) % 4] as usize];
                    if *m != u8::MAX && *m != t {
                        return false;
                    }
                    *m = t;
                }
                done[i] = true;
            }
        }
        done.iter().all(|&d| d)
    }

    /// Fraction-free Gauss-Jordan elimination of S, with the side lengths kept symbolic.
    fn reduce(&mut self) {
        let mut m: Vec<([i64; MAX_CHORDS], [i64; MAX_SIDES])> = (0..self.sides.len())
            .map(|i| {
                let mut unit = [0; MAX_SIDES];
                unit[i] = 1;
                (self.by_side[i].map(i64::from), unit)
            })
            .collect();
        let mut pivots = Vec::new();
        let mut r = 0;
        for c in 0..self.n_chords {
            let Some(p) = (r..m.len()).find(|&i| m[i].0[c] != 0) else { continue };
            m.swap(r, p);
            for i in 0..m.len() {
                if i != r && m[i].0[c] != 0 {
                    let (a, b) = (m[r].0[c], m[i].0[c]);
                    let pivot = m[r];
                    let row = &mut m[i];
                    (0..MAX_CHORDS).for_each(|k| row.0[k] = row.0[k] * a - pivot.0[k] * b);
                    (0..MAX_SIDES).for_each(|k| row.1[k] = row.1[k] * a - pivot.1[k] * b);
                    let g = row.0.iter().chain(&row.1).fold(0, |g, &v| gcd(g, v.abs())).max(1);
                    row.0.iter_mut().chain(&mut row.1).for_each(|v| *v /= g);
                }
            }
            pivots.push(c);
            r += 1;
        }
        self.conditions = m[r..].iter().map(|row| row.1).collect();
        self.free = (0..self.n_chords).filter(|c| !pivots.contains(c)).collect();
        self.rows = pivots
            .iter()
            .enumerate()
            .map(|(i, &pivot)| {
                let s = m[i].0[pivot].signum();
                let mut by_free = m[i].0.map(|v| v * s);
                let den = by_free[pivot];
                by_free[pivot] = 0;
                Row { pivot, den, by_side: m[i].1.map(|v| v * s), by_free }
            })
            .collect();
    }

    /// Calls `visit` with solutions of S x = s, x >= 1, side i of the pattern being `sides[i]`. Enumerates
    /// all if they are few, else a regular sample of about `most`. `closed` is the value of chords that no
    /// side sees. Cost: `most` times the number of sides and chords.
    pub fn solve(&self, sides: &[u32], closed: u32, most: usize, visit: &mut dyn FnMut(&Chords)) {
        if sides.len() != self.sides.len() {
            return;
        }
        let Some(rhs) = self.right_hand_side(sides) else { return };
        // Upper bounds and strides of the free chords.
        let mut lists = [(1u32, 1u32, 1u32); MAX_CHORDS];
        let mut total = 1usize;
        for (k, &f) in self.free.iter().enumerate() {
            let mut upper = u32::MAX;
            for (row, &s) in self.by_side.iter().zip(sides) {
                if row[f] > 0 {
                    let others: u32 = row.iter().map(|&c| u32::from(c)).sum::<u32>() - u32::from(row[f]);
                    upper = upper.min((s - others) / u32::from(row[f]));
                }
            }
            lists[k] = if upper == u32::MAX { (closed, closed, 1) } else { (1, upper, 1) };
            total = total.saturating_mul((lists[k].1 - lists[k].0 + 1) as usize);
        }
        let nf = self.free.len();
        if total > most {
            let each = (most as f64).powf(1.0 / nf as f64).max(2.0);
            for l in &mut lists[..nf] {
                // Odd strides, so that both parities are visited.
                l.2 = ((f64::from(l.1 - l.0 + 1) / each).ceil() as u32).max(1) | 1;
                l.0 = (l.0 + l.2 / 2).min(l.1);
            }
        }
        let mut at: [u32; MAX_CHORDS] = lists.map(|l| l.0);
        loop {
            let mut x = [0u32; MAX_CHORDS];
            for (k, &f) in self.free.iter().enumerate() {
                x[f] = at[k];
            }
            if self.complete(&rhs, &mut x) {
                visit(&x);
            }
            let Some(k) = (0..nf).rev().find(|&k| at[k] + lists[k].2 <= lists[k].1) else { return };
            at[k] += lists[k].2;
            at[k + 1..nf].iter_mut().zip(&lists[k + 1..nf]).for_each(|(a, l)| *a = l.0);
        }
    }

    /// The part of each pivot that the sides fix; `None` if the sides have no solution.
    fn right_hand_side(&self, sides: &[u32]) -> Option<[i64; MAX_CHORDS]> {
        let dot = |w: &[i64; MAX_SIDES]| sides.iter().zip(w).map(|(&s, &c)| i64::from(s) * c).sum::<i64>();
        if sides.len() != self.sides.len() || self.conditions.iter().any(|c| dot(c) != 0) {
            return None;
        }
        for (row, &s) in self.by_side.iter().zip(sides) {
            if row.iter().map(|&c| u32::from(c)).sum::<u32>() > s {
                return None;
            }
        }
        let mut rhs = [0i64; MAX_CHORDS];
        rhs.iter_mut().zip(&self.rows).for_each(|(r, row)| *r = dot(&row.by_side));
        Some(rhs)
    }

    /// Fills in the pivots after the free chords; false if one is not an integer >= 1.
    fn complete(&self, rhs: &[i64; MAX_CHORDS], x: &mut Chords) -> bool {
        for (r, row) in self.rows.iter().enumerate() {
            let v = rhs[r] - self.free.iter().map(|&f| row.by_free[f] * i64::from(x[f])).sum::<i64>();
            if v < row.den || v % row.den != 0 {
                return false;
            }
            x[row.pivot] = (v / row.den) as u32;
        }
        true
    }

    /// Descends from solution `x` to one where `cost` is least among the solutions that differ in one free
    /// chord, in steps that halve from `step` to 1; returns that cost. Chords that no side sees stay. At
    /// most 64 evaluations.
    pub fn descend(
        &self,
        sides: &[u32],
        x: &mut Chords,
        step: u32,
        cost: &mut dyn FnMut(&Chords) -> f64,
    ) -> f64 {
        let mut best = cost(x);
        let Some(rhs) = self.right_hand_side(sides) else { return best };
        let (mut step, mut left) = (step.max(1), 64);
        loop {
            let mut moved = false;
            for &f in self.free.iter().filter(|&&f| self.by_side.iter().any(|s| s[f] > 0)) {
                for up in [true, false] {
                    let mut y = *x;
                    y[f] = if up { y[f] + step } else { y[f].saturating_sub(step) };
                    if left == 0 || y[f] == 0 || !self.complete(&rhs, &mut y) {
                        continue;
                    }
                    left -= 1;
                    let c = cost(&y);
                    if c < best {
                        (*x, best, moved) = (y, c, true);
                        break;
                    }
                }
            }
            if left == 0 || !moved && step == 1 {
                return best;
            }
            if !moved {
                step = step.div_ceil(2);
            }
        }
    }

    /// Number of quads of the filled pattern.
    pub fn n_quads(&self, x: &Chords) -> u64 {
        let at = |e: (u8, bool)| u64::from(x[self.chord[e.0 as usize] as usize]);
        self.quad_edges.iter().map(|s| at(s[0]) * at(s[1])).sum()
    }
}

fn gcd(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { gcd(b, a % b) }
}
