//! Layer 3 of csalf: recursive subdivision of contours (TriQuaMesh, the paper's Algorithm III).

pub mod bridge;
pub mod functional;
