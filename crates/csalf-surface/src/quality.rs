//! Quality of quads in space.
//!
//! ```text
//!   corner Jacobian J = (e1 × e2) · n; scaled: J / (|e1| |e2|)
//!   n: normal of the quad's mean plane, on the side of the surface's normals
//! ```
//!
//! A plane quad has the plane's figures; one that is turned over has negative ones. The handbook (9.6) takes
//! the surface's normals at the corners themselves; on meshes that are coarse against the curvature they call
//! sound quads inverted, and other programs (Verdict) use the mean plane.

use crate::report::Quality3d;
use csalf_mesh::quality::{FLAT, space::warpage};
use glam::DVec3;

/// Corner Jacobians and scaled Jacobians of one quad, with the surface's normals at its corners.
pub(crate) fn corners(p: [DVec3; 4], n: [DVec3; 4]) -> ([f64; 4], [f64; 4]) {
    let e = [p[1] - p[0], p[2] - p[1], p[3] - p[2], p[0] - p[3]];
    let l = e.map(DVec3::length);
    let mean = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
    let outwards = n[0] + n[1] + n[2] + n[3];
    let mean = if mean.dot(outwards) < 0.0 { -mean } else { mean };
    let mut j = [0.0; 4];
    let mut s = [-1.0; 4];
    for k in 0..4 {
        let b = (k + 3) & 3;
        j[k] = e[b].cross(e[k]).dot(mean);
        if l[b] * l[k] > 0.0 {
            s[k] = j[k] / (l[b] * l[k]);
        }
    }
    (j, s)
}

impl Quality3d {
    /// The figures of quads of a mesh, with a unit normal of the surface per point; the deviation is left 0.
    /// Indices must be below the lengths of the lists. Cost O(n).
    pub fn measure(points: &[DVec3], normals: &[DVec3], quads: &[[u32; 4]]) -> Self {
        measure(points, quads, |v| normals[v as usize])
    }
}

/// [`Quality3d::measure`] with the normals by a function.
pub(crate) fn measure(points: &[DVec3], quads: &[[u32; 4]], normal: impl Fn(u32) -> DVec3) -> Quality3d {
    let mut out = Quality3d { min_sj: f64::INFINITY, ..Quality3d::default() };
    let (mut sum, mut tau, mut n_tau) = (0.0, 0.0, 0usize);
    for q in quads {
        let p = q.map(|v| points[v as usize]);
        let (j, s) = corners(p, q.map(&normal));
        let worst = s.iter().copied().fold(f64::INFINITY, f64::min);
        sum += worst;
        out.min_sj = out.min_sj.min(worst);
        out.max_warpage = out.max_warpage.max(warpage(p));
        if worst <= FLAT {
            out.n_nonpositive += 1;
        } else {
            let (lo, hi) = j.iter().fold((f64::INFINITY, 0f64), |(a, b), &x| (a.min(x), b.max(x)));
            tau += hi / lo;
            n_tau += 1;
        }
    }
    if quads.is_empty() {
        return Quality3d::default();
    }
    out.mean_sj = sum / quads.len() as f64;
    if n_tau > 0 {
        out.tau = n_tau as f64 / tau;
    }
    out
}
