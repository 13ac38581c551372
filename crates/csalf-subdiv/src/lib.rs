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
