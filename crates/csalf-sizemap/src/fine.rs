//! Smaller sizes beside segments that are short for the field: room for the quads to grow from them.
//!
//! ```text
//!     o─o─o─o─o─o─o─o─o    segments of length s, whose nodes are all given, in a field that wants h >> s there:
//!      ╲│ │╱│ ╲│ │╱│ │     without room needles would stand on them.
//!       o──o────o──o──o    h'(p) = min(h(p), s + g d),  d the distance from the segment
//! ```
//!
//! The part that is smaller is a background mesh ([`graded`]). Source: none; the counterpart of
//! [`NearCoarse`](crate::NearCoarse).

use crate::build::{DEFAULT_GRADATION, loop_indices, node_sizes};
use crate::{Background, Hint, SizeError, SizeField, graded};
use csalf_geom::Point2;
use std::sync::Arc;

/// The field counts as coarse at nodes whose segments are shorter than the wanted length by this factor. Smaller: more
/// quads than asked for beside boundaries that quads can follow; larger: needles.
const FINE: f64 = 2.5;

/// Growth of the wanted length per length beside such nodes, if none is given. 0.5 doubles it every two rows; of 1,200
/// random domains with nodes of any distance in fields of any size, the smallest scaled Jacobian is below 0.1 though
/// nothing forces it in 2.2 % without, 1.7 % at 1, 1.3 % at 0.5.
const GROWTH: f64 = 0.5;

/// A field, and a smaller one beside fine segments.
#[derive(Debug)]
struct NearFine {
    base: Arc<dyn SizeField>,
    fine: Background,
    range: (f64, f64),
}

/// `base`, lowered beside segments of the loops and of the scars that are short in it, from where it grows by `growth`
/// per length: by 0.5 if none is given, and by no less than 0.2, which is room enough. `base` itself if there are no
/// such segments. Cost O(n log n) where there are.
///
/// # Errors
/// [`SizeError`] of bad loops or a bad growth.
pub fn near_fine(
    base: Arc<dyn SizeField>,
    loops: &[Vec<Point2>],
    scars: &[Vec<Point2>],
    growth: Option<f64>,
) -> Result<Arc<dyn SizeField>, SizeError> {
    let mut hint = Hint::default();
    let points: Vec<Point2> = loops.iter().chain(scars).flatten().copied().collect();
    let segments =
        loops.iter().flat_map(|l| node_sizes(l)).chain(scars.iter().flat_map(|s| open_node_sizes(s)));
    let mut is_fine = false;
    let values: Vec<f64> = points
        .iter()
        .zip(segments)
        .map(|(&p, segment)| {
            let h = base.h(p, &mut hint);
            let fine = FINE * segment < h;
            is_fine |= fine;
            if fine { segment } else { h }
        })
        .collect();
    if !is_fine {
        return Ok(base);
    }
    // What is no growth is an error of `graded`.
    let growth = growth.map_or(GROWTH, |g| if g > 0.0 { g.max(DEFAULT_GRADATION) } else { g });
    let fine = graded(base.as_ref(), &points, &values, &loop_indices(loops), growth)?;
    let (low, high) = base.range();
    let range = (low.min(fine.range().0), high);
    Ok(Arc::new(NearFine { base, fine, range }))
}

/// The mean of the adjacent segments, per node of a polyline.
fn open_node_sizes(nodes: &[Point2]) -> Vec<f64> {
    let lengths: Vec<f64> = nodes.windows(2).map(|w| w[0].distance(w[1])).collect();
    let mean = |i: usize| {
        let beside = &lengths[i.saturating_sub(1)..(i + 1).min(lengths.len())];
        beside.iter().sum::<f64>() / beside.len() as f64
    };
    (0..nodes.len()).map(mean).collect()
}

impl SizeField for NearFine {
    fn h(&self, p: Point2, hint: &mut Hint) -> f64 {
        let h = self.base.h(p, hint);
        if p.is_finite() { h.min(hint.second(|hint| self.fine.h(p, hint))) } else { h }
    }

    fn range(&self) -> (f64, f64) {
        self.range
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Uniform, test_loops};

    /// Its lower side in `n` segments.
    fn square(n: usize) -> Vec<Point2> {
        test_loops::square(8.0, [n, 4, 4, 4])
    }

    #[test]
    fn sizes_grow_from_fine_segments_and_stay_elsewhere() {
        let base: Arc<dyn SizeField> = Arc::new(Uniform(2.0));
        let same = near_fine(Arc::clone(&base), &[square(8)], &[], None).unwrap();
        assert_eq!(same.constant(), Some(2.0));
        let field = near_fine(base, &[square(80)], &[], None).unwrap();
        let h = |x: f64, y: f64| field.h(Point2::new(x, y), &mut Hint::default());
        for (y, wanted) in [(0.0, 0.1), (0.5, 0.35), (1.0, 0.6), (2.0, 1.1), (5.0, 2.0), (8.0, 2.0)] {
            assert!((h(4.0, y) - wanted).abs() < 0.1 * wanted, "{y}: {} for {wanted}", h(4.0, y));
        }
        assert!((field.range().0 - 0.1).abs() < 1e-12 && field.range().1 == 2.0);
    }

    #[test]
    fn growth_may_be_given_and_scars_count() {
        let scar: Vec<Point2> = (0..=20).map(|i| Point2::new(3.0 + 0.1 * f64::from(i), 4.0)).collect();
        let field = near_fine(Arc::new(Uniform(2.0)), &[square(4)], &[scar], Some(0.2)).unwrap();
        let h = |x: f64, y: f64| field.h(Point2::new(x, y), &mut Hint::default());
        assert!((h(4.0, 4.0) - 0.1).abs() < 1e-12);
        assert!((h(4.0, 5.0) - 0.3).abs() < 0.03, "{}", h(4.0, 5.0));
        // 4.3 away from its end.
        assert!((h(0.0, 1.0) - 0.94).abs() < 0.1, "{}", h(0.0, 1.0));
        assert!(near_fine(Arc::new(Uniform(2.0)), &[square(80)], &[], Some(-1.0)).is_err());
    }
}
