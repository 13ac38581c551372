//! A meshing job, made call by call or read from a file.

use crate::errors;
use csalf_cli::layers::parse_law;
use csalf_cli::outlines::{self, Wish};
use csalf_geom::domain::HardPoint;
use csalf_geom::predicates::orient2d;
use csalf_geom::{Geometry, Loop, LoopKind, Point2, Scar};
use csalf_io::{JobFormat, json};
use csalf_pave::{LayerLaw, LayerSpec};
use csalf_sizemap::{Background, SizeSpec, Source};
use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Nodes, sizes and layers: what is to be meshed.
#[pyclass(module = "csalf._csalf")]
#[derive(Clone, Debug, Default)]
pub(crate) struct Job {
    pub(crate) job: csalf_core::Job,
    /// The curves that the nodes were placed on, for mid-side nodes. Not pickled.
    pub(crate) geometry: Option<Arc<Geometry>>,
}

/// Rows of two numbers as points.
pub(crate) fn points(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Point2>> {
    let a = array.as_array();
    if a.ncols() != 2 {
        return Err(errors::value(format!("expected an array of shape (n, 2), not {:?}", a.shape())));
    }
    Ok(a.rows().into_iter().map(|r| Point2::new(r[0], r[1])).collect())
}

/// Points as an array of its own.
pub(crate) fn array<'py>(py: Python<'py>, points: &[Point2]) -> Bound<'py, PyArray2<f64>> {
    numpy::ndarray::ArrayView2::from(crate::share::coordinates(points)).to_pyarray(py)
}

#[pymethods]
impl Job {
    #[new]
    fn new(name: String) -> Self {
        Self { job: csalf_core::Job { name, ..csalf_core::Job::default() }, geometry: None }
    }

    #[getter]
    fn name(&self) -> &str {
        &self.job.name
    }

    fn add_loop(&mut self, name: String, hole: bool, nodes: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let kind = if hole { LoopKind::Hole } else { LoopKind::Outer };
        self.job.domain.loops.push(Loop { kind, name, nodes: points(&nodes)? });
        Ok(())
    }

    fn add_scar(&mut self, name: String, nodes: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.job.domain.scars.push(Scar { name, nodes: points(&nodes)? });
        Ok(())
    }

    fn add_point(&mut self, name: String, x: f64, y: f64, size: Option<f64>) {
        self.job.domain.points.push(HardPoint { name, xy: Point2::new(x, y), size });
    }

    /// Thickness law as on the command line; `thicknesses` in place of it.
    fn add_layers(
        &mut self,
        pattern: String,
        count: usize,
        law: &str,
        thicknesses: Option<Vec<f64>>,
        first: Option<f64>,
    ) -> PyResult<()> {
        let law = match thicknesses {
            Some(t) => LayerLaw::Explicit(t),
            None => parse_law(law).map_err(errors::value)?,
        };
        self.job.layers.push((pattern, LayerSpec { count, law, first }));
        Ok(())
    }

    fn clear_layers(&mut self) {
        self.job.layers.clear();
    }

    fn set_local_region(&mut self, x: f64, y: f64, radius: f64) {
        self.job.local_region = Some([x, y, radius]);
    }

    fn size_uniform(&mut self, h: f64) {
        self.job.size = SizeSpec::Uniform { h };
    }

    /// Rows of `sources`: x, y, h, radius, falloff.
    fn size_sources(&mut self, far: f64, sources: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let a = sources.as_array();
        if a.ncols() != 5 {
            return Err(errors::value("a source has five numbers: x, y, h, radius, falloff"));
        }
        let row = |r: numpy::ndarray::ArrayView1<'_, f64>| Source {
            xy: Point2::new(r[0], r[1]),
            h: r[2],
            radius: r[3],
            falloff: r[4],
        };
        self.job.size = SizeSpec::Sources { far, sources: a.rows().into_iter().map(row).collect() };
        Ok(())
    }

    fn size_background(
        &mut self,
        nodes: PyReadonlyArray2<'_, f64>,
        triangles: PyReadonlyArray2<'_, u32>,
        values: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let t = triangles.as_array();
        if t.ncols() != 3 {
            return Err(errors::value("triangles need an array of shape (n, 3)"));
        }
        self.job.size = SizeSpec::Background {
            points: points(&nodes)?,
            triangles: t.rows().into_iter().map(|r| [r[0], r[1], r[2]]).collect(),
            values: values.as_array().to_vec(),
        };
        Ok(())
    }

    /// Smallest box around all loops: x0, y0, x1, y1; all zero without loops.
    fn bounds(&self) -> (f64, f64, f64, f64) {
        let nodes = self.job.domain.loops.iter().flat_map(|l| l.nodes.iter().copied());
        let (lo, hi) = csalf_geom::polygon::bounds(nodes).unwrap_or_default();
        (lo.x, lo.y, hi.x, hi.y)
    }

    /// All loops: name, is it a hole, nodes.
    fn loops<'py>(&self, py: Python<'py>) -> Vec<(String, bool, Bound<'py, PyArray2<f64>>)> {
        let one = |l: &Loop| (l.name.clone(), l.kind == LoopKind::Hole, array(py, &l.nodes));
        self.job.domain.loops.iter().map(one).collect()
    }

    /// All scars: name, nodes.
    fn scars<'py>(&self, py: Python<'py>) -> Vec<(String, Bound<'py, PyArray2<f64>>)> {
        self.job.domain.scars.iter().map(|s| (s.name.clone(), array(py, &s.nodes))).collect()
    }

    /// Patterns of layers that match no name.
    fn unmatched_layers(&self) -> Vec<String> {
        self.job.unmatched_layers().into_iter().map(str::to_owned).collect()
    }

    /// The job as a job file.
    fn to_json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mut bytes = Vec::new();
        json::write(&self.job, &csalf_io::JobOptions::default(), &mut bytes)
            .map_err(|e| errors::of_file(py, &e))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The job in a job file.
    #[staticmethod]
    fn from_json(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let document = json::read(bytes).map_err(|e| errors::of_file(py, &e))?;
        Ok(Self { job: document.job, geometry: None })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let bytes = slf.borrow().to_json(slf.py())?;
        Ok((slf.get_type().getattr("from_json")?, (bytes,)))
    }
}

/// The jobs in a file, and what was left out or chosen. Options of the file come as a dict.
#[pyfunction]
#[pyo3(signature = (path, size, resample, format))]
pub(crate) fn read_jobs(
    py: Python<'_>,
    path: PathBuf,
    size: Option<f64>,
    resample: bool,
    format: Option<&str>,
) -> PyResult<(Vec<Job>, Options, Vec<String>)> {
    let mut read = py.detach(|| read_file(&path, format)).map_err(|e| match e {
        Ok(io) => errors::of_file(py, &io),
        Err(words) => errors::value(words),
    })?;
    let stem = path.file_stem().map_or_else(|| "job".into(), |s| s.to_string_lossy().into_owned());
    let wish = Wish { size, resample };
    let mut jobs = Vec::new();
    for o in outlines::jobs(read.input, &stem, wish, &mut read.notes) {
        let job = o.job.map_err(|words| errors::of_words(py, &words))?;
        jobs.push(Job { job, geometry: o.geometry.map(Arc::new) });
    }
    let o = read.options;
    let lower = |s: String| s.to_ascii_lowercase();
    let options = Options {
        method: o.method.map(|m| lower(format!("{m:?}"))),
        preset: o.preset.map(|p| lower(format!("{p:?}"))),
        threads: o.threads,
        gradation: o.gradation,
        allow_triangles: o.allow_triangles,
        repair_parity: o.repair_parity,
    };
    Ok((jobs, options, read.notes))
}

/// What a job file says of options; `None` where it says nothing.
#[derive(Debug, IntoPyObject)]
pub(crate) struct Options {
    method: Option<String>,
    preset: Option<String>,
    threads: Option<usize>,
    gradation: Option<f64>,
    allow_triangles: Option<bool>,
    repair_parity: Option<bool>,
}

fn read_file(
    path: &Path,
    format: Option<&str>,
) -> Result<csalf_io::JobInput, Result<csalf_io::IoError, String>> {
    let format = match format {
        Some(name) => {
            JobFormat::from_name(name).ok_or_else(|| Err(format!("unknown input format '{name}'")))?
        }
        None => JobFormat::from_path(path).map_err(Ok)?,
    };
    let open = |source| csalf_io::IoError::Open { path: path.to_owned(), source };
    let bytes = std::fs::read(path).map_err(|e| Ok(open(e)))?;
    csalf_io::read_job_bytes(format, &bytes).map_err(Ok)
}

/// The Delaunay triangulation of points with a value each, as the size map makes it: points, triangles, values.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "three arrays")]
pub(crate) fn triangles<'py>(
    py: Python<'py>,
    nodes: PyReadonlyArray2<'py, f64>,
    values: PyReadonlyArray1<'py, f64>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>, Vec<f64>)> {
    let (nodes, values) = (points(&nodes)?, values.as_array().to_vec());
    let made = py.detach(|| Background::from_points(&nodes, &values, &[hull(&nodes)]));
    let made = made.map_err(|e| errors::of_size(py, &e))?;
    let nodes: Vec<Point2> = made.points().collect();
    let triangles: Vec<[u32; 3]> = made.triangles().collect();
    let triangles = numpy::ndarray::ArrayView2::from(triangles.as_slice()).to_pyarray(py);
    Ok((array(py, &nodes), triangles, made.values().collect()))
}

/// The corners of the convex hull, counter-clockwise, as indices. Source: A. M. Andrew's monotone chain, 1979.
fn hull(points: &[Point2]) -> Vec<u32> {
    let at = |i: u32| points[i as usize];
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_unstable_by(|&i, &j| at(i).x.total_cmp(&at(j).x).then(at(i).y.total_cmp(&at(j).y)));
    let chain = |order: &mut dyn Iterator<Item = u32>| {
        let mut out: Vec<u32> = Vec::new();
        for i in order {
            while let [.., a, b] = out[..]
                && orient2d(at(a), at(b), at(i)) <= 0.0
            {
                out.pop();
            }
            out.push(i);
        }
        out.pop();
        out
    };
    let mut out = chain(&mut order.iter().copied());
    out.extend(chain(&mut order.iter().rev().copied()));
    out
}
