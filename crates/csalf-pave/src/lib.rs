//! Layer 3 of csalf: loop-paving, the structured rings of quads around boundary loops.

pub mod spec;

pub use spec::{LayerLaw, LayerSpec};
