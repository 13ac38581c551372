//! Pictures of meshes, as SVG and PNG: the same scene, drawn twice.
//!
//! - Fill: the scaled Jacobian, from orange (0) over yellow to green (1); red if it is not positive. Quads of a named
//!   set (layers) are blue instead of green, in two shades by turns; triangles grey.
//! - Dots: inner vertices with other than four quads. Thick lines: the boundary and edge sets.

mod png;
mod scene;
mod svg;
#[cfg(test)]
mod tests;

pub use png::write_png;
pub use svg::write_svg;

/// Name of the format in errors.
pub(crate) const FORMAT: &str = "picture";
