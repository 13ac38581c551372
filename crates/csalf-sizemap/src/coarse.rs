//! Larger sizes beside boundary segments that are long for the field: room for the quads to grow to them.
//!
//! ```text
//!     o───────────────────o    a segment of length L, which no node may split, in a field that wants h << L there:
//!      ╲ │ │ │ │ │ │ │ │ ╱     without room L / h quads would end in a fan at its two nodes.
//!       o┼─┼─┼─┼─┼─┼─┼─┼o      h'(p) = max(h(p), min(b(p), 0.7 L - 0.4 d)),  d the distance from the segment,
//!        │ │ │ │ │ │ │ │                 b the field of the boundary nodes alone, so that finer nodes close by count
//! ```
//!
//! Only for fields that do not come from the boundary itself, or whose growth from it is bounded. Source: none; the numbers are from the closest templates
//! that take one quad to three (handbook 5.4), two rows of which need about the length of the long side.

use crate::build::of_boundary;
use crate::{Background, Hint, SizeError, SizeField};
use csalf_geom::Point2;
use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};
use std::sync::Arc;

/// Segments longer than this many times the wanted length count as coarse. Smaller: sizes are given up where the quads
/// can still follow; larger: fans of more quads.
const COARSE: f64 = 2.5;
/// Wanted length on a coarse segment, in parts of it.
const SHARE: f64 = 0.7;
/// How fast it falls with the distance. Larger: the wanted sizes are reached sooner, through worse quads.
const SLOPE: f64 = 0.4;

/// A field with room for coarse segments.
#[derive(Debug)]
pub struct NearCoarse<B> {
    base: B,
    boundary: Background,
    segments: RTree<GeomWithData<Rectangle<[f64; 2]>, [Point2; 2]>>,
    range: (f64, f64),
}

/// `base`, or a [`NearCoarse`] on it if a segment of the loops is coarse. O(n log n) where there is one.
///
/// # Errors
/// [`SizeError`] of bad loops.
pub fn near_coarse(base: Arc<dyn SizeField>, loops: &[Vec<Point2>]) -> Result<Arc<dyn SizeField>, SizeError> {
    Ok(match NearCoarse::new(Arc::clone(&base), loops)? {
        Some(field) => Arc::new(field),
        None => base,
    })
}

impl<B: SizeField> NearCoarse<B> {
    /// `None` if no segment of the loops is coarse in `base`. O(n log n).
    ///
    /// # Errors
    /// [`SizeError`] of bad loops.
    pub fn new(base: B, loops: &[Vec<Point2>]) -> Result<Option<Self>, SizeError> {
        let mut hint = Hint::default();
        let mut boxes = Vec::new();
        let (low, mut high) = base.range();
        for l in loops {
            for (i, &a) in l.iter().enumerate() {
                let b = l[(i + 1) % l.len()];
                let length = a.distance(b);
                // The smallest of a few samples: a fine spot may lie on a part of the segment.
                let h = [0.1, 0.5, 0.9]
                    .map(|t| base.h(a.lerp(b, t), &mut hint))
                    .into_iter()
                    .fold(f64::MAX, f64::min);
                if length > COARSE * h {
                    let reach = Point2::splat(SHARE / SLOPE * length);
                    let corners =
                        Rectangle::from_corners((a.min(b) - reach).to_array(), (a.max(b) + reach).to_array());
                    boxes.push(GeomWithData::new(corners, [a, b]));
                    high = high.max(SHARE * length);
                }
            }
        }
        if boxes.is_empty() {
            return Ok(None);
        }
        let boundary = of_boundary(loops)?;
        Ok(Some(Self { base, boundary, segments: RTree::bulk_load(boxes), range: (low, high) }))
    }
}

/// Distance from `p` to the segment from `a` to `b`.
fn distance(p: Point2, a: Point2, b: Point2) -> f64 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(b, t))
}

impl<B: SizeField> SizeField for NearCoarse<B> {
    fn h(&self, p: Point2, hint: &mut Hint) -> f64 {
        let h = self.base.h(p, hint);
        if !p.is_finite() {
            return h;
        }
        let room = |[a, b]: [Point2; 2]| SHARE * a.distance(b) - SLOPE * distance(p, a, b);
        let near = self.segments.locate_all_at_point(p.to_array());
        let wanted = near.fold(h, |most, s| most.max(room(s.data)));
        if wanted > h { h.max(wanted.min(hint.second(|hint| self.boundary.h(p, hint)))) } else { h }
    }

    fn range(&self) -> (f64, f64) {
        self.range
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Uniform, test_loops};

    fn square(n: usize) -> Vec<Point2> {
        test_loops::square(8.0, [n; 4])
    }

    #[test]
    fn there_is_room_beside_coarse_segments_and_nowhere_else() {
        let base: Arc<dyn SizeField> = Arc::new(Uniform(0.25));
        let same = near_coarse(Arc::clone(&base), &[square(16)]).unwrap();
        assert_eq!(same.constant(), Some(0.25));
        let field = near_coarse(base, &[square(4)]).unwrap();
        let h = |x: f64, y: f64| field.h(Point2::new(x, y), &mut Hint::default());
        assert!((h(3.0, 0.0) - 1.4).abs() < 1e-12);
        assert!((h(3.0, 1.0) - 1.0).abs() < 1e-12);
        assert_eq!(h(4.0, 4.0), 0.25);
    }

    #[test]
    fn fine_nodes_close_by_keep_their_size() {
        let hole = square(64).into_iter().rev().map(|p| p / 8.0 + Point2::new(3.5, 0.5)).collect::<Vec<_>>();
        let field = near_coarse(Arc::new(Uniform(0.02)), &[square(4), hole.clone()]).unwrap();
        assert!(field.h(hole[3], &mut Hint::default()) < 0.03);
    }
}
