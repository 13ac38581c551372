//! Numpy arrays on memory of Rust, without a copy.
//!
//! ```text
//!   Mesh (Python object, immutable) ──owns──▶ Vec<Point2>, Vec<[VertexId; 4]>
//!      ▲                                            ▲
//!      └──base── numpy array, read-only ────data────┘
//! ```
#![allow(unsafe_code, reason = "the one place where memory of Rust is shown to Python")]

use csalf_geom::{Point2, VertexId};
use glam::DVec3;
use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

const _: () =
    assert!(size_of::<Point2>() == 2 * size_of::<f64>() && align_of::<Point2>() == align_of::<f64>());
const _: () = assert!(size_of::<DVec3>() == 3 * size_of::<f64>() && align_of::<DVec3>() == align_of::<f64>());
const _: () =
    assert!(size_of::<VertexId>() == size_of::<u32>() && align_of::<VertexId>() == align_of::<u32>());

/// Points as rows of two numbers.
pub(crate) fn coordinates(points: &[Point2]) -> &[[f64; 2]] {
    // SAFETY: `DVec2` is `repr(C)` with the fields x and y; size and alignment are asserted above.
    unsafe { std::slice::from_raw_parts(points.as_ptr().cast(), points.len()) }
}

/// Points in space as rows of three numbers.
pub(crate) fn places(points: &[DVec3]) -> &[[f64; 3]] {
    // SAFETY: `DVec3` is `repr(C)` with the fields x, y and z; size and alignment are asserted above.
    unsafe { std::slice::from_raw_parts(points.as_ptr().cast(), points.len()) }
}

/// Elements as rows of vertex numbers.
pub(crate) fn indices<const K: usize>(elements: &[[VertexId; K]]) -> &[[u32; K]] {
    // SAFETY: `VertexId` is `repr(transparent)` over `u32`, so arrays of it are arrays of `u32`.
    unsafe { std::slice::from_raw_parts(elements.as_ptr().cast(), elements.len()) }
}

/// A read-only array of shape (n, K) on `rows`, which must be memory of `owner`: it is kept alive as long as the array
/// is.
///
/// # Safety
/// `rows` must lie in memory that `owner` neither changes nor frees before it is dropped.
///
/// # Errors
/// What numpy says.
pub(crate) unsafe fn borrowed<'py, T: Element, const K: usize>(
    rows: &[[T; K]],
    owner: Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let view = ArrayView2::from(rows);
    // SAFETY: by the contract of this function.
    let array = unsafe { PyArray2::borrow_from_array(&view, owner) };
    // Rust reads this memory: nobody may write to it.
    array.readwrite().make_nonwriteable();
    Ok(array)
}
