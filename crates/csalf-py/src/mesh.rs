//! The finished mesh. Python sees its arrays in place, so it never changes.

use crate::model_mesh::ModelMesh;
use crate::{errors, job, share};
use csalf_cli::{commands, json, metrics};
use csalf_core::{Job, MeshReport, Meshed, Options};
use csalf_geom::{Geometry, QuadId, VertexId};
use csalf_io::inp::InpElement;
use csalf_io::{CellData, IoError, MeshFormat, MeshView, MidNodes, WriteOptions};
use csalf_mesh::quality::QualityReport;
use csalf_mesh::{NamedSets, QuadMesh};
use csalf_sizemap::SizeField;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// A mesh, its sets and what is known of how it was made.
#[pyclass(module = "csalf._csalf", frozen)]
#[derive(Debug)]
pub(crate) struct Mesh {
    mesh: QuadMesh,
    sets: NamedSets,
    cell_data: Vec<CellData>,
    /// Of a mesh that was made here.
    made: Option<Made>,
    notes: Vec<String>,
    field: OnceLock<Option<Arc<dyn SizeField>>>,
}

/// How a mesh was made.
#[derive(Debug)]
struct Made {
    report: MeshReport,
    job: Job,
    options: Options,
    geometry: Option<Arc<Geometry>>,
}

impl Mesh {
    /// A mesh that was made here.
    pub(crate) fn new(meshed: Meshed, job: Job, options: Options, geometry: Option<Arc<Geometry>>) -> Self {
        let Meshed { mesh, sets, report, .. } = meshed;
        let made = Some(Made { report, job, options, geometry });
        Self { mesh, sets, cell_data: Vec::new(), made, notes: Vec::new(), field: OnceLock::new() }
    }

    fn field(&self) -> Option<&dyn SizeField> {
        let make =
            || self.made.as_ref().and_then(|m| commands::mesh::size_field(&m.job, m.options.gradation));
        self.field.get_or_init(make).as_deref()
    }

    fn title(&self) -> &str {
        self.made.as_ref().map_or("", |m| m.job.name.as_str())
    }

    fn fill(
        &self,
        format: MeshFormat,
        data: &[CellData],
        how: How,
        w: &mut dyn Write,
    ) -> Result<(), IoError> {
        let cell_data = if data.is_empty() { self.cell_data.as_slice() } else { data };
        let view =
            MeshView { mesh: &self.mesh, heights: &[], sets: &self.sets, cell_data, title: self.title() };
        let centres = how.nodes == 9;
        let geometry = self.made.as_ref().and_then(|m| m.geometry.as_deref());
        let mid = (how.nodes > 4).then(|| match geometry {
            Some(g) => MidNodes::on_curves(&self.mesh, &self.sets, g, centres),
            None => MidNodes::new(&self.mesh, centres),
        });
        let how = WriteOptions { mid: mid.as_ref(), element: how.element };
        csalf_io::write_mesh_with(format, &view, &how, w)?;
        Ok(w.flush()?)
    }
}

/// Members by name.
pub(crate) type Named<T> = Vec<(String, Vec<T>)>;

/// Sets of nodes, edges and quads of a mesh of so many.
pub(crate) fn named_sets(
    sets: (Named<u32>, Named<[u32; 2]>, Named<u32>),
    n_points: usize,
    n_quads: usize,
) -> PyResult<NamedSets> {
    let bad_node = sets.0.iter().find(|s| s.1.iter().any(|&v| v as usize >= n_points)).map(|s| &s.0);
    let bad_edge =
        sets.1.iter().find(|s| s.1.iter().flatten().any(|&v| v as usize >= n_points)).map(|s| &s.0);
    let bad_quad = sets.2.iter().find(|s| s.1.iter().any(|&q| q as usize >= n_quads)).map(|s| &s.0);
    if let Some(name) = bad_node.or(bad_edge).or(bad_quad) {
        return Err(errors::value(format!("set '{name}' names something that the mesh has not")));
    }
    Ok(NamedSets {
        nodes: sets.0.into_iter().map(|(n, v)| (n, v.into_iter().map(VertexId).collect())).collect(),
        edges: sets
            .1
            .into_iter()
            .map(|(n, e)| (n, e.into_iter().map(|e| e.map(VertexId)).collect()))
            .collect(),
        quads: sets.2.into_iter().map(|(n, q)| (n, q.into_iter().map(QuadId).collect())).collect(),
    })
}

pub(crate) fn node_sets<'py>(py: Python<'py>, sets: &NamedSets) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    for (name, nodes) in &sets.nodes {
        out.set_item(name, nodes.iter().map(|v| v.0).collect::<Vec<_>>().into_pyarray(py))?;
    }
    Ok(out)
}

pub(crate) fn edge_sets<'py>(py: Python<'py>, sets: &NamedSets) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    for (name, edges) in &sets.edges {
        out.set_item(name, numpy::ToPyArray::to_pyarray(&rows(share::indices(edges)), py))?;
    }
    Ok(out)
}

pub(crate) fn quad_sets<'py>(py: Python<'py>, sets: &NamedSets) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    for (name, quads) in &sets.quads {
        out.set_item(name, quads.iter().map(|q| q.0).collect::<Vec<_>>().into_pyarray(py))?;
    }
    Ok(out)
}

/// The format called so, or else that of the extension.
fn format_of(py: Python<'_>, path: &Path, name: Option<&str>) -> PyResult<MeshFormat> {
    match name {
        Some(name) => MeshFormat::from_name(name).ok_or_else(|| errors::value(format!("no format '{name}'"))),
        None => MeshFormat::from_path(path).map_err(|e| errors::of_file(py, &e)),
    }
}

/// Writes what `fill` gives to a file. One that could not be written in full is removed again.
pub(crate) fn put(
    py: Python<'_>,
    path: &Path,
    format: Option<&str>,
    fill: impl FnOnce(MeshFormat, &mut dyn Write) -> Result<(), IoError> + Send,
) -> PyResult<()> {
    let format = format_of(py, path, format)?;
    let file = std::fs::File::create(path)
        .map_err(|source| errors::of_file(py, &IoError::Open { path: path.to_owned(), source }))?;
    py.detach(|| fill(format, &mut BufWriter::new(file))).map_err(|e| {
        // The error that matters is the one at hand.
        let _ = std::fs::remove_file(path);
        errors::of_file(py, &e)
    })
}

#[pymethods]
impl Mesh {
    /// A mesh from arrays.
    #[new]
    fn from_arrays(
        points: PyReadonlyArray2<'_, f64>,
        quads: PyReadonlyArray2<'_, u32>,
        triangles: PyReadonlyArray2<'_, u32>,
        sets: (Named<u32>, Named<[u32; 2]>, Named<u32>),
    ) -> PyResult<Self> {
        let points = job::points(&points)?;
        let n = points.len();
        let quads = elements::<4>(&quads, n)?;
        let mesh = QuadMesh { points, triangles: elements::<3>(&triangles, n)?, quads };
        let sets = named_sets(sets, mesh.points.len(), mesh.n_quads())?;
        let (cell_data, notes) = (Vec::new(), Vec::new());
        Ok(Self { mesh, sets, cell_data, made: None, notes, field: OnceLock::new() })
    }

    #[getter]
    fn name(&self) -> &str {
        self.title()
    }

    #[getter]
    fn n_warnings(&self) -> usize {
        self.made.as_ref().map_or(0, |m| m.report.warnings.len())
    }

    #[getter]
    #[allow(unsafe_code, reason = "shows memory of this object")]
    fn points<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        // SAFETY: this object is frozen; its mesh lives until it is dropped.
        unsafe { share::borrowed(share::coordinates(&slf.get().mesh.points), slf.clone().into_any()) }
    }

    #[getter]
    #[allow(unsafe_code, reason = "shows memory of this object")]
    fn quads<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        // SAFETY: as for the points.
        unsafe { share::borrowed(share::indices(&slf.get().mesh.quads), slf.clone().into_any()) }
    }

    #[getter]
    #[allow(unsafe_code, reason = "shows memory of this object")]
    fn triangles<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        // SAFETY: as for the points.
        unsafe { share::borrowed(share::indices(&slf.get().mesh.triangles), slf.clone().into_any()) }
    }

    /// Where points and quads lie in memory, for tests.
    fn addresses(&self) -> (usize, usize) {
        (self.mesh.points.as_ptr() as usize, self.mesh.quads.as_ptr() as usize)
    }

    fn node_sets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        node_sets(py, &self.sets)
    }

    fn edge_sets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        edge_sets(py, &self.sets)
    }

    fn quad_sets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        quad_sets(py, &self.sets)
    }

    /// Values per element that came with the file.
    fn cell_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        values_by_name(py, &self.cell_data)
    }

    /// Edges that one element has alone, in its direction: the material is on their left.
    fn boundary<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        let edges = py.detach(|| commands::check::boundary(&self.mesh));
        numpy::ToPyArray::to_pyarray(&rows(share::indices(&edges)), py)
    }

    /// Values of a metric.
    fn metric<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let values = py.detach(|| metrics::values(&self.mesh, name, self.field()));
        let unknown =
            || errors::value(format!("no metric '{name}'; known are {}", metrics::NAMES.join(", ")));
        Ok(values.ok_or_else(unknown)?.into_pyarray(py))
    }

    /// Names of all metrics.
    #[staticmethod]
    fn metric_names() -> Vec<&'static str> {
        metrics::NAMES.to_vec()
    }

    /// The report as JSON, loop by loop; the keys are those of the program.
    fn report_json(&self, py: Python<'_>) -> String {
        py.detach(|| {
            let region = self.made.as_ref().and_then(|m| m.job.local_region);
            let quality = QualityReport::new(&self.mesh, self.field(), region);
            let mut out = serde_json::Map::new();
            out.insert("name".into(), self.title().into());
            out.insert("n_vertices".into(), self.mesh.n_vertices().into());
            out.insert("n_quads".into(), self.mesh.n_quads().into());
            out.insert("n_triangles".into(), self.mesh.triangles.len().into());
            if let Some(made) = &self.made {
                out.insert("mesh_s".into(), made.report.timing.wall_s.into());
                out.extend(json::report(&made.report, true));
            }
            out.insert("quality".into(), json::quality(&quality, true));
            out.insert("digest".into(), csalf_mesh::digest(&self.mesh, &[]).into());
            out.insert("notes".into(), self.notes.clone().into());
            serde_json::Value::Object(out).to_string()
        })
    }

    /// What is wrong with the mesh as such, in words; empty if nothing is.
    fn findings(&self, py: Python<'_>) -> Vec<String> {
        py.detach(|| commands::check::defects(&self.mesh))
    }

    /// Writes to a file. A file that could not be written in full is removed again.
    fn write(
        &self,
        py: Python<'_>,
        path: PathBuf,
        format: Option<&str>,
        data: Vec<(String, PyReadonlyArray1<'_, f64>)>,
        nodes: usize,
        element: &str,
    ) -> PyResult<()> {
        let (data, how) = (cell_data(data), How::new(nodes, element)?);
        if how.nodes == 4 && format_of(py, &path, format)? == MeshFormat::Foam {
            let view = MeshView {
                mesh: &self.mesh,
                heights: &[],
                sets: &self.sets,
                cell_data: &[],
                title: self.title(),
            };
            return py
                .detach(|| csalf_io::foam::write_case(&view, &path))
                .map_err(|e| errors::of_file(py, &e));
        }
        put(py, &path, format, |format, w| self.fill(format, &data, how, w))
    }

    /// The bytes of a file.
    fn encode<'py>(
        &self,
        py: Python<'py>,
        format: &str,
        data: Vec<(String, PyReadonlyArray1<'_, f64>)>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let format =
            MeshFormat::from_name(format).ok_or_else(|| errors::value(format!("no format '{format}'")))?;
        let data = cell_data(data);
        let mut bytes = Vec::new();
        py.detach(|| self.fill(format, &data, How::default(), &mut bytes))
            .map_err(|e| errors::of_file(py, &e))?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// How a mesh is written.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct How {
    /// Nodes per quad: 4, 8 or 9.
    pub(crate) nodes: usize,
    pub(crate) element: InpElement,
}

impl How {
    pub(crate) fn new(nodes: usize, element: &str) -> PyResult<Self> {
        if ![4, 8, 9].contains(&nodes) {
            return Err(errors::value(format!("quads have 4, 8 or 9 nodes, not {nodes}")));
        }
        let element = match element {
            "shell" => InpElement::Shell,
            "plane-stress" => InpElement::PlaneStress,
            "plane-strain" => InpElement::PlaneStrain,
            "axisymmetric" => InpElement::Axisymmetric,
            _ => {
                let known = "shell, plane-stress, plane-strain, axisymmetric";
                return Err(errors::value(format!("element '{element}': known are {known}")));
            }
        };
        Ok(Self { nodes, element })
    }
}

pub(crate) fn cell_data(data: Vec<(String, PyReadonlyArray1<'_, f64>)>) -> Vec<CellData> {
    data.into_iter().map(|(name, v)| CellData { name, values: v.as_array().to_vec() }).collect()
}

/// Arrays by name.
pub(crate) fn values_by_name<'py>(py: Python<'py>, data: &[CellData]) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    for d in data {
        out.set_item(&d.name, d.values.clone().into_pyarray(py))?;
    }
    Ok(out)
}

pub(crate) fn rows(edges: &[[u32; 2]]) -> numpy::ndarray::ArrayView2<'_, u32> {
    numpy::ndarray::ArrayView2::from(edges)
}

/// Rows of vertex numbers below `n`.
pub(crate) fn elements<const K: usize>(
    array: &PyReadonlyArray2<'_, u32>,
    n: usize,
) -> PyResult<Vec<[VertexId; K]>> {
    let a = array.as_array();
    if a.ncols() != K {
        return Err(errors::value(format!("expected an array of shape (n, {K}), not {:?}", a.shape())));
    }
    if let Some(v) = a.iter().find(|&&v| v as usize >= n) {
        return Err(errors::value(format!("an element names vertex {v}, but there are {n}")));
    }
    Ok(a.rows().into_iter().map(|r| std::array::from_fn(|k| VertexId(r[k]))).collect())
}

/// Reads a mesh from a file: a plane one, or one in space.
#[pyfunction]
pub(crate) fn read(py: Python<'_>, path: PathBuf, format: Option<&str>) -> PyResult<Py<PyAny>> {
    let format = format_of(py, &path, format)?;
    let data = py
        .detach(|| {
            let bytes =
                std::fs::read(&path).map_err(|source| IoError::Open { path: path.clone(), source })?;
            let data = csalf_io::read_mesh_bytes(format, &bytes)?;
            // Models have quads alone.
            if data.mesh.triangles.is_empty() { Ok(data) } else { data.planar(format.name()) }
        })
        .map_err(|e| errors::of_file(py, &e))?;
    if let Some(v) = wild(&data.mesh) {
        return Err(errors::value(format!("an element names vertex {v}, which is not there")));
    }
    if !data.heights.is_empty() {
        let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        return Ok(Py::new(py, ModelMesh::read(data, name))?.into_any());
    }
    let csalf_io::MeshData { mesh, sets, cell_data, notes, .. } = data;
    Ok(Py::new(py, Mesh { mesh, sets, cell_data, made: None, notes, field: OnceLock::new() })?.into_any())
}

/// A vertex that elements name and that is not there.
fn wild(mesh: &QuadMesh) -> Option<u32> {
    let n = mesh.n_vertices();
    let all = mesh.quads.iter().flatten().chain(mesh.triangles.iter().flatten());
    all.map(|v| v.0).find(|&v| v as usize >= n)
}

/// All formats of meshes and pictures: name and extensions.
#[pyfunction]
pub(crate) fn formats() -> Vec<(&'static str, Vec<&'static str>)> {
    MeshFormat::ALL.iter().map(|f| (f.name(), f.extensions().to_vec())).collect()
}
