//! Readers and writers of csalf. Values in, values out: a reader takes bytes, a writer takes a sink; neither
//! knows of the mesher.
//!
//! | module | read | written |
//! |---|---|---|
//! | [`json`] | jobs (the program's own format) | jobs |
//! | [`geojson`], [`topojson`], [`poly`] | jobs | |
//! | [`dxf`], [`svg`] | outlines of curves | |
//! | [`msh`] | meshes, and jobs from line elements | meshes (4.1 and 2.2) |
//! | [`vtu`], [`inp`], [`bdf`], [`obj`] | meshes | meshes |
//! | [`exodus`], [`foam`], [`ism`], [`su2`], [`unv`], [`vtkhdf`] | | meshes |
//! | [`facets`] | triangles in space | |
//! | [`hex`] | | swept hexahedra |
//! | [`picture`] | | SVG and PNG pictures |
//!
//! [`outlines`] makes jobs that can be meshed of what a reader gives.
//!
//! [`read_job`], [`read_mesh`] and [`write_mesh`] choose by the name of a file or by a given format. No reader
//! panics, whatever it is given; errors say where in the file.

pub mod bdf;
mod builder;
mod curves;
pub mod dxf;
pub mod error;
pub mod exodus;
pub mod facets;
pub mod foam;
pub mod format;
pub mod geojson;
mod graph;
pub mod hex;
pub mod inp;
pub mod input;
pub mod ism;
pub mod json;
pub mod mesh_data;
pub mod mesh_io;
pub mod mid_nodes;
pub mod msh;
mod netcdf;
pub mod obj;
pub mod outlines;
pub mod picture;
pub mod poly;
mod rings;
mod sides;
pub mod su2;
pub mod svg;
mod text;
pub mod topojson;
pub mod unv;
pub mod vtkhdf;
pub mod vtu;

pub use error::{IoError, Place};
pub use format::{JobFormat, MeshFormat};
pub use input::{Input, JobInput, NamedGeometry, read_job, read_job_bytes};
pub use json::{JobDocument, JobOptions};
pub use mesh_data::{CellData, MeshData, MeshView};
pub use mesh_io::{WriteOptions, read_mesh, read_mesh_bytes, write_mesh, write_mesh_with};
pub use mid_nodes::MidNodes;
