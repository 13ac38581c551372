//! The planar graph of loops and scars, and its faces on the material side.
//!
//! ```text
//!      ┌──────◀──────┐        half-edge 2e runs along edge e, 2e + 1 back; a loop has material on the side of 2e
//!      │   ┌──▶──┐   │        only, a scar on both. At a node, the next half-edge of a face is the one just
//!      │   └──◀──┘   │        clockwise of the way back.
//!      └──────▶──────┘
//! ```
//!
//! 1. [`Graph::new`]: half-edges leaving each node, sorted counter-clockwise by exact predicates.
//! 2. [`Graph::walks`]: traces the faces and tells the outer walk of a face from inner ones by the corner at the
//!    leftmost node.
//! 3. [`Graph::locate`]: an exact ray to the left finds the walk next to a place.
//!
//! Assumes that edges meet only at nodes (as checked). Cost O(n log n); a location O(log n) as a rule.

use crate::Point2;
use crate::boxtree::{Aabb, BoxTree};
use crate::check::is_left_of;
use crate::predicates::orient2d;
use std::cmp::Ordering;

/// Not a walk.
pub(crate) const NO_WALK: u32 = u32::MAX;

/// Nodes and half-edges.
#[derive(Debug)]
pub(crate) struct Graph<'a> {
    points: &'a [Point2],
    /// Start node of each half-edge; the end is the start of its twin h ^ 1.
    start: Vec<u32>,
    /// Half-edges from this one on belong to scars.
    first_scar: u32,
    /// For each half-edge, the one that follows it on its face.
    next: Vec<u32>,
}

/// One closed walk along a face, material on the left.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Walk {
    /// Half-edges in order, starting at the leftmost node.
    pub(crate) half_edges: Vec<u32>,
    /// True if the face lies around the walk, not in it.
    pub(crate) is_inner: bool,
}

/// Order from left to right, from bottom to top.
pub(crate) fn left_to_right(p: Point2, q: Point2) -> Ordering {
    // Adding zero makes -0 and 0 equal.
    (p.x + 0.0).total_cmp(&(q.x + 0.0)).then((p.y + 0.0).total_cmp(&(q.y + 0.0)))
}

/// Exact order of the directions `v → p` and `v → q` by angle, counter-clockwise from the direction to the left,
/// which comes last.
fn by_angle(v: Point2, p: Point2, q: Point2) -> Ordering {
    // Lower half first: angles (-π, 0) before [0, π].
    let upper = |p: Point2| p.y >= v.y;
    let left = |p: Point2| p.y == v.y && p.x < v.x;
    upper(p).cmp(&upper(q)).then(left(p).cmp(&left(q))).then_with(|| {
        let o = orient2d(v, p, q);
        if o > 0.0 {
            Ordering::Less
        } else if o < 0.0 {
            Ordering::Greater
        } else {
            Ordering::Equal
        }
    })
}

impl<'a> Graph<'a> {
    /// The graph of closed loops (material on the left) and open scars, given as node numbers.
    pub(crate) fn new(points: &'a [Point2], loops: &[Vec<u32>], scars: &[Vec<u32>]) -> Self {
        let mut start = Vec::new();
        for l in loops {
            for i in 0..l.len() {
                start.extend([l[i], l[(i + 1) % l.len()]]);
            }
        }
        let first_scar = start.len() as u32;
        for s in scars {
            for w in s.windows(2) {
                start.extend([w[0], w[1]]);
            }
        }
        // Half-edges by start node, counting sort.
        let mut from = vec![0u32; points.len() + 1];
        for &v in &start {
            from[v as usize + 1] += 1;
        }
        for v in 0..points.len() {
            from[v + 1] += from[v];
        }
        let mut fill = from.clone();
        let mut out = vec![0u32; start.len()];
        for (h, &v) in start.iter().enumerate() {
            out[fill[v as usize] as usize] = h as u32;
            fill[v as usize] += 1;
        }
        let mut next = vec![0u32; start.len()];
        for v in 0..points.len() {
            let star = &mut out[from[v] as usize..from[v + 1] as usize];
            if star.len() > 2 {
                let end = |h: u32| points[start[(h ^ 1) as usize] as usize];
                star.sort_unstable_by(|&g, &h| by_angle(points[v], end(g), end(h)).then(g.cmp(&h)));
            }
            for i in 0..star.len() {
                let clockwise = star[(i + star.len() - 1) % star.len()];
                next[(star[i] ^ 1) as usize] = clockwise;
            }
        }
        Self { points, start, first_scar, next }
    }

    /// Start node of half-edge `h`.
    pub(crate) fn node(&self, h: u32) -> u32 {
        self.start[h as usize]
    }

    fn point(&self, h: u32) -> Point2 {
        self.points[self.node(h) as usize]
    }

    fn has_material(&self, h: u32) -> bool {
        h >= self.first_scar || h.is_multiple_of(2)
    }

    /// All walks with material on the left, ordered by their start, which is the leftmost node (of several
    /// occurrences, the one with the leftmost next node); and the walk of each half-edge.
    pub(crate) fn walks(&self) -> (Vec<Walk>, Vec<u32>) {
        let mut walks = Vec::new();
        let mut walk_of = vec![NO_WALK; self.start.len()];
        for h in (0..self.start.len() as u32).filter(|&h| self.has_material(h)) {
            if walk_of[h as usize] != NO_WALK {
                continue;
            }
            let (mut half_edges, mut g) = (Vec::new(), h);
            // `next` is a permutation, so this comes back to h; the guard keeps a broken graph from looping.
            while walk_of[g as usize] == NO_WALK {
                walk_of[g as usize] = 0;
                half_edges.push(g);
                g = self.next[g as usize];
            }
            let key = |&g: &u32| (self.point(g), self.point(g ^ 1));
            let order = |a: &u32, b: &u32| {
                let ((p, p2), (q, q2)) = (key(a), key(b));
                left_to_right(p, q).then_with(|| left_to_right(p2, q2))
            };
            let first =
                (0..half_edges.len()).min_by(|&i, &j| order(&half_edges[i], &half_edges[j])).unwrap_or(0);
            half_edges.rotate_left(first);
            let is_inner = self.goes_around(&half_edges);
            walks.push(Walk { half_edges, is_inner });
        }
        let start = |w: &Walk| (self.point(w.half_edges[0]), self.point(w.half_edges[0] ^ 1));
        walks.sort_by(|a, b| {
            let ((p, p2), (q, q2)) = (start(a), start(b));
            left_to_right(p, q).then_with(|| left_to_right(p2, q2))
        });
        for (k, w) in walks.iter().enumerate() {
            for &h in &w.half_edges {
                walk_of[h as usize] = k as u32;
            }
        }
        (walks, walk_of)
    }

    /// Exact: the direction to the left at the leftmost node, with which the walk starts, lies in the material.
    fn goes_around(&self, half_edges: &[u32]) -> bool {
        let (n, v) = (half_edges.len(), self.node(half_edges[0]));
        let p = self.points[v as usize];
        (0..n).filter(|&i| self.node(half_edges[i]) == v).any(|i| {
            let before = self.node(half_edges[(i + n - 1) % n]);
            let after = self.node(half_edges[(i + 1) % n]);
            before == after || orient2d(p, self.points[before as usize], self.points[after as usize]) > 0.0
        })
    }

    /// A tree of the boxes of all edges.
    pub(crate) fn tree(&self) -> BoxTree {
        let n = self.start.len() as u32 / 2;
        BoxTree::new((0..n).map(|e| Aabb::of_segment(self.point(2 * e), self.point(2 * e + 1), 0.0)))
    }

    /// Exact: the half-edge first met, on its right to left way, by a ray from `q` (or just above it) to the left;
    /// its left side faces `q`. Edges that pass through `q` are not met.
    pub(crate) fn locate(&self, tree: &BoxTree, q: Point2) -> Option<u32> {
        let mut best: Option<u32> = None;
        tree.ray_left(q, &mut |e| {
            let (a, b) = (self.point(2 * e), self.point(2 * e + 1));
            if is_left_of(a, b, q) {
                // The half-edge that runs down has q on its left.
                let down = if a.y > b.y { 2 * e } else { 2 * e + 1 };
                if best.is_none_or(|f| self.is_right_of(down, f)) {
                    best = Some(down);
                }
            }
            best.map_or(f64::NEG_INFINITY, |f| self.point(f).x.min(self.point(f ^ 1).x))
        });
        best
    }

    /// Exact: of two edges running down that share a range of heights and do not cross, `e` is right of `f` there.
    fn is_right_of(&self, e: u32, f: u32) -> bool {
        let (et, eb, ft, fb) = (self.point(e), self.point(e ^ 1), self.point(f), self.point(f ^ 1));
        // Left of a way down is right in the plane. The inner ends decide, so that the test is at a shared height.
        let low = if eb.y >= fb.y { orient2d(ft, fb, eb) } else { -orient2d(et, eb, fb) };
        let high = if et.y <= ft.y { orient2d(ft, fb, et) } else { -orient2d(et, eb, ft) };
        if low != 0.0 { low > 0.0 } else { high > 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_sort_counter_clockwise() {
        let p = Point2::new;
        let v = p(1.0, 1.0);
        let ring = [p(0., 0.), p(1., 0.), p(2., 0.), p(2., 1.), p(2., 2.), p(1., 2.), p(0., 2.), p(0., 1.)];
        for i in 0..8 {
            for j in 0..8 {
                assert_eq!(by_angle(v, ring[i], ring[j]), i.cmp(&j), "{i} {j}");
            }
        }
    }

    #[test]
    fn the_nearest_edge_wins_where_edges_share_a_node() {
        let p = Point2::new;
        // A square with a scar from its lower left corner: q sees the scar, not the side.
        let points = [p(0., 0.), p(4., 0.), p(4., 4.), p(0., 4.), p(1., 3.)];
        let g = Graph::new(&points, &[vec![0, 1, 2, 3]], &[vec![0, 4]]);
        let h = g.locate(&g.tree(), p(2.0, 1.0));
        assert_eq!(h.map(|h| (g.node(h), g.node(h ^ 1))), Some((4, 0)));
        let h = g.locate(&g.tree(), p(2.0, 3.5));
        assert_eq!(h.map(|h| (g.node(h), g.node(h ^ 1))), Some((3, 0)));
        assert_eq!(g.locate(&g.tree(), p(-1.0, 1.0)), None);
    }
}
