//! Constrained Delaunay triangulations as flat arrays.
//!
//! ```text
//!            2
//!           / \         triangle t is (v0, v1, v2), counter-clockwise;
//!      n1  /   \  n0    neighbour k lies across the side opposite to corner k
//!         / t   \
//!        0───────1
//!            n2
//! ```
//!
//! 1. [`normalised`]: scale by a power of two (exact), so that spade's limits on coordinates never matter.
//! 2. [`merge`]: equal points become one.
//! 3. [`triangulate`]: spade, bulk load, over the whole convex hull.
//! 4. [`inside_loops`]: which triangles lie in the domain, by parity from the hull inwards.

use crate::SizeError;
use crate::cdt::constrained;
use csalf_geom::Point2;
use spade::Triangulation as _;

/// No triangle.
pub(crate) const NONE: u32 = u32::MAX;

/// Scaled coordinates below this are set to 0: spade refuses smaller ones (below 2^-142). Relative to the largest
/// coordinate, which is near 1; far below one rounding step of any point of a real domain.
const FLUSH: f64 = 1e-42;

/// A triangulation of the convex hull of some points.
#[derive(Debug, Default)]
pub(crate) struct Triangulation {
    /// Corners, counter-clockwise.
    pub(crate) corners: Vec<[u32; 3]>,
    /// Triangle across the side opposite to each corner, or [`NONE`] on the hull.
    pub(crate) across: Vec<[u32; 3]>,
    /// Whether an odd number of the given sides run along that side.
    pub(crate) odd: Vec<[bool; 3]>,
}

/// The power of two that brings the largest coordinate into [0.5, 1]; 1 if all are zero or not finite.
pub(crate) fn scale_of(points: &[Point2]) -> f64 {
    let m = points.iter().fold(0.0f64, |m, p| m.max(p.x.abs()).max(p.y.abs()));
    if m > 0.0 && m.is_finite() {
        // Exponents stop at ±1000, so that the scale and its inverse are normal numbers.
        (-m.log2().ceil().clamp(-1000.0, 1000.0)).exp2()
    } else {
        1.0
    }
}

/// `p` times `scale`, with negligible coordinates set to +0.
#[inline]
pub(crate) fn normalised(p: Point2, scale: f64) -> Point2 {
    let f = |x: f64| if x.abs() < FLUSH { 0.0 } else { x };
    Point2::new(f(p.x * scale), f(p.y * scale))
}

/// For each point the index of the distinct point it stands for (numbered by first occurrence), and the first
/// occurrences. O(n log n).
pub(crate) fn merge(points: &[Point2]) -> (Vec<u32>, Vec<u32>) {
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    let at = |i: u32| points[i as usize];
    order.sort_unstable_by(|&i, &j| {
        at(i).x.total_cmp(&at(j).x).then(at(i).y.total_cmp(&at(j).y)).then(i.cmp(&j))
    });
    // Each point's representative is the smallest index of its run of equals.
    let mut name = vec![0u32; points.len()];
    let mut rep = 0;
    for (k, &i) in order.iter().enumerate() {
        if k == 0 || at(i) != at(order[k - 1]) {
            rep = i;
        }
        name[i as usize] = rep;
    }
    let mut first = Vec::with_capacity(points.len());
    for i in 0..points.len() {
        let r = name[i] as usize;
        if r == i {
            name[i] = first.len() as u32;
            first.push(i as u32);
        } else {
            name[i] = name[r];
        }
    }
    (name, first)
}

/// Triangulates distinct, normalised points; sides that cross an earlier constraint are dropped (checked domains
/// have none). O(n log n).
pub(crate) fn triangulate(points: &[Point2], sides: &[[u32; 2]]) -> Result<Triangulation, SizeError> {
    let made = constrained(points.iter().copied(), sides.iter().copied()).map_err(|_| SizeError::NoArea)?;
    let cdt = made.cdt;
    let n = cdt.num_inner_faces();
    let mut out = Triangulation {
        corners: Vec::with_capacity(n),
        across: Vec::with_capacity(n),
        odd: Vec::with_capacity(n),
    };
    // Spade numbers its faces 0 (outside), 1, 2, ...
    for face in cdt.inner_faces() {
        // Side k of spade's face runs from corner k to corner k + 1: it is opposite to corner k + 2.
        let e = face.adjacent_edges();
        let side = |k: usize| &e[(k + 1) % 3];
        out.corners.push([0, 1, 2].map(|k| e[k].from().data().index));
        out.across.push(
            [0, 1, 2].map(|k| side(k).rev().face().as_inner().map_or(NONE, |f| f.fix().index() as u32 - 1)),
        );
        out.odd.push([0, 1, 2].map(|k| made.odd[side(k).fix().as_undirected().index()]));
    }
    Ok(canonical(&out))
}

/// The same triangles, each beginning with its smallest node, in ascending order: rounding depends on the order of the
/// corners, and no number should depend on how spade works.
fn canonical(t: &Triangulation) -> Triangulation {
    let first = |c: &[u32; 3]| (0..3).min_by_key(|&k| c[k]).unwrap_or(0);
    let turn = |c: [u32; 3], k: usize| [c[k], c[(k + 1) % 3], c[(k + 2) % 3]];
    let mut order: Vec<u32> = (0..t.corners.len() as u32).collect();
    order.sort_unstable_by_key(|&i| turn(t.corners[i as usize], first(&t.corners[i as usize])));
    let mut number = vec![NONE; order.len()];
    for (new, &old) in order.iter().enumerate() {
        number[old as usize] = new as u32;
    }
    let mut out = Triangulation::default();
    for &old in &order {
        let i = old as usize;
        let k = first(&t.corners[i]);
        let o = t.odd[i];
        out.corners.push(turn(t.corners[i], k));
        out.across.push(turn(t.across[i], k).map(|n| if n == NONE { NONE } else { number[n as usize] }));
        out.odd.push([o[k], o[(k + 1) % 3], o[(k + 2) % 3]]);
    }
    out
}

/// Which triangles lie inside an odd number of the loops whose segments were the given sides. A segment that occurs
/// twice (both sides of a slit) does not count. O(n).
pub(crate) fn inside_loops(t: &Triangulation) -> Vec<bool> {
    let n = t.corners.len();
    let (mut inside, mut seen) = (vec![false; n], vec![false; n]);
    let mut stack = Vec::new();
    for i in 0..n {
        for k in 0..3 {
            if t.across[i][k] == NONE && !seen[i] {
                (seen[i], inside[i]) = (true, t.odd[i][k]);
                stack.push(i);
            }
        }
    }
    while let Some(i) = stack.pop() {
        for k in 0..3 {
            let j = t.across[i][k];
            if j != NONE && !seen[j as usize] {
                (seen[j as usize], inside[j as usize]) = (true, inside[i] != t.odd[i][k]);
                stack.push(j as usize);
            }
        }
    }
    inside
}

/// Constrained Delaunay triangles, counter-clockwise, of the area inside an odd number of the loops; points that are on
/// no loop become vertices inside. Points must be distinct. A side of a loop that another crosses is not kept: compare
/// the boundary of the triangles with the loops where that may be. O(n log n).
///
/// # Errors
/// [`SizeError::NoArea`] if all points lie on one line, or two are equal, or one is not finite.
pub fn triangulate_loops(points: &[Point2], loops: &[Vec<u32>]) -> Result<Vec<[u32; 3]>, SizeError> {
    let fits = |l: &Vec<u32>| l.iter().all(|&v| (v as usize) < points.len());
    if points.iter().any(|p| !p.is_finite()) || !loops.iter().all(fits) {
        return Err(SizeError::NoArea);
    }
    let scale = scale_of(points);
    let scaled: Vec<Point2> = points.iter().map(|&p| normalised(p, scale)).collect();
    if merge(&scaled).1.len() != points.len() {
        return Err(SizeError::NoArea);
    }
    let sides: Vec<[u32; 2]> =
        loops.iter().flat_map(|l| (0..l.len()).map(|i| [l[i], l[(i + 1) % l.len()]])).collect();
    let t = triangulate(&scaled, &sides)?;
    let inside = inside_loops(&t);
    Ok(t.corners.iter().zip(inside).filter(|(_, inside)| *inside).map(|(c, _)| *c).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_are_triangulated_without_their_holes() {
        let p = |x: f64, y: f64| Point2::new(x, y);
        let pts = [
            p(0., 0.),
            p(4., 0.),
            p(4., 4.),
            p(0., 4.),
            p(1., 1.),
            p(1., 2.),
            p(2., 2.),
            p(2., 1.),
            p(3., 3.),
        ];
        let t = triangulate_loops(&pts, &[vec![0, 1, 2, 3], vec![4, 5, 6, 7]]).unwrap();
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| pts[v as usize]);
            0.5 * (b - a).perp_dot(c - a)
        };
        assert_eq!(t.iter().map(area).sum::<f64>(), 15.0);
        assert!(t.iter().all(|t| area(t) > 0.0) && t.iter().flatten().any(|&v| v == 8));
        assert!(triangulate_loops(&[pts[0], pts[1], pts[0]], &[vec![0, 1, 2]]).is_err());
        assert!(triangulate_loops(&pts, &[vec![0, 1, 99]]).is_err());
    }

    fn ring(n: u32, start: u32) -> Vec<[u32; 2]> {
        (0..n).map(|i| [start + i, start + (i + 1) % n]).collect()
    }

    #[test]
    fn hole_and_outside_are_not_inside() {
        let p = |x: f64, y: f64| Point2::new(x, y);
        let pts = [
            p(0., 0.),
            p(4., 0.),
            p(4., 4.),
            p(2., 3.5),
            p(0., 4.), // concave at the top
            p(1., 1.),
            p(1., 2.),
            p(2., 2.),
            p(2., 1.), // hole
        ];
        let mut sides = ring(5, 0);
        sides.extend(ring(4, 5));
        let t = triangulate(&pts, &sides).unwrap();
        let inside = inside_loops(&t);
        let area: f64 = (0..t.corners.len())
            .filter(|&i| inside[i])
            .map(|i| {
                let [a, b, c] = t.corners[i].map(|v| pts[v as usize]);
                0.5 * (b - a).perp_dot(c - a)
            })
            .sum();
        assert!((area - (16.0 - 1.0 - 1.0)).abs() < 1e-12, "{area}");
        for (i, n) in t.across.iter().enumerate() {
            for (k, &j) in n.iter().enumerate() {
                if j != NONE {
                    assert!(t.across[j as usize].contains(&(i as u32)));
                    let c = t.corners[i];
                    assert!(t.corners[j as usize].contains(&c[(k + 1) % 3]));
                    assert!(t.corners[j as usize].contains(&c[(k + 2) % 3]));
                    assert!(!t.corners[j as usize].contains(&c[k]));
                }
            }
        }
    }

    /// Points on a slit and on the outer side cut them; the field of a mesh around a slit was once that of nearly half
    /// of it, and the rest took the size of the nearest boundary.
    #[test]
    fn a_slit_cut_by_a_point_bounds_nothing() {
        let pts = [(0., 0.), (4., 0.), (4., 4.), (0., 4.), (1., 2.), (3., 2.), (2., 2.), (2., 0.)]
            .map(Point2::from);
        let mut sides = ring(4, 0);
        sides.extend([[4, 5], [5, 4]]);
        let t = triangulate(&pts, &sides).unwrap();
        assert!(inside_loops(&t).iter().all(|&i| i));
        assert!(t.corners.iter().flatten().any(|&v| v == 6) && t.corners.iter().flatten().any(|&v| v == 7));
    }

    #[test]
    fn equal_points_merge_to_the_first() {
        let p = |x: f64| Point2::new(x, 0.0);
        let (name, first) = merge(&[p(2.0), p(1.0), p(2.0), p(3.0), p(1.0)]);
        assert_eq!(name, [0, 1, 0, 2, 1]);
        assert_eq!(first, [0, 1, 3]);
    }

    #[test]
    fn scales_are_powers_of_two() {
        for m in [3.0, 1e-300, 1e300, 0.5, 5e-324] {
            let s = scale_of(&[Point2::new(m, 0.0)]);
            assert_eq!(s.log2(), s.log2().round());
            assert!(m * s <= 1.0);
        }
        assert_eq!(scale_of(&[]), 1.0);
    }
}
