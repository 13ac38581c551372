//! Layer 1 of csalf: how large the quads shall be. The grading field g = Γ(x, y) of the paper (eq. 18) is a
//! [`SizeField`]; [`build()`] makes one from a [`SizeSpec`] and the loops of a domain.

pub mod background;
pub mod build;
pub mod cdt;
pub mod coarse;
pub mod count;
pub mod discretize;
pub mod error;
pub mod esg;
pub mod field;
pub mod fine;
pub mod gradation;
pub mod line;
pub mod sources;
pub mod spec;
#[cfg(test)]
mod test_loops;
mod triangulate;
pub mod uniform;

pub use background::Background;
pub use build::{Extras, build};
pub use coarse::{NearCoarse, near_coarse};
pub use count::expected_quads;
pub use discretize::{CurvatureLimit, DiscretizeOptions, discretize};
pub use error::SizeError;
pub use esg::extremum_size_gradient;
pub use field::{Hint, SizeField};
pub use fine::near_fine;
pub use gradation::graded;
pub use sources::Sources;
pub use spec::{SizeSpec, Source};
pub use triangulate::triangulate_loops;
pub use uniform::Uniform;
