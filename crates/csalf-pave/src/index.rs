//! Static index of segments: which of them come near a box.
//!
//! Segments are sorted along a Z-order curve of their middles and bounded by boxes in groups of eight, those again
//! in groups of eight, and so on. Building costs O(n log n), a query O(log n + hits) for evenly spread input; very
//! uneven input (an aerofoil in a large box) costs no more, because groups adapt to the density.

use csalf_geom::Point2;

/// A segment of some front. An isolated point is a segment of length 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    /// Start.
    pub(crate) a: Point2,
    /// End.
    pub(crate) b: Point2,
    /// The loop it belongs to.
    pub(crate) owner: u32,
    /// Position on that loop.
    pub(crate) at: u32,
    /// True of a ring that is proposed, false of a front that stands.
    pub(crate) proposed: bool,
}

type Bounds = [f64; 4];

const GROUP: usize = 8;
const NOTHING: Bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];

#[derive(Debug, Default)]
pub(crate) struct Index {
    segments: Vec<Segment>,
    /// Boxes of all levels, finest first.
    boxes: Vec<Bounds>,
    /// Start of each level in `boxes`.
    levels: Vec<usize>,
}

fn join(a: Bounds, b: Bounds) -> Bounds {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3]
}

/// Spreads the lower 16 bits to every second bit.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x & 0xffff);
    x = (x | x << 8) & 0x00ff_00ff;
    x = (x | x << 4) & 0x0f0f_0f0f;
    x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}

impl Index {
    pub(crate) fn new(input: &[Segment]) -> Self {
        let (mut lo, mut hi) = (Point2::INFINITY, Point2::NEG_INFINITY);
        for s in input {
            lo = lo.min(s.a).min(s.b);
            hi = hi.max(s.a).max(s.b);
        }
        let size = (hi - lo).max_element();
        let scale = if size > 0.0 { 65535.0 / size } else { 0.0 };
        let mut order: Vec<u64> = input
            .iter()
            .enumerate()
            .map(|(i, s)| {
                let m = ((s.a + s.b) * 0.5 - lo) * scale;
                (spread(m.x as u32) | spread(m.y as u32) << 1) << 32 | i as u64
            })
            .collect();
        order.sort_unstable();
        let segments: Vec<Segment> = order.iter().map(|&k| input[(k & 0xffff_ffff) as usize]).collect();
        let of = |s: &Segment| [s.a.x.min(s.b.x), s.a.y.min(s.b.y), s.a.x.max(s.b.x), s.a.y.max(s.b.y)];
        let mut boxes: Vec<Bounds> =
            segments.chunks(GROUP).map(|c| c.iter().map(of).fold(NOTHING, join)).collect();
        let mut levels = vec![0];
        let mut from = 0;
        while boxes.len() - from > 1 {
            let to = boxes.len();
            levels.push(to);
            let mut at = from;
            while at < to {
                let group = boxes[at..to.min(at + GROUP)].iter().copied().fold(NOTHING, join);
                boxes.push(group);
                at += GROUP;
            }
            from = to;
        }
        Self { segments, boxes, levels }
    }

    /// Calls `hit` with every segment whose box meets the box from `lo` to `hi`, in a fixed order.
    pub(crate) fn query(&self, lo: Point2, hi: Point2, mut hit: impl FnMut(&Segment)) {
        if self.boxes.is_empty() {
            return;
        }
        let window = [lo.x, lo.y, hi.x, hi.y];
        let mut stack = [(0u32, 0u32); 8 * 12];
        stack[0] = (self.levels.len() as u32 - 1, 0);
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let (level, at) = (stack[top].0 as usize, stack[top].1 as usize);
            if !overlap(&self.boxes[self.levels[level] + at], &window) {
                continue;
            }
            if level == 0 {
                for s in &self.segments[at * GROUP..self.segments.len().min((at + 1) * GROUP)] {
                    let b = [s.a.x.min(s.b.x), s.a.y.min(s.b.y), s.a.x.max(s.b.x), s.a.y.max(s.b.y)];
                    if overlap(&b, &window) {
                        hit(s);
                    }
                }
            } else {
                let n_below = self.levels[level] - self.levels[level - 1];
                // 2^32 segments make 11 levels: the stack never holds more than 8 entries for each.
                for k in (at * GROUP..n_below.min((at + 1) * GROUP)).rev() {
                    stack[top] = (level as u32 - 1, k as u32);
                    top += 1;
                }
            }
        }
    }
}

/// Distance from `p` to the segment `ab`.
pub(crate) fn distance(p: Point2, a: Point2, b: Point2) -> f64 {
    let d = b - a;
    let l2 = d.length_squared();
    let t = if l2 > 0.0 { ((p - a).dot(d) / l2).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + d * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_find_what_a_scan_finds() {
        // A spiral whose segments shrink by a factor of a thousand.
        let p = |i: u32| {
            let t = f64::from(i) * 0.05;
            Point2::from_angle(t) * (-0.1 * t).exp() * 10.0
        };
        let all: Vec<Segment> =
            (0..1000).map(|i| Segment { a: p(i), b: p(i + 1), owner: 0, at: i, proposed: false }).collect();
        let index = Index::new(&all);
        for i in (0..1000).step_by(7) {
            let c = p(i);
            let r = 0.3 * c.length();
            let (lo, hi) = (c - r, c + r);
            let mut got = Vec::new();
            index.query(lo, hi, |s| got.push(s.at));
            got.sort_unstable();
            let want: Vec<u32> = all
                .iter()
                .filter(|s| s.a.min(s.b).cmple(hi).all() && s.a.max(s.b).cmpge(lo).all())
                .map(|s| s.at)
                .collect();
            assert_eq!(got, want);
        }
        Index::new(&[]).query(Point2::ZERO, Point2::ONE, |_| panic!("nothing is there"));
    }
}
