//! Layer 3 of csalf: recursive subdivision of contours (TriQuaMesh, the paper's Algorithm III).

pub mod bridge;
pub mod closure;
pub mod fallback;
pub mod functional;
mod grid;
pub mod recursion;
pub mod split;
mod view;

pub use bridge::{BridgeError, Bridged, Walks, bridge};
pub use fallback::{Fallback, FallbackError};
pub use recursion::{Subdivision, Tally};
pub use split::SplitRules;

/// A point as spade takes it: it refuses coordinates that are not zero but below 1e-43 or so. They are zero at any
/// scale that the mesher works at.
fn triangulable(p: csalf_geom::Point2) -> spade::Point2<f64> {
    let flush = |x: f64| if x.abs() < spade::MIN_ALLOWED_VALUE { 0.0 } else { x };
    spade::Point2::new(flush(p.x), flush(p.y))
}
