//! Raw curves, and nodes on them.

use crate::errors;
use crate::job::{Job, points};
use csalf_cli::outlines::{self, Wish};
use csalf_geom::geometry::{CurveLoop, CurveScar, Edge};
use csalf_geom::{Geometry, LoopKind, Point2, Tolerance, curve};
use csalf_io::{Input, NamedGeometry};
use csalf_sizemap::{DiscretizeOptions, Extras, SizeSpec, build, discretize};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use std::sync::Arc;

/// One curve of finite length.
#[pyclass(module = "csalf._csalf", frozen, from_py_object)]
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    curve: curve::Curve,
}

impl From<curve::Curve> for Curve {
    fn from(curve: curve::Curve) -> Self {
        Self { curve }
    }
}

#[pymethods]
impl Curve {
    /// Straight segments through points.
    #[staticmethod]
    fn polyline(nodes: PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let p = points(&nodes)?;
        if p.len() < 2 {
            return Err(errors::value("a polyline needs at least two points"));
        }
        Ok(curve::Curve::Polyline(p).into())
    }

    /// An arc of an ellipse, angles in radians.
    #[staticmethod]
    fn arc(center: (f64, f64), radii: (f64, f64), rotation: f64, start: f64, sweep: f64) -> Self {
        let (center, radii) = (Point2::from(center), Point2::from(radii));
        curve::Curve::Arc { center, radii, rotation, start, sweep }.into()
    }

    /// A Bezier curve of degree 2 or 3.
    #[staticmethod]
    fn bezier(nodes: PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        match points(&nodes)?.as_slice() {
            &[a, b, c] => Ok(curve::Curve::Quadratic([a, b, c]).into()),
            &[a, b, c, d] => Ok(curve::Curve::Cubic([a, b, c, d]).into()),
            p => Err(errors::value(format!("a Bezier curve has 3 or 4 points, not {}", p.len()))),
        }
    }

    /// The cubic spline through points.
    #[staticmethod]
    fn spline(nodes: PyReadonlyArray2<'_, f64>, closed: bool) -> PyResult<Self> {
        let p = points(&nodes)?;
        Ok(curve::Curve::through(&p, closed).map_err(|e| errors::value(e.to_string()))?.into())
    }

    /// First and last point.
    fn ends(&self) -> ((f64, f64), (f64, f64)) {
        (self.curve.start().into(), self.curve.end().into())
    }

    /// The point at share `t` (0 to 1) of the parameter.
    fn at(&self, t: f64) -> (f64, f64) {
        let (a, b) = self.curve.range();
        self.curve.eval(a + t * (b - a)).point.into()
    }
}

/// Places nodes on curves, as far apart as the size of `like` says; its points are taken over.
#[pyfunction]
pub(crate) fn discretise(
    py: Python<'_>,
    loops: Vec<(String, bool, Vec<Curve>)>,
    scars: Vec<(String, Vec<Curve>)>,
    like: &Job,
) -> PyResult<(Job, Vec<String>)> {
    let edges = |list: Vec<Curve>| list.into_iter().map(|c| Edge::from(c.curve)).collect();
    let kind = |hole: bool| if hole { LoopKind::Hole } else { LoopKind::Outer };
    let geometry = Geometry {
        loops: loops
            .into_iter()
            .map(|(name, hole, list)| CurveLoop { kind: kind(hole), name, edges: edges(list) })
            .collect(),
        scars: scars.into_iter().map(|(name, list)| CurveScar { name, edges: edges(list) }).collect(),
        points: like.job.domain.points.clone(),
    };
    let mut notes = Vec::new();
    if matches!(like.job.size, SizeSpec::Boundary) {
        // Nobody said how large: as the program chooses.
        let input = Input::Curves(vec![NamedGeometry { name: like.job.name.clone(), geometry }]);
        let mut made = outlines::jobs(input, "curves", Wish::default(), &mut notes);
        let made = made.swap_remove(0);
        let job = made.job.map_err(|words| errors::of_words(py, &words))?;
        return Ok((Job { job, geometry: made.geometry.map(Arc::new) }, notes));
    }
    let field = build(&like.job.size, &[], &Extras::default(), Tolerance::of_points([]))
        .map_err(|e| errors::of_size(py, &e))?;
    let domain = py
        .detach(|| discretize(&geometry, &*field, &DiscretizeOptions::default()))
        .map_err(|d| errors::of_words(py, &d.iter().map(ToString::to_string).collect::<Vec<_>>()))?;
    let job = csalf_core::Job { domain, name: like.job.name.clone(), ..csalf_core::Job::default() };
    Ok((Job { job, geometry: Some(Arc::new(geometry)) }, notes))
}
