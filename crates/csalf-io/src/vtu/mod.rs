//! VTK XML unstructured grids (`.vtu`), as ParaView, VTK and meshio read them.

mod read;
mod write;

pub use read::read;
pub use write::{VtuEncoding, write, write_as};

/// Name of the format in errors.
pub(crate) const FORMAT: &str = "VTU";
/// VTK's number of a triangle.
pub(crate) const VTK_TRIANGLE: u8 = 5;
/// VTK's number of a quad.
pub(crate) const VTK_QUAD: u8 = 9;
