//! Layer 6 of csalf: whole models. [`mesh_model`] takes a [`Model`] (a boundary representation filled from a STEP file
//! or from facets) and returns one conforming quad mesh of all its faces.
//!
//! ```text
//!   Model ─check, sew─▶ Model ─plan─▶ nodes on edges ─each face─▶ chart, facets ─csalf_surface─▶ quads ─stitch─▶ mesh
//!   brep                brep          plan                        face                                    mesh
//! ```
//!
//! Every edge is discretised once, so that the faces beside it agree on its nodes. Faces are meshed in parallel; the
//! mesh is put together by the numbers of the nodes on edges, never by comparing coordinates. Source: handbook 9, 10.

pub mod brep;
mod face;
pub mod facets;
pub mod geometry;
mod mesh;
mod middles;
pub mod names;
pub mod plan;
mod report;
pub mod shapes;
pub mod shard;
mod stitch;

pub use brep::{Model, Sewn, check_and_snap, sew, sew_closed, turn_alike};
pub use csalf_surface::{LayerLaw, LayerSpec};
pub use mesh::{ModelOptions, NamedLoop, Prepared, mesh_model, named_loops};
pub use middles::Shapes;
pub use plan::SizeRules;
pub use report::{FaceFailure, LoopLayers, ModelMesh};
