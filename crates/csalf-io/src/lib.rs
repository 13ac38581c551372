//! Readers and writers of csalf. Values in, values out: a reader takes bytes, a writer takes a sink; neither
//! knows of the mesher.
//!
//! | module | read | written |
//! |---|---|---|
//! | [`json`] | jobs (the program's own format) | jobs |
//! | [`vtu`] | | meshes |

pub mod error;
pub mod format;
pub mod input;
pub mod json;
pub mod mesh_data;
pub mod mesh_io;
pub mod vtu;

pub use error::{IoError, Place};
pub use format::{JobFormat, MeshFormat};
pub use input::{Input, JobInput, read_job, read_job_bytes};
pub use json::{JobDocument, JobOptions};
pub use mesh_data::{CellData, MeshData, MeshView};
pub use mesh_io::write_mesh;
