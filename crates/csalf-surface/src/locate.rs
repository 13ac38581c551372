//! Finding points: in a flattened chart, and on the facets in space.
//!
//! ```text
//!   plane: the facet of the last point, its neighbours, then the facets listed in the point's grid cell
//!   space: from facet to facet across the side that the foot of the point lies behind, to the nearest point
//! ```

use crate::flatten::Flat;
use crate::patch::{Chart, NONE, Patch, next};
use glam::{DVec2, DVec3};

/// Barycentric coordinates this far below zero still count as in the facet.
const EDGE: f64 = 1e-12;
/// Steps of a walk to a near point.
const STEPS: usize = 8;

/// A place on the facets: facet of the patch and barycentric coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Anchor {
    pub(crate) facet: u32,
    pub(crate) bary: [f64; 3],
}

impl Anchor {
    /// The point in space.
    #[inline]
    pub(crate) fn point(&self, patch: &Patch) -> DVec3 {
        mix(patch.corners(self.facet), self.bary)
    }
}

#[inline]
pub(crate) fn mix(p: [DVec3; 3], b: [f64; 3]) -> DVec3 {
    p[0] * b[0] + p[1] * b[1] + p[2] * b[2]
}

/// Finds points in a flat chart.
#[derive(Debug)]
pub(crate) struct Locator<'a> {
    chart: &'a Chart,
    flat: &'a Flat,
    low: DVec2,
    per: DVec2,
    n: u32,
    start: Vec<u32>,
    list: Vec<u32>,
}

impl<'a> Locator<'a> {
    /// Sorts the facets into a grid. Cost O(n) for facets of similar size.
    pub(crate) fn new(chart: &'a Chart, flat: &'a Flat) -> Self {
        let (low, high) =
            flat.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let n = (chart.triangles.len() as f64).sqrt().ceil().clamp(1.0, 512.0) as u32;
        let per = DVec2::splat(f64::from(n)) / (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let mut out =
            Self { chart, flat, low, per, n, start: vec![0; (n * n) as usize + 1], list: Vec::new() };
        let boxes: Vec<_> = chart
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| flat[v as usize]);
                (out.cell(a.min(b).min(c)), out.cell(a.max(b).max(c)))
            })
            .collect();
        let each = |f: &mut dyn FnMut(usize, u32)| {
            for (t, &(a, b)) in boxes.iter().enumerate() {
                for y in a.1..=b.1 {
                    for x in a.0..=b.0 {
                        f((y * n + x) as usize, t as u32);
                    }
                }
            }
        };
        let mut start = std::mem::take(&mut out.start);
        each(&mut |c, _| start[c + 1] += 1);
        for i in 0..start.len() - 1 {
            start[i + 1] += start[i];
        }
        let mut fill = start.clone();
        let mut list = vec![0; start[start.len() - 1] as usize];
        each(&mut |c, t| {
            list[fill[c] as usize] = t;
            fill[c] += 1;
        });
        (out.start, out.list) = (start, list);
        out
    }

    fn cell(&self, p: DVec2) -> (u32, u32) {
        let c = ((p - self.low) * self.per).clamp(DVec2::ZERO, DVec2::splat(f64::from(self.n - 1)));
        (c.x as u32, c.y as u32)
    }

    /// Barycentric coordinates in facet `t`; `None` if it has no area.
    fn bary(&self, t: u32, p: DVec2) -> Option<[f64; 3]> {
        let [a, b, c] = self.chart.triangles[t as usize].map(|v| self.flat[v as usize]);
        let twice = (b - a).perp_dot(c - a);
        if twice <= 0.0 || twice.is_nan() {
            return None;
        }
        let (w0, w1) = ((b - p).perp_dot(c - p) / twice, (c - p).perp_dot(a - p) / twice);
        Some([w0, w1, 1.0 - w0 - w1])
    }

    /// The facet (local number) that `p` lies in, and where; the nearest boundary point of one outside.
    /// `last`: a facet near by.
    pub(crate) fn find(&self, p: DVec2, last: u32) -> (u32, [f64; 3]) {
        let mut t = last;
        for _ in 0..STEPS {
            let Some(w) = self.bary(t, p) else { break };
            let k = if w[0] <= w[1] && w[0] <= w[2] {
                0
            } else if w[1] <= w[2] {
                1
            } else {
                2
            };
            if w[k] >= -EDGE {
                return (t, clamped(w));
            }
            // The side opposite to corner k.
            match self.chart.across[3 * t as usize + (k + 1) % 3] {
                NONE => break,
                g => t = g / 3,
            }
        }
        let (x, y) = self.cell(p);
        let c = (y * self.n + x) as usize;
        for &t in &self.list[self.start[c] as usize..self.start[c + 1] as usize] {
            if let Some(w) = self.bary(t, p)
                && w.iter().all(|&w| w >= -EDGE)
            {
                return (t, clamped(w));
            }
        }
        self.nearest_boundary(p)
    }

    fn nearest_boundary(&self, p: DVec2) -> (u32, [f64; 3]) {
        let mut best = (f64::INFINITY, 0, [1.0, 0.0, 0.0]);
        for &h in self.chart.loops.iter().flatten() {
            let (a, b) = (self.chart.tail(h), self.chart.tail(next(h)));
            let (a, b) = (self.flat[a as usize], self.flat[b as usize]);
            let d = b - a;
            let l = d.length_squared();
            let s = if l > 0.0 { ((p - a).dot(d) / l).clamp(0.0, 1.0) } else { 0.0 };
            let far = (a + s * d).distance_squared(p);
            if far < best.0 {
                let mut w = [0.0; 3];
                w[h as usize % 3] = 1.0 - s;
                w[(h as usize % 3 + 1) % 3] = s;
                best = (far, h / 3, w);
            }
        }
        (best.1, best.2)
    }
}

fn clamped(w: [f64; 3]) -> [f64; 3] {
    let w = w.map(|w| w.max(0.0));
    let s = w[0] + w[1] + w[2];
    w.map(|w| w / s)
}

/// The point of the facets near `p`, from a place near by: exact where the facets are plane there, else the
/// end of a descent from facet to facet.
pub(crate) fn nearest(patch: &Patch, start: Anchor, p: DVec3) -> Anchor {
    let mut at = start;
    let mut before = NONE;
    for _ in 0..64 {
        let [a, b, c] = patch.corners(at.facet);
        let (u, v, d) = (b - a, c - a, p - a);
        let n = u.cross(v);
        let nn = n.length_squared();
        if nn <= 0.0 {
            return at;
        }
        let w1 = d.cross(v).dot(n) / nn;
        let w2 = u.cross(d).dot(n) / nn;
        let w = [1.0 - w1 - w2, w1, w2];
        let k = if w[0] <= w[1] && w[0] <= w[2] {
            0
        } else if w[1] <= w[2] {
            1
        } else {
            2
        };
        if w[k] >= -EDGE {
            return Anchor { facet: at.facet, bary: clamped(w) };
        }
        // Behind a side: its nearest point here, and over it if there is a facet.
        let h = 3 * at.facet + (k as u32 + 1) % 3;
        let (x, y) = patch.ends(h);
        let (x, y) = (patch.points[x as usize], patch.points[y as usize]);
        let l = (y - x).length_squared();
        let s = if l > 0.0 { ((p - x).dot(y - x) / l).clamp(0.0, 1.0) } else { 0.0 };
        let mut bary = [0.0; 3];
        bary[h as usize % 3] = 1.0 - s;
        bary[(h as usize % 3 + 1) % 3] = s;
        let g = patch.twin[h as usize];
        at = Anchor { facet: at.facet, bary };
        if g == NONE || g / 3 == before {
            return at;
        }
        before = at.facet;
        let mut bary = [0.0; 3];
        bary[g as usize % 3] = s;
        bary[(g as usize % 3 + 1) % 3] = 1.0 - s;
        at = Anchor { facet: g / 3, bary };
    }
    at
}
