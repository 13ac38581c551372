//! Size conformity: do the edges have the lengths that the field asks for?

use super::edges::{HalfEdges, NONE};
use csalf_geom::Point2;
use csalf_sizemap::{Hint, SizeField};
use serde::Serialize;

/// Ratios that count as conforming (both ends belong to it).
pub const CONFORMING: (f64, f64) = (0.7, 1.4);

/// Least r in logarithms: edges of no length are caught by validity, here they only must not make infinities.
const SMALLEST: f64 = 1e-12;

/// Figures of r = length / h(midpoint) over the inner edges.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SizeConformity {
    /// Share of edges with r in [`CONFORMING`], 0 to 1.
    pub share: f64,
    /// Root mean square of ln r; 0 is perfect.
    pub rms_log: f64,
    /// Mean of ln r; positive: too coarse.
    pub mean_log: f64,
    /// Smallest r.
    pub min_ratio: f64,
    /// Largest r.
    pub max_ratio: f64,
}

/// Measures all inner edges (those of two elements) of `edges`; `None` if there are none. One size query per
/// edge.
pub(crate) fn conformity(
    points: &[Point2],
    edges: &HalfEdges,
    size: &dyn SizeField,
) -> Option<SizeConformity> {
    let mut hint = Hint::default();
    let (mut n, mut inside, mut sum, mut square) = (0usize, 0usize, 0.0, 0.0);
    let (mut lo, mut hi) = (f64::INFINITY, 0f64);
    for h in 0..edges.len() as u32 {
        let t = edges.twin[h as usize];
        if t >= NONE || t < h {
            continue;
        }
        let (a, b) = (points[edges.tail(h) as usize], points[edges.head(h) as usize]);
        let r = a.distance(b) / size.h(0.5 * (a + b), &mut hint);
        let l = r.max(SMALLEST).ln();
        n += 1;
        inside += usize::from(r >= CONFORMING.0 && r <= CONFORMING.1);
        sum += l;
        square += l * l;
        lo = lo.min(r);
        hi = hi.max(r);
    }
    let m = n as f64;
    (n > 0).then(|| SizeConformity {
        share: inside as f64 / m,
        rms_log: (square / m).sqrt(),
        mean_log: sum / m,
        min_ratio: lo,
        max_ratio: hi,
    })
}
