//! How good the worst quad of a mesh can be at all, given the boundary that it must keep.
//!
//! ```text
//!      corner                     gap
//!          ╲                          v             a node v close to a segment CD that no node may split
//!           ╲ a                 ╱           ╲       forces an angle of at most max(α, β), one side after the
//!     ───────╲            C ──α───────────────β── D other: a flat quad on CD only brings v closer to its top.
//! ```
//!
//! 1. A corner of angle a < 90° belongs to one quad at best: its scaled Jacobian is at most sin a.
//! 2. A node v over a segment CD: let the quad on CD have angles of at least θ at C and D. Its top passes below v and
//!    is shorter than CD by at most 2 h / tan θ, where h is its height; so with all quads stacked up to v together, whose
//!    heights add up to that of v. The last one has v as a corner. Hence tan θ is at most the height of v over the
//!    distance from its foot to the nearer end of CD.
//!
//! Obtuse angles count like their complements to 180°, as in the scaled Jacobian. Where the line of sight from v to CD
//! is crossed by other segments these give a smaller bound, or v lies beyond a hole and is none.

use csalf_core::Job;
use csalf_geom::arrangement::{Arrangement, CheckOptions};
use csalf_geom::predicates::{Meeting, meeting};
use csalf_geom::{Point2, angle::interior_angle};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Gaps that would allow more than this are not looked at.
const MOST: f64 = 0.9;

/// An upper bound of the smallest scaled Jacobian that any all-quad mesh of the domain can have, 0 to 1; 1 if the
/// domain is not valid. Cost O(n²), with a small constant.
pub fn scaled_jacobian(job: &Job) -> f64 {
    let Ok(a) = Arrangement::new(&job.domain, &CheckOptions::default()) else { return 1.0 };
    let at = |v: u32| a.points[v as usize];
    let mut bound: f64 = 1.0;
    for region in &a.regions {
        let walks: Vec<&[u32]> =
            std::iter::once(region.outer.as_slice()).chain(region.inner.iter().map(Vec::as_slice)).collect();
        let mut segments: Vec<[Point2; 2]> = Vec::new();
        for w in walks.iter().filter(|w| w.len() > 1) {
            let n = w.len();
            for i in 0..n {
                let (u, v, x) = (w[(i + n - 1) % n], w[i], w[(i + 1) % n]);
                let angle = if u == x { TAU } else { interior_angle(at(u), at(v), at(x)) };
                if angle < FRAC_PI_2 {
                    bound = bound.min(angle.sin());
                }
                segments.push([at(v), at(x)]);
            }
        }
        let mut nodes: Vec<u32> = walks.iter().flat_map(|w| w.iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let nodes: Vec<Point2> = nodes.into_iter().map(at).collect();
        let mut gaps = gaps(&segments, &nodes, bound);
        gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let seen = |g: &&(f64, Point2, Point2)| sees(&segments, g.1, g.2);
        bound = gaps.iter().find(seen).map_or(bound, |g| g.0).min(bound);
    }
    bound
}

/// Nodes over segments that bound the scaled Jacobian by less than `least`: the bound, the node, its foot.
fn gaps(segments: &[[Point2; 2]], nodes: &[Point2], least: f64) -> Vec<(f64, Point2, Point2)> {
    let mut out = Vec::new();
    for &[c, d] in segments {
        let length = c.distance(d);
        let along = (d - c) / length;
        for &v in nodes.iter().filter(|&&v| v != c && v != d) {
            let (s, height) = (along.dot(v - c), along.perp_dot(v - c));
            let near = s.min(length - s);
            // sin θ, where tan θ = height / near.
            let sine = height / height.hypot(near);
            if near > 0.0 && height > 0.0 && sine < least.min(MOST) {
                out.push((sine, v, c + s * along));
            }
        }
    }
    out
}

/// True if nothing lies between a node and its foot. Segments at either end do not count.
fn sees(segments: &[[Point2; 2]], v: Point2, foot: Point2) -> bool {
    let foot = v.lerp(foot, 0.999);
    segments.iter().all(|&[a, b]| a == v || b == v || meeting(v, foot, a, b) == Meeting::Apart)
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_geom::Domain;

    fn bound(points: &[(f64, f64)]) -> f64 {
        let points = points.iter().copied().map(Point2::from).collect();
        scaled_jacobian(&Job { domain: Domain::new(points), ..Job::default() })
    }

    #[test]
    fn corners_and_gaps() {
        assert_eq!(bound(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)]), 1.0);
        let corner = bound(&[(0., 0.), (1., 0.), (1., 0.1), (0.5, 0.05)]);
        assert!((corner - 0.1 / 1.01f64.sqrt()).abs() < 1e-12);
        // A notch down to 0.01 over the middle of a side of length 2.
        let notch = bound(&[
            (-1., 0.),
            (1., 0.),
            (1., 1.),
            (0.2, 1.),
            (0., 0.01),
            (-0.2, 1.),
            (-1., 1.),
            (-1.2, 0.5),
        ]);
        assert!((notch - 0.01).abs() < 1e-4, "{notch}");
        // Walls with nodes face to face are no bound.
        let strip = (0..=5).map(|i| (f64::from(i), 0.0)).chain((0..=5).rev().map(|i| (f64::from(i), 0.01)));
        assert_eq!(bound(&strip.collect::<Vec<_>>()), 1.0);
    }
}
