//! Layer 2 of csalf: the shared nouns (meshes, contours, patches), their quality, and the seam behind which the
//! meshers stand.
//!
//! - [`QuadMesh`]: points and quads, structure of arrays, nothing derived.
//! - [`SurfaceMesh`]: the same in space.
//! - [`QuadTopology`]: twins, vertex stars and boundary of a mesh, built from it; knows no coordinates.
//! - [`quality`] and [`validate()`]: how good a mesh is, and whether it is what was asked for.
//! - [`RegionMesher`]: the seam. A mesher sees a [`RegionTask`] (a contour as a ring of points) and returns a
//!   [`Patch`] in names local to it; it never sees a mesh.

pub mod digest;
pub mod mesher;
pub mod quad_mesh;
pub mod quality;
pub mod surface_mesh;
pub mod sweep;
pub mod topology;
pub mod validate;

pub use digest::digest;
pub use mesher::{Appraisal, Contour, NodeFlags, Patch, Recipe, Refusal, RegionMesher, RegionTask};
pub use quad_mesh::{NamedSets, QuadMesh};
pub use quality::QualityReport;
pub use surface_mesh::SurfaceMesh;
pub use sweep::{HexMesh, SweepError, sweep};
pub use topology::QuadTopology;
pub use validate::{Expectation, MeshDefect, certify, is_strictly_convex, validate};
