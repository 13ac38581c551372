//! Bringing a chart into the plane.
//!
//! ```text
//!   given? ─▶ plane? ─▶ no curvature: unroll ─▶ conformal ─▶ convex (Tutte), relaxed ─▶ refused: the caller cuts
//!      └─────────┴──────────────┴──────────────────┴────────────────┴─▶ judged: flips, overlap, distortion
//! ```
//!
//! Source: handbook 9.2 and 9.3.

mod conformal;
mod harmonic;
pub(crate) mod map;
mod relax;
pub(crate) mod sparse;
mod tutte;
mod unroll;

pub(crate) use harmonic::extend;

use crate::Flattening;
use crate::patch::{Chart, NONE};
use crate::{Facets, plane};
use glam::{DVec2, DVec3};
use map::{Verdict, judge};
use sparse::{Order, Symmetric};

/// Flat coordinates per local vertex.
pub(crate) type Flat = Vec<DVec2>;

/// Largest ratio of singular values over 99 % of the area (handbook 9.2).
pub(crate) const MAX_ANISOTROPY: f64 = 2.0;
/// Largest ratio of local scales. A conformal map of a hemisphere has 2; the size field evens it out. Larger:
/// fewer cuts, but the plane mesher has to follow a steeper size field. *Chosen.*
pub(crate) const MAX_SCALE_RANGE: f64 = 5.0;

/// Integral of |K| beyond which a chart is cut at once: that of a spherical cap whose conformal map has a
/// scale range of 5 (3.2 pi), and a little more.
const MAX_CURVATURE: f64 = 3.5 * std::f64::consts::PI;
/// Charts of more vertices are cut rather than relaxed, where they can be: 25 solves of them would take a
/// second.
const MAX_RELAXED: usize = 2_500;

/// A chart in the plane.
#[derive(Clone, Debug)]
pub(crate) struct Flattened {
    pub(crate) flat: Flat,
    pub(crate) how: Flattening,
    pub(crate) verdict: Verdict,
}

impl Flattened {
    /// Lengths are kept, all in one proportion, to within what a size field can show.
    pub(crate) fn is_isometric(&self) -> bool {
        /// *Arbitrary*: the chords of facets of 40 degrees are shorter than their arcs by so much.
        const SAME: f64 = 1.02;
        self.verdict.anisotropy < SAME && self.verdict.scale_range < SAME
    }
}

/// Flattens a chart; `None` if it must be cut first. `given`: flat coordinates per vertex of the patch. With
/// `last_resort` the distortion does not matter, only that nothing is turned over.
pub(crate) fn flatten(chart: &Chart, given: Option<&[DVec2]>, last_resort: bool) -> Option<Flattened> {
    if chart.loops.is_empty() || chart.genus() != 0 {
        return None;
    }
    let good = |v: &Verdict| {
        v.n_flipped == 0
            && !v.overlaps
            && (last_resort || (v.anisotropy <= MAX_ANISOTROPY && v.scale_range <= MAX_SCALE_RANGE))
    };
    let tried = |flat: Flat, how: Flattening| {
        let verdict = judge(chart, &flat);
        good(&verdict).then_some(Flattened { flat, how, verdict })
    };
    if let Some(uv) = given {
        let flat = chart.vertex.iter().map(|&v| uv[v as usize]).collect();
        if let Some(f) = tried(flat, Flattening::Given) {
            return Some(f);
        }
    }
    let facets = Facets { points: chart.points.clone(), triangles: chart.triangles.clone() };
    if let Some(frame) = plane::frame(&facets, longest_boundary_side(chart)) {
        let flat = chart.points.iter().map(|&p| frame.flat(p)).collect();
        if let Some(f) = tried(flat, Flattening::Plane) {
            return Some(f);
        }
    }
    if let Some(f) = unroll::unroll(chart).and_then(|flat| tried(flat, Flattening::Unrolled)) {
        return Some(f);
    }
    if !last_resort && is_hopeless(chart) {
        return None;
    }
    let order = Order::new(&chart.points, &chart.triangles);
    if let Some(flat) = conformal::conformal(chart, &order) {
        let verdict = judge(chart, &flat);
        if good(&verdict) {
            return Some(Flattened { flat, how: Flattening::Conformal, verdict });
        }
        if !last_resort && verdict.n_flipped == 0 && !verdict.overlaps {
            // Sound but too uneven: another map would trade scale for shape. Cut.
            return None;
        }
    }
    if !last_resort && chart.vertex.len() > MAX_RELAXED {
        return None;
    }
    let start = tutte::tutte(chart)?;
    let relaxed = relax::relax(chart, &order, start.clone());
    tried(relaxed, Flattening::Relaxed)
        .or_else(|| if last_resort { tried(start, Flattening::Relaxed) } else { None })
}

/// Whether no map within [`MAX_SCALE_RANGE`] can be hoped for, so that the solve is saved: a tube longer than
/// the logarithm of that range times its radius, or more curvature than a spherical cap of that range has.
fn is_hopeless(chart: &Chart) -> bool {
    let p = |h: u32| chart.points[chart.tail(h) as usize];
    let length = |l: &Vec<u32>| l.iter().map(|&h| p(h).distance(p(crate::patch::next(h)))).sum::<f64>();
    let longest = chart.loops.iter().map(length).fold(0.0, f64::max);
    let slim = std::f64::consts::TAU * chart.area() / (longest * longest);
    if chart.loops.len() >= 2 && slim > 1.5 * MAX_SCALE_RANGE.ln() {
        return true;
    }
    unroll::total_curvature(chart) > MAX_CURVATURE
}

/// The longest side of the boundary: an axis that turns with the part.
fn longest_boundary_side(chart: &Chart) -> DVec3 {
    let mut best = DVec3::X;
    let mut length = 0.0;
    for &h in chart.loops.iter().flatten() {
        let p = |h: u32| chart.points[chart.tail(h) as usize];
        let d = p(crate::patch::next(h)) - p(h);
        if d.length_squared() > length {
            (best, length) = (d, d.length_squared());
        }
    }
    best
}

/// One unknown: vertex and component.
type Unknown = (u32, u32);

/// Solves sum of terms (each stands for (i, j) and (j, i), or for the diagonal) times x = 0 for the entries
/// of `flat` that are NaN, the others given. `None` if the system is not positive definite.
fn assemble(
    order: &Order,
    terms: &[(Unknown, Unknown, f64)],
    flat: &mut Flat,
    new: impl Fn(usize) -> Symmetric,
) -> Option<()> {
    // Unknowns in the order of elimination, without the given ones.
    let mut by_rank = vec![NONE; flat.len()];
    for (v, &r) in order.rank.iter().enumerate() {
        by_rank[r as usize] = v as u32;
    }
    let mut index = vec![NONE; flat.len()];
    let mut n = 0u32;
    for &v in by_rank.iter().filter(|&&v| v != NONE) {
        if flat[v as usize].is_nan() {
            index[v as usize] = n;
            n += 1;
        }
    }
    let mut matrix = new(2 * n as usize);
    let mut rhs = vec![0f64; 2 * n as usize];
    let dof = |(v, c): Unknown| (index[v as usize] != NONE).then(|| 2 * index[v as usize] + c);
    for &(i, j, w) in terms {
        match (dof(i), dof(j)) {
            (Some(a), Some(b)) => matrix.add(a, b, w),
            (Some(a), None) => rhs[a as usize] -= w * flat[j.0 as usize][j.1 as usize],
            (None, Some(b)) => rhs[b as usize] -= w * flat[i.0 as usize][i.1 as usize],
            (None, None) => {}
        }
    }
    matrix.factor()?.solve(&mut rhs);
    for (v, &i) in index.iter().enumerate() {
        if i != NONE {
            flat[v] = DVec2::new(rhs[2 * i as usize], rhs[2 * i as usize + 1]);
        }
    }
    flat.iter().all(|p| p.is_finite()).then_some(())
}

#[cfg(test)]
mod tests;
