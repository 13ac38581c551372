//! The compiled half of the Python package `csalf`. It holds no decisions: arrays in, the pipeline, arrays out. What
//! a person sees is in `python/csalf`.
//!
//! | module | what |
//! |---|---|
//! | [`job`] | a job made call by call, or read from a file |
//! | [`curves`] | raw curves and their discretisation |
//! | [`run`] | meshing on a thread of its own, so that signals and progress reach Python |
//! | [`mesh`] | the finished mesh; its arrays are the memory of Rust |
//! | [`model`], [`model_mesh`] | whole models, in one piece or in shards; their meshes |
//! | [`share`] | the only unsafe code: numpy arrays on memory of Rust |
//! | [`errors`] | exceptions with the fields of the Rust errors |

mod curves;
mod errors;
mod job;
mod mesh;
mod model;
mod model_mesh;
mod run;
mod share;

use pyo3::prelude::*;

/// The module `csalf._csalf`.
#[pymodule]
fn _csalf(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add_class::<job::Job>()?;
    m.add_class::<curves::Curve>()?;
    m.add_class::<mesh::Mesh>()?;
    m.add_class::<model::Model>()?;
    m.add_class::<model::Plan>()?;
    m.add_class::<model_mesh::ModelMesh>()?;
    m.add_function(wrap_pyfunction!(job::read_jobs, m)?)?;
    m.add_function(wrap_pyfunction!(job::triangles, m)?)?;
    m.add_function(wrap_pyfunction!(curves::discretise, m)?)?;
    m.add_function(wrap_pyfunction!(run::mesh, m)?)?;
    m.add_function(wrap_pyfunction!(model::stitch, m)?)?;
    m.add_function(wrap_pyfunction!(mesh::read, m)?)?;
    m.add_function(wrap_pyfunction!(mesh::formats, m)?)?;
    Ok(())
}
