//! Gmsh meshes (`.msh`), versions 2.2 and 4.1: read in text and binary, written in text. Written from the format's
//! published description.
//!
//! Named sets are physical groups: node sets of dimension 0, edge sets of dimension 1, quad sets of dimension 2.

mod outline;
mod read;
mod write;

pub use outline::read_job;
pub use read::read;
pub use write::{write_22, write_22_with, write_41, write_41_with};

/// Name of the format in errors.
pub(crate) const FORMAT: &str = "Gmsh";
/// Name of the physical group that holds all elements.
pub(crate) const ALL: &str = "domain";
