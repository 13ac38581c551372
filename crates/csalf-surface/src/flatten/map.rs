//! Facets as linear maps: gradients, singular values, and whether a flattening is fit for use.

use super::Flat;
use crate::patch::Chart;
use csalf_geom::predicates::{Meeting, meeting, orient2d};
use glam::{DMat2, DVec2, DVec3};

/// A facet lower than this share of its longest side is treated as this high: a sliver has no shape of its
/// own.
const SLIVER: f64 = 1e-4;
/// A facet lower than this share of the chart's diagonal may be turned over by rounding without harm.
const NEEDLE: f64 = 1e-7;

/// Gradients of the three hat functions in the facet's own axes, and its area. (Slivers are fattened.)
pub(crate) fn gradients(p: [DVec3; 3]) -> ([DVec2; 3], f64) {
    let e = p[1] - p[0];
    let f = p[2] - p[0];
    let longest = e.length().max(f.length()).max((p[2] - p[1]).length());
    if longest <= 0.0 {
        return ([DVec2::ZERO; 3], 0.0);
    }
    let l = e.length().max(SLIVER * longest);
    let x = e / l;
    let along = f.dot(x);
    let height = (f - along * x).length().max(SLIVER * longest);
    let q = [DVec2::ZERO, DVec2::new(l, 0.0), DVec2::new(along, height)];
    let twice = l * height;
    let g = |j: usize, k: usize| (q[k] - q[j]).perp() / twice;
    ([g(1, 2), g(2, 0), g(0, 1)], 0.5 * twice)
}

/// The Jacobian of the flattening of one facet, from its own axes to the plane.
#[inline]
pub(crate) fn jacobian(g: &[DVec2; 3], u: [DVec2; 3]) -> DMat2 {
    let col = |c: usize| u[0] * g[0][c] + u[1] * g[1][c] + u[2] * g[2][c];
    DMat2::from_cols(col(0), col(1))
}

/// Singular values of a 2x2 matrix, the second with the sign of the determinant.
#[inline]
pub(crate) fn singular(j: DMat2) -> (f64, f64) {
    let (a, b, c, d) = (j.x_axis.x, j.y_axis.x, j.x_axis.y, j.y_axis.y);
    let p = (a + d).hypot(c - b);
    let m = (a - d).hypot(c + b);
    (0.5 * (p + m), 0.5 * (p - m))
}

/// How good a flattening is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
    /// Facets turned over or without area.
    pub(crate) n_flipped: usize,
    /// sigma1 / sigma2 that 99 % of the area stay below.
    pub(crate) anisotropy: f64,
    /// Largest over smallest local scale, without 1 % of the area at both ends.
    pub(crate) scale_range: f64,
    /// Mean local scale, plane over space.
    pub(crate) mean_scale: f64,
    /// Largest difference (degrees) of the material's angle at boundary vertices, plane against space.
    pub(crate) angle_error: f64,
    /// The boundary crosses itself.
    pub(crate) overlaps: bool,
}

/// Judges a flattening. Cost O(n log n).
pub(crate) fn judge(chart: &Chart, flat: &Flat) -> Verdict {
    let needle = NEEDLE * chart.diagonal();
    let mut n_flipped = 0;
    let mut list = Vec::with_capacity(chart.triangles.len());
    let mut turn = vec![0f64; chart.vertex.len()];
    let mut plane_area = 0.0;
    for t in &chart.triangles {
        let p = t.map(|v| chart.points[v as usize]);
        let u = t.map(|v| flat[v as usize]);
        let (g, _) = gradients(p);
        let twice = (p[1] - p[0]).cross(p[2] - p[0]).length();
        let longest = (p[1] - p[0]).length().max((p[2] - p[0]).length()).max((p[2] - p[1]).length());
        let thin = twice <= needle * longest;
        if orient2d(u[0], u[1], u[2]) <= 0.0 {
            n_flipped += usize::from(!thin);
            continue;
        }
        let (s1, s2) = singular(jacobian(&g, u));
        plane_area += (u[1] - u[0]).perp_dot(u[2] - u[0]);
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let (a, b, c, d) = (p[i] - p[k], p[j] - p[k], u[i] - u[k], u[j] - u[k]);
            turn[t[k] as usize] += a.cross(b).length().atan2(a.dot(b)) - c.perp_dot(d).atan2(c.dot(d));
        }
        if s2 > 0.0 && !thin {
            list.push((s1 / s2, (s1 * s2).sqrt(), twice));
        }
    }
    let total: f64 = list.iter().map(|x| x.2).sum();
    list.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let anisotropy = quantile(&list, 0.99 * total, |x| x.0);
    list.sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
    let (lo, hi) = (quantile(&list, 0.01 * total, |x| x.1), quantile(&list, 0.99 * total, |x| x.1));
    let overlaps = n_flipped == 0 && crosses(chart, flat);
    let at_rim = chart.loops.iter().flatten().map(|&h| turn[chart.tail(h) as usize].abs());
    let angle_error = at_rim.fold(0.0, f64::max).to_degrees();
    let mean_scale = if total > 0.0 { (plane_area / total).sqrt() } else { 1.0 };
    Verdict { n_flipped, anisotropy, scale_range: hi / lo, mean_scale, angle_error, overlaps }
}

/// The first value at which the areas sum to `at`.
fn quantile(list: &[(f64, f64, f64)], at: f64, value: impl Fn(&(f64, f64, f64)) -> f64) -> f64 {
    let mut sum = 0.0;
    for x in list {
        sum += x.2;
        if sum >= at {
            return value(x);
        }
    }
    list.last().map_or(1.0, value)
}

/// Whether two sides of the flat boundary meet that have no vertex in common. Sides are sorted into the
/// columns and rows of a grid; cost O(n) for sides of similar length.
fn crosses(chart: &Chart, flat: &Flat) -> bool {
    let sides: Vec<(u32, u32)> = chart
        .loops
        .iter()
        .flat_map(|l| (0..l.len()).map(|i| (chart.tail(l[i]), chart.tail(l[(i + 1) % l.len()]))))
        .collect();
    let p = |v: u32| flat[v as usize];
    let (lo, hi) = sides
        .iter()
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), s| (lo.min(p(s.0)), hi.max(p(s.0))));
    let n = ((sides.len() as f64).sqrt().ceil().clamp(1.0, 256.0)) as u32;
    let per = DVec2::splat(f64::from(n)) / (hi - lo).max(DVec2::splat(f64::MIN_POSITIVE));
    let cell = |q: DVec2| {
        let c = ((q - lo) * per).floor().clamp(DVec2::ZERO, DVec2::splat(f64::from(n - 1)));
        (c.x as u32, c.y as u32)
    };
    let mut cells: Vec<(u32, u32)> = Vec::new();
    for (i, s) in sides.iter().enumerate() {
        let (a, b) = (cell(p(s.0).min(p(s.1))), cell(p(s.0).max(p(s.1))));
        for y in a.1..=b.1 {
            for x in a.0..=b.0 {
                cells.push((y * n + x, i as u32));
            }
        }
    }
    cells.sort_unstable();
    cells.chunk_by(|a, b| a.0 == b.0).any(|c| {
        c.iter().enumerate().any(|(k, a)| {
            let (a0, a1) = sides[a.1 as usize];
            c[k + 1..].iter().any(|b| {
                let (b0, b1) = sides[b.1 as usize];
                let apart = a0 != b0 && a0 != b1 && a1 != b0 && a1 != b1;
                apart && meeting(p(a0), p(a1), p(b0), p(b1)) != Meeting::Apart
            })
        })
    })
}

/// Local scale (length in the plane over length in space) per local vertex, from the areas around it.
pub(crate) fn scales(chart: &Chart, flat: &Flat) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); flat.len()];
    for t in &chart.triangles {
        let p = t.map(|v| chart.points[v as usize]);
        let u = t.map(|v| flat[v as usize]);
        let (a, b) = ((u[1] - u[0]).perp_dot(u[2] - u[0]), (p[1] - p[0]).cross(p[2] - p[0]).length());
        for &v in t {
            sums[v as usize].0 += a;
            sums[v as usize].1 += b;
        }
    }
    sums.iter().map(|&(a, b)| if a > 0.0 && b > 0.0 { (a / b).sqrt() } else { 1.0 }).collect()
}
