//! Pictures of meshes, as SVG and PNG: the same scene, drawn twice.
//!
//! - Fill: the scaled Jacobian, from orange (0) over yellow to green (1); red if it is not positive. Quads of a named
//!   set (layers) are blue instead of green, in two shades by turns; triangles grey.
//! - Dots: inner vertices with other than four quads. Thick lines: the boundary and edge sets.
//!
//! A mesh in space is seen from the front, the right and above, far elements drawn first, darker where they are turned
//! away from the light; without dots.

mod layout;
mod png;
mod scene;
mod space;
mod svg;
#[cfg(test)]
mod tests;

pub use png::{write_png, write_png_by};
pub use svg::{write_svg, write_svg_by};

/// Values that the colours show in place of the scaled Jacobian.
#[derive(Clone, Copy, Debug)]
pub struct Shade<'a> {
    /// One per element: quads first, then triangles; NaN is grey.
    pub values: &'a [f64],
    /// The values that get the colour of the worst and of the best; what lies beyond gets the same.
    pub limits: [f64; 2],
}

/// Name of the format in errors.
pub(crate) const FORMAT: &str = "picture";
