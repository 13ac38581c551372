//! Layer 0 of csalf: points, typed indices, exact predicates, tolerances, contours and domains.
//!
//! Nothing in this crate knows of meshes. Conventions used by all of csalf:
//!
//! - Points are `f64`. A **loop** is a cyclic list of nodes v_0 .. v_{n-1}; segment i runs v_i → v_{i+1}.
//! - **Material lies on the left**: the outer loop is counter-clockwise, hole loops are clockwise.
//! - Interior angles are measured in the material, counter-clockwise from the outgoing to the incoming segment,
//!   in (0, 2π] ([`angle::interior_angle`]).
//! - Every decision on a *side* is made by [`predicates`]; a [`Tolerance`] may decide *merge*, never *side*.

pub mod angle;
pub mod arrangement;
mod boxtree;
mod check;
pub mod cone;
pub mod curve;
pub mod defect;
pub mod domain;
pub mod geometry;
mod graph;
pub mod ids;
mod parity;
pub mod polygon;
pub mod predicates;
pub mod tolerance;

pub use arrangement::{Arrangement, CheckOptions, Region};
pub use curve::Curve;
pub use defect::{Defect, Notice, Place};
pub use domain::{Domain, HardPoint, Loop, LoopKind, Scar};
pub use geometry::{CurveLoop, CurveScar, Edge, Geometry, GeometryDefect};
pub use ids::{QuadId, VertexId};
pub use tolerance::Tolerance;

/// A point or vector in the plane, in model units.
pub type Point2 = glam::DVec2;
