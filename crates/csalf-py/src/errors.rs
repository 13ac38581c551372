//! Exceptions of `csalf._errors`, with the fields of the Rust errors.

use csalf_cli::exit::Failure;
use csalf_core::MeshError;
use csalf_geom::{Defect, Place};
use csalf_io::IoError;
use csalf_model::shard::ShardError;
use csalf_sizemap::SizeError;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// An instance of an exception class of the package, called with `args`.
fn raise<'py>(py: Python<'py>, class: &str, args: impl pyo3::call::PyCallArgs<'py>) -> PyErr {
    let made = py.import("csalf._errors").and_then(|m| m.getattr(class)).and_then(|c| c.call1(args));
    match made {
        Ok(value) => PyErr::from_value(value),
        Err(e) => e,
    }
}

/// A fault in what the caller passed.
pub(crate) fn value(message: impl Into<String>) -> PyErr {
    PyValueError::new_err(message.into())
}

/// The exception of a run that gave no mesh.
pub(crate) fn of_meshing(py: Python<'_>, error: &MeshError) -> PyErr {
    match error {
        MeshError::Invalid(defects) => of_defects(py, &error.to_string(), defects),
        MeshError::Size(e) => of_size(py, e),
        MeshError::Cancelled => raise(py, "Cancelled", ("the run was cancelled",)),
        MeshError::Internal { stage, detail } => {
            raise(py, "InternalError", (error.to_string(), *stage, detail.as_str()))
        }
        other => PyRuntimeError::new_err(other.to_string()),
    }
}

fn of_defects(py: Python<'_>, message: &str, defects: &[Defect]) -> PyErr {
    match defects.iter().map(|d| dict(py, d)).collect::<PyResult<Vec<_>>>() {
        Ok(list) => raise(py, "GeometryError", (message, list)),
        Err(e) => e,
    }
}

/// Faults of curves: words alone.
pub(crate) fn of_words(py: Python<'_>, words: &[String]) -> PyErr {
    let list = words.iter().map(|w| {
        let d = PyDict::new(py);
        d.set_item("kind", "Curve")?;
        d.set_item("message", w)?;
        d.set_item("places", PyList::empty(py))?;
        d.set_item("fields", PyDict::new(py))?;
        Ok(d)
    });
    match list.collect::<PyResult<Vec<_>>>() {
        Ok(list) => raise(py, "GeometryError", (words.join("; "), list)),
        Err(e) => e,
    }
}

/// The exception of wanted sizes.
pub(crate) fn of_size(py: Python<'_>, error: &SizeError) -> PyErr {
    let (what, index, value) = match error {
        SizeError::NotPositive { what, index, value } | SizeError::NotFinite { what, index, value } => {
            (*what, Some(*index), Some(*value))
        }
        SizeError::BadPoint { what, index } => (*what, Some(*index), None),
        SizeError::BadSource { index, what, value } => (*what, Some(*index), Some(*value)),
        SizeError::BadTriangle { triangle, .. } => ("triangle", Some(*triangle), None),
        SizeError::BadGradation(g) => ("gradation", None, Some(*g)),
        _ => ("background", None, None),
    };
    raise(py, "SizeError", (error.to_string(), what, index, value))
}

/// The exception of a file that is no model.
pub(crate) fn of_failure(py: Python<'_>, failure: &Failure, format: &str) -> PyErr {
    match failure {
        Failure::Usage(m) => value(m.as_str()),
        Failure::Files(m) => PyOSError::new_err(m.clone()),
        other => raise(py, "FormatError", (other.to_string(), format)),
    }
}

/// The exception of shards that do not go together.
pub(crate) fn of_shards(py: Python<'_>, errors: &[ShardError]) -> PyErr {
    let words: Vec<String> = errors.iter().map(ToString::to_string).collect();
    raise(py, "ShardError", (words.join("; "), words))
}

/// The exception of a file.
pub(crate) fn of_file(py: Python<'_>, error: &IoError) -> PyErr {
    use csalf_io::Place as At;
    let (format, place) = match error {
        IoError::Open { path, source } => {
            return match source.raw_os_error() {
                // With the number, Python picks FileNotFoundError and its like.
                Some(n) => PyOSError::new_err((n, source.to_string(), path.display().to_string())),
                None => PyOSError::new_err(error.to_string()),
            };
        }
        IoError::Write(e) => return PyOSError::new_err(e.to_string()),
        IoError::Syntax { format, place, .. } | IoError::Unsupported { format, place, .. } => {
            (*format, place.clone())
        }
        IoError::Empty { format, .. } => (*format, At::Whole),
        _ => ("", At::Whole),
    };
    let (line, byte, path) = match place {
        At::Line(n) => (Some(n), None, None),
        At::Byte(n) => (None, Some(n), None),
        At::Path(p) => (None, None, Some(p)),
        At::Whole => (None, None, None),
    };
    raise(py, "FormatError", (error.to_string(), format, line, byte, path))
}

/// Kind, message, places and all other fields of a defect.
fn dict<'py>(py: Python<'py>, defect: &Defect) -> PyResult<Bound<'py, PyDict>> {
    let fields = PyDict::new(py);
    let mut places: Vec<(&str, &Place)> = Vec::new();
    match defect {
        Defect::TooFewNodes { loop_name, n_nodes } => {
            fields.set_item("loop_name", loop_name)?;
            fields.set_item("n_nodes", n_nodes)?;
        }
        Defect::ScarTooShort { scar_name, n_nodes } => {
            fields.set_item("scar_name", scar_name)?;
            fields.set_item("n_nodes", n_nodes)?;
        }
        Defect::NotFinite { at } | Defect::Scale { at } | Defect::Outside { at } => places.push(("at", at)),
        Defect::NoOuterLoop => {}
        Defect::SeveralOuterLoops { names } => fields.set_item("names", names)?,
        Defect::RepeatedNode { first, second }
        | Defect::CoincidentNodes { first, second }
        | Defect::Overlap { first, second } => places.extend([("first", first), ("second", second)]),
        Defect::SelfIntersection { first, second, x, y } | Defect::Crossing { first, second, x, y } => {
            places.extend([("first", first), ("second", second)]);
            fields.set_item("x", x)?;
            fields.set_item("y", y)?;
        }
        Defect::Touching { node, segment } => places.extend([("node", node), ("segment", segment)]),
        Defect::ZeroArea { name } => fields.set_item("name", name)?,
        Defect::HoleAroundOuter { hole, outer } => {
            fields.set_item("hole", hole)?;
            fields.set_item("outer", outer)?;
        }
        Defect::HoleInHole { inner, outer } => {
            places.push(("inner", inner));
            fields.set_item("outer", outer)?;
        }
        Defect::PointOnSegment { point, segment } => {
            places.extend([("point", point), ("segment", segment)]);
        }
        Defect::BadSize { at, size } => {
            places.push(("at", at));
            fields.set_item("size", size)?;
        }
        Defect::OddTotal { n_segments, loops } => {
            fields.set_item("n_segments", n_segments)?;
            fields.set_item("loops", loops)?;
        }
        Defect::OddRegion { n_segments, x, y, cure } => {
            fields.set_item("n_segments", n_segments)?;
            fields.set_item("x", x)?;
            fields.set_item("y", y)?;
            places.extend(cure.iter().map(|p| ("cure", p)));
        }
        Defect::More { listed } => fields.set_item("listed", listed)?,
        _ => {}
    }
    let out = PyDict::new(py);
    let debug = format!("{defect:?}");
    let end = debug.find(|c: char| !c.is_alphanumeric()).unwrap_or(debug.len());
    out.set_item("kind", &debug[..end])?;
    out.set_item("message", defect.to_string())?;
    out.set_item("fields", fields)?;
    let list: Vec<_> = places.iter().map(|(role, p)| (*role, p.name.as_str(), p.index, p.x, p.y)).collect();
    out.set_item("places", list)?;
    Ok(out)
}
