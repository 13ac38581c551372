//! Closes an odd contour with exactly one triangle, for callers that allow them.
//!
//! ```text
//!        c                 the triangle at the ear b; the contour without b is even
//!      ╱   ╲
//!    b ───── a ── ...      a, b, c: three occurrences in order, ac a diagonal inside
//! ```
//!
//! 1. Triangulate the contour ([`corners::triangulate`]); at least two triangles have two contour sides (ears).
//! 2. Take the ear that is closest to equilateral.
//! 3. Fill the rest ([`super::fill`]).
//!
//! Cost: O(n log n). Source: handbook 4.9 (last paragraph).

use super::{FallbackError, check_points, corners};
use csalf_geom::Tolerance;
use csalf_mesh::{Contour, Patch};

/// What [`fill_odd`] makes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OddPatch {
    /// The only triangle, counter-clockwise, in local names.
    pub triangle: [u32; 3],
    /// The quads of the rest, in the same local names; no children.
    pub patch: Patch,
}

/// The best place for the one triangle of an odd contour: the occurrence whose triangle with its two neighbours lies
/// inside and is closest to equilateral. Without that occurrence the contour is even.
///
/// # Errors
/// A [`FallbackError`] as of [`super::fill`], and [`FallbackError::Even`] for an even number of nodes.
pub fn ear(contour: &Contour) -> Result<usize, FallbackError> {
    let n = contour.len();
    check_points(contour, 3)?;
    if n.is_multiple_of(2) {
        return Err(FallbackError::Even { n_nodes: n });
    }
    let inner = corners::triangulate(contour, &vec![false; n], &[], false)?;
    let shape = |t: &[u32; 3]| {
        let p = t.map(|i| contour.points[i as usize]);
        let around: f64 = (0..3).map(|k| p[k].distance_squared(p[(k + 1) % 3])).sum();
        (p[1] - p[0]).perp_dot(p[2] - p[0]) / around
    };
    let mut best: Option<(f64, usize)> = None;
    for t in &inner.triangles {
        // The ear's tip is the corner whose two neighbours along the contour are the other corners.
        let follows = |a: u32, b: u32| (a as usize + 1) % n == b as usize;
        let tip = (0..3).find(|&k| follows(t[(k + 2) % 3], t[k]) && follows(t[k], t[(k + 1) % 3]));
        if let Some(k) = tip
            && best.is_none_or(|b| shape(t) > b.0)
        {
            best = Some((shape(t), t[k] as usize));
        }
    }
    best.map(|b| b.1).ok_or(FallbackError::NotSimple { at: 0 })
}

/// A contour without its occurrence `tip`.
pub fn without(contour: &Contour, tip: usize) -> Contour {
    let mut rest = Contour::default();
    for i in (0..contour.len()).filter(|&i| i != tip) {
        rest.push(contour.points[i], contour.ids[i], at(&contour.sizes, i), at(&contour.flags, i));
    }
    rest
}

/// Fills a contour of an odd number of nodes (at least 3) with one triangle and strictly convex quads.
///
/// # Errors
/// As of [`ear`].
pub fn fill_odd(contour: &Contour, tolerance: Tolerance) -> Result<OddPatch, FallbackError> {
    let n = contour.len();
    let tip = ear(contour)?;
    let name = |i: usize| (i % n) as u32;
    let triangle = [name(tip + n - 1), name(tip), name(tip + 1)];
    if n == 3 {
        return Ok(OddPatch { triangle, patch: Patch::default() });
    }
    let mut patch = super::fill(&without(contour, tip), tolerance)?;
    // Occurrences after the tip are one further in the whole contour, and so are all new points.
    let whole = |v: u32| v + u32::from(v as usize >= tip);
    for q in &mut patch.quads {
        *q = q.map(whole);
    }
    Ok(OddPatch { triangle, patch })
}

fn at<T: Copy + Default>(list: &[T], i: usize) -> T {
    list.get(i).copied().unwrap_or_default()
}
