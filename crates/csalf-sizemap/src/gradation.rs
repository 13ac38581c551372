//! Limits how fast a size field may change: |grad h| <= g.
//!
//! ```text
//!   h │\              original                h*(x) = min over y of ( h(y) + g |x - y| )
//!     │ \    ______
//!     │  \__/······\___   limited: falls to the small sizes no faster than g, and never rises above the original
//!     └─────────────────
//! ```
//!
//! 1. [`limit`]: Dijkstra over the sides of a triangulation, smallest size first (handbook 8.2). The sides that a
//!    flip would make count, too: paths then over-estimate the straight distance less.
//! 2. [`graded`]: a background mesh on which linear interpolation does not hide the limited field: where a side's
//!    middle would be wrong by more than [`MIDPOINT_ERROR`], a Steiner point goes there, and all is done again
//!    (handbook 8.1, with a measured criterion in place of a length).
//!
//! At nodes the limited field is never above the original; between nodes it is linear, so there it may exceed the
//! original by about the same share as the middles. Cost O(n log n) per round.

use crate::{Background, Hint, SizeError, SizeField};
use csalf_geom::Point2;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Largest relative error at the middle of a side before a Steiner point is put there. Larger: a coarser mesh and
/// a blurred field; smaller: more points. 5 % is far below what a quad mesh can follow.
pub const MIDPOINT_ERROR: f64 = 0.05;
/// Most rounds of refinement; each halves the sides.
const MAX_ROUNDS: usize = 12;
/// Most points of a refined background, in multiples of the given ones (and this many more).
const MAX_GROWTH: usize = 8;
const MAX_EXTRA: usize = 20_000;

/// Lowers `values` (one per point) to the largest ones with h_b <= h_a + g |ab| along all sides of `triangles` and
/// along the other diagonals of neighbouring triangles. Applied twice it changes nothing more. Indices must be in
/// range. O(n log n).
pub fn limit(points: &[Point2], triangles: &[[u32; 3]], values: &mut [f64], g: f64) {
    let (start, links) = links(points.len(), triangles);
    // Sizes are positive: their bits are in the order of their values.
    let mut heap: BinaryHeap<Reverse<(u64, u32)>> =
        values.iter().enumerate().map(|(v, h)| Reverse((h.to_bits(), v as u32))).collect();
    while let Some(Reverse((bits, v))) = heap.pop() {
        let h = f64::from_bits(bits);
        if h > values[v as usize] {
            continue;
        }
        for &w in &links[start[v as usize] as usize..start[v as usize + 1] as usize] {
            let most = h + g * points[v as usize].distance(points[w as usize]);
            if most < values[w as usize] {
                values[w as usize] = most;
                heap.push(Reverse((most.to_bits(), w)));
            }
        }
    }
}

/// Neighbours of each point, as slices of one list: along sides, and across each inner side.
fn links(n: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<u32>) {
    let mut pairs = Vec::with_capacity(5 * triangles.len());
    for s in sides(triangles).chunk_by(|a, b| a[..2] == b[..2]) {
        pairs.push([s[0][0], s[0][1]]);
        if let [one, other] = s {
            pairs.push([one[2], other[2]]);
        }
    }
    let mut start = vec![0u32; n + 1];
    for &v in pairs.iter().flatten() {
        start[v as usize + 1] += 1;
    }
    for i in 0..n {
        start[i + 1] += start[i];
    }
    let mut fill = start.clone();
    let mut list = vec![0u32; 2 * pairs.len()];
    for [a, b] in pairs {
        for (v, w) in [(a, b), (b, a)] {
            list[fill[v as usize] as usize] = w;
            fill[v as usize] += 1;
        }
    }
    (start, list)
}

/// All sides of all triangles as (smaller end, larger end, opposite corner), sorted.
fn sides(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut out: Vec<[u32; 3]> = triangles
        .iter()
        .flat_map(|t| [[t[1], t[2], t[0]], [t[2], t[0], t[1]], [t[0], t[1], t[2]]])
        .map(|[a, b, c]| [a.min(b), a.max(b), c])
        .collect();
    out.sort_unstable();
    out
}

/// The field `base`, lowered at `points` to `values` where these are smaller, with |grad h| <= g, as a refined
/// background mesh of the domain that `loops` (indices of points) bound. Serves to limit a field, and to carry the
/// sizes of a finished ring on into what is left (handbook 8.3, layers).
///
/// # Errors
/// [`SizeError`] as of [`Background::from_points`]; [`SizeError::BadGradation`].
pub fn graded(
    base: &dyn SizeField,
    points: &[Point2],
    values: &[f64],
    loops: &[Vec<u32>],
    g: f64,
) -> Result<Background, SizeError> {
    if !g.is_finite() || g <= 0.0 {
        return Err(SizeError::BadGradation(g));
    }
    let mut hint = Hint::default();
    let mut all: Vec<Point2> = points.to_vec();
    let mut start: Vec<f64> = points
        .iter()
        .zip(values)
        .map(|(&p, &v)| if v <= 0.0 { v } else { v.min(base.h(p, &mut hint)) })
        .collect();
    // A bad value (or a missing one) is reported by from_points.
    start.extend(values.iter().skip(points.len()));
    let most = MAX_GROWTH * points.len() + MAX_EXTRA;
    for round in 1.. {
        let mesh = Background::from_points(&all, &start, loops)?;
        // Names are those of the mesh from here on: equal points have become one.
        let at: Vec<Point2> = mesh.points().collect();
        let triangles: Vec<[u32; 3]> = mesh.triangles().collect();
        let mut limited: Vec<f64> = mesh.values().collect();
        limit(&at, &triangles, &mut limited, g);
        let mut new = Vec::new();
        if round < MAX_ROUNDS {
            for s in sides(&triangles).chunk_by(|a, b| a[..2] == b[..2]).filter(|s| s.len() == 2) {
                let (a, b) = (s[0][0] as usize, s[0][1] as usize);
                let length = at[a].distance(at[b]);
                let linear = 0.5 * (limited[a] + limited[b]);
                if length <= linear || all.len() + new.len() >= most {
                    continue;
                }
                let m = at[a].midpoint(at[b]);
                let h = base.h(m, &mut hint);
                let ends = limited[a].min(limited[b]) + 0.5 * g * length;
                let opposite = s.iter().map(|s| limited[s[2] as usize] + g * m.distance(at[s[2] as usize]));
                let want = opposite.fold(h.min(ends), f64::min);
                if (linear - want).abs() > MIDPOINT_ERROR * want {
                    new.push((m, h));
                }
            }
        }
        if new.is_empty() {
            return Ok(mesh.with_values(&limited));
        }
        all.extend(new.iter().map(|n| n.0));
        start.extend(new.iter().map(|n| n.1));
    }
    // Not reached: the last round adds no points.
    Background::from_points(&all, &start, loops)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{loop_indices, of_boundary};
    use crate::{Source, Sources, Uniform, test_loops};
    use proptest::prelude::*;

    fn p(x: f64, y: f64) -> Point2 {
        Point2::new(x, y)
    }

    fn square(n: usize) -> Vec<Point2> {
        test_loops::square(1.0, [n; 4])
    }

    #[test]
    fn a_small_loop_grows_at_the_given_rate() {
        // A square of coarse segments with a tiny, fine hole in the middle.
        let hole: Vec<_> = (0..32)
            .map(|i| p(0.5, 0.5) + Point2::from_angle(-std::f64::consts::TAU * f64::from(i) / 32.0) * 0.01)
            .collect();
        let loops = [square(4), hole];
        let base = of_boundary(&loops).unwrap();
        let points: Vec<_> = loops.iter().flatten().copied().collect();
        let values: Vec<f64> = points.iter().map(|&q| base.h(q, &mut Hint::default())).collect();
        let g = graded(&base, &points, &values, &loop_indices(&loops), 0.1).unwrap();
        for k in 1..40 {
            for a in 0..7 {
                let r = 0.01 + 0.012 * f64::from(k);
                let q = p(0.5, 0.5) + Point2::from_angle(f64::from(a)) * r;
                let (h, was) = (g.h(q, &mut Hint::default()), base.h(q, &mut Hint::default()));
                let exact = was.min(0.00196 + 0.1 * (r - 0.01));
                assert!(h < 1.15 * exact && h > 0.93 * exact, "r {r} a {a}: {h} {exact}");
            }
        }
        assert!(g.n_triangles() < 2500, "{}", g.n_triangles());
    }

    #[test]
    fn nothing_to_limit_adds_no_points() {
        let l = square(8);
        let values = vec![0.125; l.len()];
        let f = graded(&Uniform(0.125), &l, &values, &loop_indices(std::slice::from_ref(&l)), 0.2).unwrap();
        assert_eq!(f.points().count(), l.len());
        assert_eq!(f.range(), (0.125, 0.125));
    }

    #[test]
    fn ring_sizes_lower_a_field() {
        let l = square(8);
        let values: Vec<f64> = l.iter().map(|q| if q.x == 0.0 { 0.01 } else { 1.0 }).collect();
        let f = graded(&Uniform(0.1), &l, &values, &loop_indices(std::slice::from_ref(&l)), 0.2).unwrap();
        let h = |x: f64| f.h(p(x, 0.47), &mut Hint::default());
        for x in [0.05, 0.1, 0.2, 0.3] {
            assert!((h(x) / (0.01 + 0.2 * x) - 1.0).abs() < 0.1, "{x} {}", h(x));
        }
        assert!((h(0.9) - 0.1).abs() < 0.002);
    }

    #[test]
    fn bad_limits_and_values_are_errors() {
        let l = square(2);
        let ids = loop_indices(std::slice::from_ref(&l));
        for g in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(graded(&Uniform(1.0), &l, &[1.0; 8], &ids, g), Err(SizeError::BadGradation(_))));
        }
        let bad = [1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        let e = graded(&Uniform(1.0), &l, &bad, &ids, 0.2).unwrap_err();
        assert!(matches!(e, SizeError::NotPositive { index: 2, .. }), "{e}");
        let e = graded(&Uniform(1.0), &l, &[1.0; 9], &ids, 0.2).unwrap_err();
        assert_eq!(e, SizeError::Lengths { n_points: 8, n_values: 9 });
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn limited_values(
            pts in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 3..80),
            seed in prop::collection::vec(-3.0f64..3.0, 80),
            g in 0.01f64..2.0,
        ) {
            let mut at = square(4);
            at.extend(pts.iter().map(|&(x, y)| p(x, y)));
            let values: Vec<f64> = (0..at.len()).map(|i| seed[i % 80].exp()).collect();
            let mesh = Background::from_points(&at, &values, &[(0..16).collect()]).unwrap();
            let (at, t): (Vec<_>, Vec<_>) = (mesh.points().collect(), mesh.triangles().collect());
            let before: Vec<f64> = mesh.values().collect();
            let mut after = before.clone();
            limit(&at, &t, &mut after, g);
            let least = before.iter().copied().fold(f64::INFINITY, f64::min);
            for (a, b) in after.iter().zip(&before) {
                prop_assert!(a <= b && *a >= least);
            }
            for c in &t {
                for k in 0..3 {
                    let (v, w) = (c[k] as usize, c[(k + 1) % 3] as usize);
                    let d = g * at[v].distance(at[w]);
                    prop_assert!(after[w] <= after[v] + d && after[v] <= after[w] + d);
                }
            }
            // As large as can be: each lowered value is reached from a smaller neighbour.
            for (v, (a, b)) in after.iter().zip(&before).enumerate() {
                let reached = after.iter().enumerate().any(|(w, h)| w != v && h + g * at[v].distance(at[w]) <= a * (1.0 + 1e-12));
                prop_assert!(a == b || reached);
            }
            let mut again = after.clone();
            limit(&at, &t, &mut again, g);
            prop_assert_eq!(again, after);
        }

        /// A background of a source field follows the closed form of its limit.
        #[test]
        fn agrees_with_the_closed_form(x in 0.1f64..0.9, y in 0.1f64..0.9, h in 0.004f64..0.05, qx in 0.0f64..1.0, qy in 0.0f64..1.0) {
            let spot = Source { xy: p(x, y), h, radius: 0.0, falloff: 0.05 };
            let (steep, exact) = (Sources::new(0.1, &[spot], None).unwrap(), Sources::new(0.1, &[spot], Some(0.2)).unwrap());
            let mut l = square(10);
            let ids = loop_indices(std::slice::from_ref(&l));
            l.push(spot.xy);
            let f = graded(&steep, &l, &vec![0.1; l.len()], &ids, 0.2).unwrap();
            let q = p(qx, qy);
            let (a, b) = (f.h(q, &mut Hint::default()), exact.h(q, &mut Hint::default()));
            prop_assert!((a / b).ln().abs() < 0.25, "{} {}", a, b);
        }
    }
}
