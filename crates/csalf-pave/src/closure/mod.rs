//! Loop closure as the paper has it: fronts are advanced one after the other, and stencils join the last to the
//! first (Table II). The cyclic formulation of [`crate::ring`] drives the mesher; this one is kept beside it, and a
//! property test shows that both make the same ring.
//!
//! ```text
//!           P"    Q"                 the march starts with the front at B (neighbours A, C) and ends with
//!     P      \   /                   the front at A (neighbours X, B). Primed letters belong to the first
//!     |       \ /                    front; P" is a stand-in for a node of A, Q" of a corner for its shared
//!  ---X---A----B---C---              node, until the closure replaces or merges them.
//! ```
//!
//! - [`Stencil`]: one cell of Table II: what is created, changed, withdrawn and merged.
//! - [`mod@march`]: the sequential advance, with the stencil at its end.
//!
//! Misprints of the tables, corrected here (handbook 2.5): right and right is XABC, not XYAC; right and reversal has
//! PXAR, not PBAR; flat and flat also has QPXA; reversal and flat changes R"P"AB once; a reversal or right reversal
//! before a right front merges P with R" as well; a front after a corner is not skipped but shares its first ray;
//! an acute front leaves AB and BC on the new loop.

pub mod march;
pub mod stencil;

pub use march::{Closed, march};
pub use stencil::{Name, Stencil, stencil};

#[cfg(test)]
mod draw;
#[cfg(test)]
mod tests;
