//! Hard points that are allowed but so near a segment that the quads between will be poor.

use super::Checker;
use crate::boxtree::{Aabb, BoxTree};
use crate::defect::{Notice, Place};

/// A hard point nearer to a segment than this share of its length is worth a notice. Larger: more notices; smaller:
/// poor quads without one. (Handbook 12.3, row 19.)
const CLOSE: f64 = 0.3;

impl Checker<'_> {
    /// One notice per hard point of its own that is close to a segment: the one to which it is closest, in units of
    /// the segment's length. `hard_points`: node of each, in the order of the domain.
    pub(super) fn notices(&self, hard_points: &[u32]) -> Vec<Notice> {
        if hard_points.is_empty() {
            return Vec::new();
        }
        let ends = |s: usize| self.segments[s].map(|i| self.slots[i as usize]);
        let boxes = (0..self.segments.len()).map(|s| {
            let [a, b] = ends(s);
            Aabb::of_segment(a, b, CLOSE * a.distance(b))
        });
        let tree = BoxTree::new(boxes);
        let n_curve_nodes = self.node_of.iter().max().map_or(0, |v| v + 1);
        let mut out = Vec::new();
        let own = self.domain.points.iter().zip(hard_points).filter(|(_, v)| **v >= n_curve_nodes);
        for (point, _) in own {
            let (q, mut best) = (point.xy, (CLOSE, usize::MAX));
            tree.window(Aabb::of_segment(q, q, 0.0), &mut |s| {
                let [a, b] = ends(s as usize);
                let d = b - a;
                let f = ((q - a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
                let share = a.lerp(b, f).distance(q) / d.length();
                // Of equally close ones the first.
                if share < best.0 || share == best.0 && (s as usize) < best.1 {
                    best = (share, s as usize);
                }
            });
            if let (share, Some(&[i, _])) = (best.0, self.segments.get(best.1)) {
                let point = Place { name: point.name.clone(), index: 0, x: q.x, y: q.y };
                out.push(Notice::ClosePoint { point, segment: self.place(i as usize), share });
            }
        }
        out
    }
}
