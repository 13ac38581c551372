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
/// VTK's number of a triangle of six nodes.
pub(crate) const VTK_QUADRATIC_TRIANGLE: u8 = 22;
/// VTK's number of a quad of eight nodes.
pub(crate) const VTK_QUADRATIC_QUAD: u8 = 23;
/// VTK's number of a quad of nine nodes.
pub(crate) const VTK_BIQUADRATIC_QUAD: u8 = 28;
