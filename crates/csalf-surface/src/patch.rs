//! The facets with their connectivity, and the charts that cuts divide them into.
//!
//! ```text
//!   side k of facet t runs t[k] -> t[k+1]; its half-side is 3 t + k; twin: the half-side that runs back
//!
//!        2                 a cut separates its two sides: vertices along it are copied,
//!      2/ \1               one local vertex per fan of facets between cuts
//!      0---1
//!        0
//! ```

use crate::{FaceError, Facets};
use glam::DVec3;

/// No half-side.
pub(crate) const NONE: u32 = u32::MAX;

/// A face being meshed: facets, twins, and per facet the facet of the input that it is part of.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    pub(crate) points: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) twin: Vec<u32>,
    /// Facet of the input.
    pub(crate) parent: Vec<u32>,
}

impl Patch {
    /// Facets without those that name a vertex twice. Cost O(n log n).
    ///
    /// # Errors
    /// [`FaceError::NotASurface`], [`FaceError::NoArea`].
    pub(crate) fn new(facets: &Facets) -> Result<Self, FaceError> {
        let mut parent: Vec<u32> = (0..facets.triangles.len() as u32).collect();
        parent.retain(|&t| {
            let [a, b, c] = facets.triangles[t as usize];
            a != b && b != c && c != a
        });
        let triangles: Vec<[u32; 3]> = parent.iter().map(|&t| facets.triangles[t as usize]).collect();
        Self::build(facets.points.clone(), triangles, parent)
    }

    fn build(points: Vec<DVec3>, triangles: Vec<[u32; 3]>, parent: Vec<u32>) -> Result<Self, FaceError> {
        if triangles.is_empty() {
            return Err(FaceError::NoArea);
        }
        let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
        for (t, c) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (c[k], c[(k + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], (3 * t + k) as u32));
            }
        }
        sides.sort_unstable();
        let mut twin = vec![NONE; 3 * triangles.len()];
        let tail = |h: u32| triangles[h as usize / 3][h as usize % 3];
        let mut i = 0;
        while i < sides.len() {
            let n = sides[i..].iter().take_while(|s| s.0 == sides[i].0).count();
            let (g, h) = (sides[i].1, sides[(i + 1).min(sides.len() - 1)].1);
            if n > 2 || (n == 2 && tail(g) == tail(h)) {
                return Err(FaceError::NotASurface { at: points[tail(g) as usize] });
            }
            if n == 2 {
                (twin[g as usize], twin[h as usize]) = (h, g);
            }
            i += n;
        }
        Ok(Self { points, triangles, twin, parent })
    }

    /// The sides for which `is_long` holds (of both half-sides or of none) halved, the facets divided to match. Old
    /// vertices keep their numbers; `values` (one per vertex) are interpolated, and `middle` tells the new vertex in the
    /// middle of each half-side, [`NONE`] of those that are not halved.
    pub(crate) fn subdivided(
        &self,
        values: &mut Vec<f64>,
        is_long: impl Fn(u32) -> bool,
    ) -> Result<(Self, Vec<u32>), FaceError> {
        let mut points = self.points.clone();
        let mut middle = vec![NONE; self.twin.len()];
        for h in 0..middle.len() {
            if middle[h] != NONE || !is_long(h as u32) {
                continue;
            }
            let (a, b) = self.ends(h as u32);
            middle[h] = points.len() as u32;
            points.push(0.5 * (self.points[a as usize] + self.points[b as usize]));
            values.push(0.5 * (values[a as usize] + values[b as usize]));
            if self.twin[h] != NONE {
                middle[self.twin[h] as usize] = middle[h];
            }
        }
        let mut triangles = Vec::with_capacity(4 * self.triangles.len());
        let mut parent = Vec::with_capacity(4 * self.triangles.len());
        for (t, corners) in self.triangles.iter().enumerate() {
            let before = triangles.len();
            let halved: Vec<usize> = (0..3).filter(|&k| middle[3 * t + k] != NONE).collect();
            // The corners from the one that the case is told from, and the middles of the sides that begin there.
            let turned = |k: usize| {
                let at = |i: usize| (k + i) % 3;
                ([0, 1, 2].map(|i| corners[at(i)]), [0, 1, 2].map(|i| middle[3 * t + at(i)]))
            };
            match halved[..] {
                [] => triangles.push(*corners),
                [k] => {
                    let ([a, b, c], [ab, ..]) = turned(k);
                    triangles.extend([[a, ab, c], [ab, b, c]]);
                }
                [j, k] => {
                    // The corner between the two halved sides is cut off, the rest divided by its shorter diagonal.
                    let ([a, b, c], [ab, bc, _]) = turned(if (j + 1) % 3 == k { j } else { k });
                    triangles.push([ab, b, bc]);
                    let p = |v: u32| points[v as usize];
                    if p(a).distance_squared(p(bc)) <= p(ab).distance_squared(p(c)) {
                        triangles.extend([[a, ab, bc], [a, bc, c]]);
                    } else {
                        triangles.extend([[a, ab, c], [ab, bc, c]]);
                    }
                }
                _ => {
                    let ([a, b, c], [ab, bc, ca]) = turned(0);
                    triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
                }
            }
            parent.extend(std::iter::repeat_n(self.parent[t], triangles.len() - before));
        }
        Ok((Self::build(points, triangles, parent)?, middle))
    }

    /// Start and end of a half-side.
    #[inline]
    pub(crate) fn ends(&self, h: u32) -> (u32, u32) {
        let t = &self.triangles[h as usize / 3];
        (t[h as usize % 3], t[(h as usize % 3 + 1) % 3])
    }

    /// Corners of a facet.
    #[inline]
    pub(crate) fn corners(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|v| self.points[v as usize])
    }

    /// Twice the area vector of a facet.
    #[inline]
    pub(crate) fn area_vector(&self, t: u32) -> DVec3 {
        let [a, b, c] = self.corners(t);
        (b - a).cross(c - a)
    }

    /// Area-weighted unit normals at the vertices.
    pub(crate) fn normals(&self) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; self.points.len()];
        for (t, c) in self.triangles.iter().enumerate() {
            let n = self.area_vector(t as u32);
            c.iter().for_each(|&v| out[v as usize] += n);
        }
        out.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        out
    }
}

/// A connected set of facets between cuts, with vertices of its own.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    /// Facets of the patch.
    pub(crate) facets: Vec<u32>,
    /// Three local vertices per facet.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Local half-side across each local half-side.
    pub(crate) across: Vec<u32>,
    /// Vertex of the patch per local vertex.
    pub(crate) vertex: Vec<u32>,
    /// Position per local vertex.
    pub(crate) points: Vec<DVec3>,
    /// Boundary loops as local half-sides in order, the chart on the left.
    pub(crate) loops: Vec<Vec<u32>>,
}

impl Chart {
    /// The chart of these facets. `local_of` is scratch, one entry per facet of the patch, all [`NONE`]; left
    /// so.
    pub(crate) fn new(patch: &Patch, cut: &[bool], facets: Vec<u32>, local_of: &mut [u32]) -> Self {
        for (i, &t) in facets.iter().enumerate() {
            local_of[t as usize] = i as u32;
        }
        let mut across = vec![NONE; 3 * facets.len()];
        for (i, &t) in facets.iter().enumerate() {
            for k in 0..3 {
                let h = 3 * t as usize + k;
                let g = patch.twin[h];
                if !cut[h] && g != NONE && local_of[g as usize / 3] != NONE {
                    across[3 * i + k] = 3 * local_of[g as usize / 3] + g % 3;
                }
            }
        }
        facets.iter().for_each(|&t| local_of[t as usize] = NONE);
        // One local vertex per fan: turn about each corner.
        let mut corner = vec![NONE; across.len()];
        let mut vertex = Vec::new();
        for c in 0..across.len() {
            if corner[c] != NONE {
                continue;
            }
            let id = vertex.len() as u32;
            vertex.push(patch.triangles[facets[c / 3] as usize][c % 3]);
            // Counter-clockwise over the incoming side, then clockwise over the outgoing one.
            let mut at = c as u32;
            loop {
                corner[at as usize] = id;
                let g = across[prev(at) as usize];
                if g == NONE || corner[g as usize] != NONE {
                    break;
                }
                at = g;
            }
            at = c as u32;
            while across[at as usize] != NONE {
                let g = next(across[at as usize]);
                if corner[g as usize] != NONE {
                    break;
                }
                corner[g as usize] = id;
                at = g;
            }
        }
        let triangles: Vec<[u32; 3]> =
            (0..facets.len()).map(|i| [corner[3 * i], corner[3 * i + 1], corner[3 * i + 2]]).collect();
        let points = vertex.iter().map(|&v| patch.points[v as usize]).collect();
        let mut out = Self { facets, triangles, across, vertex, points, loops: Vec::new() };
        out.find_loops();
        out
    }

    fn find_loops(&mut self) {
        let mut leaving = vec![NONE; self.vertex.len()];
        for h in (0..self.across.len()).filter(|&h| self.across[h] == NONE) {
            leaving[self.tail(h as u32) as usize] = h as u32;
        }
        for v in 0..leaving.len() {
            let mut h = leaving[v];
            let mut list = Vec::new();
            while h != NONE {
                let (a, b) = (self.tail(h), self.tail(next(h)));
                leaving[a as usize] = NONE;
                list.push(h);
                h = leaving[b as usize];
            }
            if !list.is_empty() {
                self.loops.push(list);
            }
        }
    }

    /// The local vertex that a half-side starts at.
    #[inline]
    pub(crate) fn tail(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    /// Handles: 0 of what can be drawn in the plane (or is a sphere).
    pub(crate) fn genus(&self) -> i64 {
        let n_boundary: usize = self.loops.iter().map(Vec::len).sum();
        let n_sides = (self.across.len() + n_boundary) / 2;
        let euler = self.vertex.len() as i64 - n_sides as i64 + self.triangles.len() as i64;
        (2 - self.loops.len() as i64 - euler) / 2
    }

    /// Diagonal of the box.
    pub(crate) fn diagonal(&self) -> f64 {
        let (lo, hi) = self
            .points
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        lo.distance(hi)
    }

    /// Area in space.
    pub(crate) fn area(&self) -> f64 {
        let p = |v: u32| self.points[v as usize];
        self.triangles.iter().map(|&[a, b, c]| 0.5 * (p(b) - p(a)).cross(p(c) - p(a)).length()).sum()
    }
}

/// The next half-side of the same facet.
#[inline]
pub(crate) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The half-side before it in the same facet.
#[inline]
pub(crate) fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// The connected components of the facets in `among` (all, if `None`) between cuts, each ascending.
pub(crate) fn components(patch: &Patch, cut: &[bool], among: Option<&[u32]>) -> Vec<Vec<u32>> {
    let n = patch.triangles.len();
    let mut free = vec![among.is_none(); n];
    among.into_iter().flatten().for_each(|&t| free[t as usize] = true);
    let mut out = Vec::new();
    for t in 0..n as u32 {
        if !std::mem::replace(&mut free[t as usize], false) {
            continue;
        }
        let mut list = vec![t];
        let mut i = 0;
        while i < list.len() {
            for k in 0..3 {
                let h = 3 * list[i] as usize + k;
                let g = patch.twin[h];
                if g != NONE && !cut[h] && std::mem::replace(&mut free[g as usize / 3], false) {
                    list.push(g / 3);
                }
            }
            i += 1;
        }
        list.sort_unstable();
        out.push(list);
    }
    out
}
