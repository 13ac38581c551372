//! One contour as the splitter sees it: flat arrays with one entry per occurrence, rebuilt in place for every
//! contour of a recursion.

use csalf_geom::{Point2, angle, cone::in_cone, predicates};
use csalf_mesh::NodeFlags;

/// All nodes of one recursion: those of the task's contour, then the split-line nodes as they are made.
#[derive(Debug, Default)]
pub(crate) struct Nodes {
    pub(crate) points: Vec<Point2>,
    pub(crate) sizes: Vec<f64>,
    pub(crate) flags: Vec<NodeFlags>,
}

impl Nodes {
    pub(crate) fn push(&mut self, p: Point2, size: f64, flags: NodeFlags) -> u32 {
        self.points.push(p);
        self.sizes.push(size);
        self.flags.push(flags);
        self.points.len() as u32 - 1
    }

    pub(crate) fn truncate(&mut self, n: usize) {
        self.points.truncate(n);
        self.sizes.truncate(n);
        self.flags.truncate(n);
    }
}

/// Geometry of the occurrences of one contour.
#[derive(Debug, Default)]
pub(crate) struct View {
    /// Node of each occurrence.
    pub(crate) node: Vec<u32>,
    pub(crate) point: Vec<Point2>,
    pub(crate) size: Vec<f64>,
    /// Direction of the outgoing segment, as an angle.
    pub(crate) heading: Vec<f64>,
    /// Interior angle.
    pub(crate) theta: Vec<f64>,
    /// Quads wanted here: round(theta / 90°), 1 to 4.
    pub(crate) wanted: Vec<u8>,
    /// `turns[i]` = sum over occurrences before i of (2 - wanted).
    turns: Vec<i32>,
    pub(crate) low: Point2,
    pub(crate) high: Point2,
}

impl View {
    pub(crate) fn load(&mut self, contour: &[u32], nodes: &Nodes) {
        let n = contour.len();
        self.node.clear();
        self.node.extend_from_slice(contour);
        self.point.clear();
        self.point.extend(contour.iter().map(|&v| nodes.points[v as usize]));
        self.size.clear();
        self.size.extend(contour.iter().map(|&v| nodes.sizes[v as usize]));
        self.heading.clear();
        self.theta.clear();
        self.wanted.clear();
        self.turns.clear();
        (self.low, self.high) = (self.point[0], self.point[0]);
        for i in 0..n {
            let d = self.point[if i + 1 == n { 0 } else { i + 1 }] - self.point[i];
            self.heading.push(d.y.atan2(d.x));
            self.low = self.low.min(self.point[i]);
            self.high = self.high.max(self.point[i]);
        }
        let mut sum = 0;
        for i in 0..n {
            let (p, q) = (if i == 0 { n - 1 } else { i - 1 }, if i + 1 == n { 0 } else { i + 1 });
            let tip = self.node[p] == self.node[q];
            let mut t = self.heading[p] + std::f64::consts::PI - self.heading[i];
            if t <= 0.0 {
                t += std::f64::consts::TAU;
            } else if t > std::f64::consts::TAU {
                t -= std::f64::consts::TAU;
            }
            let t = if tip { std::f64::consts::TAU } else { t };
            self.theta.push(t);
            let k = angle::wanted_quads(t);
            self.wanted.push(k);
            self.turns.push(sum);
            sum += 2 - k as i32;
        }
        self.turns.push(sum);
    }

    pub(crate) fn len(&self) -> usize {
        self.node.len()
    }
    pub(crate) fn prev(&self, i: usize) -> usize {
        if i == 0 { self.len() - 1 } else { i - 1 }
    }
    pub(crate) fn next(&self, i: usize) -> usize {
        if i + 1 == self.len() { 0 } else { i + 1 }
    }
    pub(crate) fn diagonal(&self) -> f64 {
        self.low.distance(self.high)
    }

    /// Topological charge δ = 4 - Σ(2 - k) of the contour (handbook 4.7).
    pub(crate) fn charge(&self) -> i32 {
        4 - self.turns[self.len()]
    }

    /// Charges of the two children of a split from `j` to `k` > `j` whose quads wanted at the four split angles
    /// are `ends` = (left at j, right at j, left at k, right at k).
    pub(crate) fn child_charges(&self, j: usize, k: usize, ends: [u8; 4]) -> (i32, i32) {
        let inner_left = self.turns[k] - self.turns[j + 1];
        let inner_right =
            self.turns[self.len()] - inner_left - (2 - self.wanted[j] as i32) - (2 - self.wanted[k] as i32);
        let left = 4 - inner_left - (2 - ends[0] as i32) - (2 - ends[2] as i32);
        let right = 4 - inner_right - (2 - ends[1] as i32) - (2 - ends[3] as i32);
        (left, right)
    }

    /// Exact: the direction from occurrence `j` to `q` points into the material.
    pub(crate) fn enters(&self, j: usize, q: Point2) -> bool {
        in_cone(self.point[self.prev(j)], self.point[j], self.point[self.next(j)], q)
    }

    /// Exact: the open segment between occurrences `j` and `k` meets contour segment `i` → `i + 1`. Segments that
    /// share a point with `j` or `k` count only if they run along the open segment.
    pub(crate) fn blocks(&self, i: usize, j: usize, k: usize) -> bool {
        let (a, b) = (self.point[j], self.point[k]);
        let (c, d) = (self.point[i], self.point[self.next(i)]);
        let at_end = |p: Point2| p == a || p == b;
        match (at_end(c), at_end(d)) {
            (false, false) => predicates::meeting(a, b, c, d) != predicates::Meeting::Apart,
            (true, true) => c != d, // the segment is the line itself, on another pair of occurrences
            (true, false) => self.along(a, b, c, d),
            (false, true) => self.along(a, b, d, c),
        }
    }

    /// Exact: the segment from `end` (which is `a` or `b`) to `p` runs along the open segment `ab`.
    fn along(&self, a: Point2, b: Point2, end: Point2, p: Point2) -> bool {
        let far = if end == a { b } else { a };
        predicates::orient2d(a, b, p) == 0.0 && (p - end).dot(far - end) > 0.0
    }
}
