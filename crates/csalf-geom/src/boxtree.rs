//! A static tree of bounding boxes: all pairs that may meet, all boxes near a place, the nearest to the left.
//!
//! ```text
//!            [0 1 2 3 4 5 6 7]            items are sorted so that every node of the tree is a range,
//!            /               \            halved at the middle of its longer side
//!      [0 1 2 3]         [4 5 6 7]
//! ```
//!
//! Cost: O(n log n) to build; a query O(log n + found) for the inputs that occur, whatever the ratio of sizes.

use crate::Point2;

/// Items per leaf: larger, fewer nodes; smaller, fewer box tests. 4 measured no worse than 2 or 8.
const LEAF: usize = 4;

/// A closed axis-parallel box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aabb {
    pub(crate) lo: Point2,
    pub(crate) hi: Point2,
}

impl Aabb {
    /// The box of nothing.
    const EMPTY: Self = Self { lo: Point2::INFINITY, hi: Point2::NEG_INFINITY };

    /// The box of a segment, wider by `margin` on all sides.
    pub(crate) fn of_segment(a: Point2, b: Point2, margin: f64) -> Self {
        Self { lo: a.min(b) - margin, hi: a.max(b) + margin }
    }

    fn join(self, o: Self) -> Self {
        Self { lo: self.lo.min(o.lo), hi: self.hi.max(o.hi) }
    }

    #[inline]
    fn meets(&self, o: &Self) -> bool {
        self.lo.x <= o.hi.x && o.lo.x <= self.hi.x && self.lo.y <= o.hi.y && o.lo.y <= self.hi.y
    }
}

/// A node of the tree: its place in the heap and its range of items.
#[derive(Clone, Copy)]
struct Node {
    heap: usize,
    from: usize,
    to: usize,
}

impl Node {
    fn is_leaf(self) -> bool {
        self.to - self.from <= LEAF
    }
    fn children(self) -> [Self; 2] {
        let mid = self.from + (self.to - self.from) / 2;
        [
            Self { heap: 2 * self.heap, from: self.from, to: mid },
            Self { heap: 2 * self.heap + 1, from: mid, to: self.to },
        ]
    }
}

/// The tree.
#[derive(Debug)]
pub(crate) struct BoxTree {
    /// Items in tree order: box and number.
    items: Vec<(Aabb, u32)>,
    /// Boxes of the nodes, as a heap from 1.
    nodes: Vec<Aabb>,
}

impl BoxTree {
    /// A tree of boxes, numbered in the order given. All coordinates must be finite.
    pub(crate) fn new(boxes: impl IntoIterator<Item = Aabb>) -> Self {
        let items: Vec<_> = boxes.into_iter().zip(0u32..).collect();
        let size = 4 * items.len().div_ceil(LEAF).next_power_of_two();
        let mut tree = Self { items, nodes: vec![Aabb::EMPTY; size] };
        tree.build(tree.root());
        tree
    }

    fn root(&self) -> Node {
        Node { heap: 1, from: 0, to: self.items.len() }
    }

    fn build(&mut self, node: Node) {
        let items = &mut self.items[node.from..node.to];
        let all = items.iter().fold(Aabb::EMPTY, |b, i| b.join(i.0));
        self.nodes[node.heap] = all;
        if node.is_leaf() {
            return;
        }
        let size = all.hi - all.lo;
        let middle = items.len() / 2;
        let key = |b: &(Aabb, u32)| if size.x > size.y { b.0.lo.x + b.0.hi.x } else { b.0.lo.y + b.0.hi.y };
        items.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.1.cmp(&b.1)));
        let [l, r] = node.children();
        self.build(l);
        self.build(r);
    }

    /// Calls `found(i, j)` with i < j for all pairs of items whose boxes meet, until it says `false`.
    pub(crate) fn pairs(&self, found: &mut impl FnMut(u32, u32) -> bool) -> bool {
        self.pairs_in(self.root(), found)
    }

    fn pairs_in(&self, a: Node, found: &mut impl FnMut(u32, u32) -> bool) -> bool {
        if a.is_leaf() {
            return (a.from..a.to).all(|i| (i + 1..a.to).all(|j| self.pair(i, j, found)));
        }
        let [l, r] = a.children();
        self.pairs_in(l, found) && self.pairs_in(r, found) && self.pairs_across(l, r, found)
    }

    fn pairs_across(&self, a: Node, b: Node, found: &mut impl FnMut(u32, u32) -> bool) -> bool {
        if !self.nodes[a.heap].meets(&self.nodes[b.heap]) {
            return true;
        }
        match (a.is_leaf(), b.is_leaf()) {
            (true, true) => (a.from..a.to).all(|i| (b.from..b.to).all(|j| self.pair(i, j, found))),
            (false, leaf) if leaf || a.to - a.from >= b.to - b.from => {
                a.children().iter().all(|&c| self.pairs_across(c, b, found))
            }
            _ => b.children().iter().all(|&c| self.pairs_across(a, c, found)),
        }
    }

    #[inline]
    fn pair(&self, i: usize, j: usize, found: &mut impl FnMut(u32, u32) -> bool) -> bool {
        let ((p, i), (q, j)) = (self.items[i], self.items[j]);
        !p.meets(&q) || found(i.min(j), i.max(j))
    }

    /// Calls `found` for all items whose boxes meet `window`.
    pub(crate) fn window(&self, window: Aabb, found: &mut impl FnMut(u32)) {
        let mut stack = vec![self.root()];
        while let Some(node) = stack.pop() {
            if !self.nodes[node.heap].meets(&window) {
                continue;
            }
            if node.is_leaf() {
                for (b, i) in &self.items[node.from..node.to] {
                    if b.meets(&window) {
                        found(*i);
                    }
                }
            } else {
                let [l, r] = node.children();
                stack.extend([r, l]);
            }
        }
    }

    /// Calls `found` for items whose boxes meet the ray from `q` to the left, the right ones roughly first. `found`
    /// returns an abscissa; items wholly left of it are not of interest any more.
    pub(crate) fn ray_left(&self, q: Point2, found: &mut impl FnMut(u32) -> f64) {
        let ray = Aabb { lo: Point2::new(f64::NEG_INFINITY, q.y), hi: q };
        let mut limit = f64::NEG_INFINITY;
        let mut stack = vec![self.root()];
        while let Some(node) = stack.pop() {
            let b = &self.nodes[node.heap];
            if !b.meets(&ray) || b.hi.x < limit {
                continue;
            }
            if node.is_leaf() {
                for (b, i) in &self.items[node.from..node.to] {
                    if b.meets(&ray) && b.hi.x >= limit {
                        limit = limit.max(found(*i));
                    }
                }
            } else {
                let [l, r] = node.children();
                // The last pushed is looked at first.
                let l_first = self.nodes[l.heap].hi.x > self.nodes[r.heap].hi.x;
                stack.extend(if l_first { [r, l] } else { [l, r] });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes at pseudo-random places, of sizes over four decades.
    fn boxes(n: usize) -> Vec<Aabb> {
        let mut s = 12345u64;
        let mut next = || {
            s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (s >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..n)
            .map(|_| {
                let a = Point2::new(next(), next());
                let d = Point2::new(next() - 0.5, next() - 0.5) * 10f64.powf(-4.0 * next());
                Aabb::of_segment(a, a + d, 0.0)
            })
            .collect()
    }

    #[test]
    fn finds_the_pairs_and_windows_of_brute_force() {
        for n in [0, 1, 2, 4, 5, 9, 300] {
            let b = boxes(n);
            let tree = BoxTree::new(b.iter().copied());
            let mut got = Vec::new();
            tree.pairs(&mut |i, j| {
                got.push((i, j));
                true
            });
            got.sort_unstable();
            let mut want = Vec::new();
            for i in 0..n {
                for j in i + 1..n {
                    if b[i].meets(&b[j]) {
                        want.push((i as u32, j as u32));
                    }
                }
            }
            assert_eq!(got, want);
            let w = Aabb::of_segment(Point2::new(0.2, 0.3), Point2::new(0.4, 0.5), 0.01);
            let mut got = Vec::new();
            tree.window(w, &mut |i| got.push(i));
            got.sort_unstable();
            let want: Vec<u32> = (0..n as u32).filter(|&i| b[i as usize].meets(&w)).collect();
            assert_eq!(got, want);
        }
    }

    #[test]
    fn the_search_for_pairs_can_be_stopped() {
        let tree = BoxTree::new(vec![Aabb { lo: Point2::ZERO, hi: Point2::ONE }; 50]);
        let mut n = 0;
        tree.pairs(&mut |_, _| {
            n += 1;
            n < 7
        });
        assert_eq!(n, 7);
    }

    #[test]
    fn the_ray_meets_the_nearest() {
        let b = boxes(300);
        let tree = BoxTree::new(b.iter().copied());
        let q = Point2::new(0.9, 0.5);
        let mut got = f64::NEG_INFINITY;
        tree.ray_left(q, &mut |i| {
            let x = b[i as usize].lo.x;
            if x <= q.x {
                got = got.max(x);
            }
            got
        });
        let hit = |b: &&Aabb| b.lo.y <= q.y && q.y <= b.hi.y && b.lo.x <= q.x;
        let want = b.iter().filter(hit).map(|b| b.lo.x).fold(f64::NEG_INFINITY, f64::max);
        assert_eq!(got, want);
        assert!(want.is_finite());
    }
}
