//! Layer 5 of csalf: one face in space. [`mesh_face`] takes a triangulated patch whose boundary is already
//! discretised, flattens it, meshes it by the planar mesher, and brings the mesh back onto the patch.
//!
//! ```text
//!   Facets, loops ─flatten─▶ charts in the plane ─csalf_core::mesh─▶ quads in the plane
//!                             │ plane: exact                               │ locate, project
//!                             │ no curvature: unrolled                     ▼
//!                             │ else: conformal, cut where needed    quads in space ─smooth─▶ FaceMesh
//! ```
//!
//! Conventions: triangles and quads run counter-clockwise seen from the side that the normals point to;
//! lengths are in model units. The boundary nodes come first in the mesh, in the order given, and keep their
//! bytes. Source: handbook 9.

mod curved;
mod cut;
mod error;
mod face;
mod flatten;
mod heal;
mod input;
mod locate;
mod patch;
mod piece;
mod plane;
mod quality;
mod report;
mod seams;
mod sheet;
mod sizes;
mod smooth;

pub use csalf_pave::{LayerLaw, LayerSpec};
pub use error::FaceError;
pub use face::mesh_face;
pub use glam::DVec3;
pub use input::{FaceInput, FaceLoop, FaceSize, Facets, Projector, SurfacePoint};
pub use report::{FaceMesh, FaceReport, Flattening, LayerRing, Quality3d};
