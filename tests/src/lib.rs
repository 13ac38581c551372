//! Test kit of csalf: everything that tests, `cargo xtask stress`, `reduce` and `regress` share.
//!
//! - [`baseline`]: the figures of a mesh that regressions are told by.
//! - [`bound`]: how good the worst quad can be at all, given the boundary.
//! - [`fixtures`]: our own cases, by code.
//! - [`generate`]: random valid jobs from a seed; the same seed gives the same job for good.
//! - [`check`]: an independent judge of meshes, which reads nothing but the job and the mesh.
//! - [`mod@run`]: meshes a job, catches panics, judges the outcome, names what went wrong.
//! - [`reduce`]: shrinks a failing job while it fails in the same way.

pub mod baseline;
pub mod bound;
pub mod check;
pub mod fixtures;
pub mod generate;
pub mod reduce;
pub mod rng;
pub mod run;

pub use generate::{Recipe, job};
pub use rng::Rng;
pub use run::{Failure, Outcome, Run, run};
