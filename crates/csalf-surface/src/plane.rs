//! Is the patch a plane, and if so, which.
//!
//! ```text
//!        n          n: sum of the facets' area vectors
//!        │  v       u: the longest segment of the loops, in the plane
//!        │ ╱        o: centre of the box, so that digits are kept far from the origin
//!        o──── u
//! ```

use crate::Facets;
use glam::{DVec2, DVec3};

/// Points this share of the patch's diagonal off the mean plane still count as in it: what single precision
/// files leave. (A node may be off the surface by 1e-6 of the diagonal of its model.)
const OFF: f64 = 5e-7;
/// A facet whose normal turns against the mean one by more than this cosine, and has more area than rounding
/// can make, shows that the patch is folded.
const FOLDED: f64 = 1e-9;

/// A plane with axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) origin: DVec3,
    pub(crate) u: DVec3,
    pub(crate) v: DVec3,
    pub(crate) normal: DVec3,
}

impl Frame {
    /// Coordinates of the foot of `p`.
    #[inline]
    pub(crate) fn flat(&self, p: DVec3) -> DVec2 {
        let d = p - self.origin;
        DVec2::new(d.dot(self.u), d.dot(self.v))
    }

    /// The point at these coordinates.
    #[inline]
    pub(crate) fn lift(&self, p: DVec2) -> DVec3 {
        self.origin + p.x * self.u + p.y * self.v
    }
}

/// The frame of the patch if it is plane and not folded. `axis` gives the direction of u. Cost O(n).
pub(crate) fn frame(facets: &Facets, axis: DVec3) -> Option<Frame> {
    let p = &facets.points;
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut sum = DVec3::ZERO;
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| p[v as usize]);
        (b - a).cross(c - a)
    };
    for t in &facets.triangles {
        for v in t {
            lo = lo.min(p[*v as usize]);
            hi = hi.max(p[*v as usize]);
        }
        sum += area(t);
    }
    let normal = sum.try_normalize()?;
    let (origin, diagonal) = (0.5 * (lo + hi), lo.distance(hi));
    // The plane through the mean of the extremes along the normal.
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in facets.triangles.iter().flatten() {
        let d = (p[*v as usize] - origin).dot(normal);
        (low, high) = (low.min(d), high.max(d));
    }
    if high - low > 2.0 * OFF * diagonal {
        return None;
    }
    let origin = origin + 0.5 * (low + high) * normal;
    let least = -FOLDED * diagonal * diagonal;
    if facets.triangles.iter().any(|t| area(t).dot(normal) < least) {
        return None;
    }
    let u =
        (axis - axis.dot(normal) * normal).try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
    Some(Frame { origin, u, v: normal.cross(u), normal })
}
