//! Layer 3 of csalf: finishes a contour in one step, by transfinite interpolation of one block or of an
//! N-sided pattern of blocks with as few irregular vertices as possible. See [`Transfinite`].

pub mod coons;
pub mod corners;
pub mod fill;
mod local_size;
pub mod pattern;
pub mod plan;
pub mod quality;
pub mod relax;
pub mod rules;
pub mod table;
pub mod transfinite;

pub use plan::Plan;
pub use rules::{TfiMode, TfiRules};
pub use transfinite::Transfinite;
