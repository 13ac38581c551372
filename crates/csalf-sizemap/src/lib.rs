//! Layer 1 of csalf: how large the quads shall be. The grading field g = Γ(x, y) of the paper (eq. 18) is a
//! [`SizeField`]; [`uniform::Uniform`] is the simplest one.

pub mod field;
pub mod line;
pub mod spec;
pub mod uniform;

pub use field::{Hint, SizeField};
pub use spec::{SizeSpec, Source};
pub use uniform::Uniform;
