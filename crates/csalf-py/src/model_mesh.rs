//! The finished mesh of a model. As [`crate::mesh::Mesh`], with three coordinates, faces, and what failed.

use crate::mesh::{How, Named, cell_data, elements, named_sets, put, rows, values_by_name};
use crate::{errors, share};
use csalf_cli::{metrics, second_order};
use csalf_geom::VertexId;
use csalf_io::{CellData, IoError, MeshData, MeshFormat, MeshView, WriteOptions, json};
use csalf_mesh::SurfaceMesh;
use csalf_model::shard::Stitched;
use csalf_model::{FaceFailure, LoopLayers, Prepared};
use glam::DVec3;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

/// The mesh of a model.
#[pyclass(module = "csalf._csalf", frozen)]
#[derive(Debug)]
pub(crate) struct ModelMesh {
    name: String,
    faces: Vec<String>,
    mesh: csalf_model::ModelMesh,
    /// Values that its file has.
    cell_data: Vec<CellData>,
    /// What it was made of, if that was here.
    model: Option<Arc<Prepared<'static>>>,
}

impl ModelMesh {
    pub(crate) fn new(made: Stitched, model: Option<Arc<Prepared<'static>>>) -> Self {
        let Stitched { name, faces, mesh } = made;
        Self { name, faces, mesh, cell_data: Vec::new(), model }
    }

    /// What a file holds: its faces are the quad sets that have no quad of an earlier one, and what is left.
    pub(crate) fn read(data: MeshData, name: String) -> Self {
        let MeshData { mesh: flat, heights, sets, cell_data, notes } = data;
        const FREE: u32 = u32::MAX;
        let mut face_of_quad = vec![FREE; flat.quads.len()];
        let mut faces: Vec<String> = Vec::new();
        for (name, quads) in &sets.quads {
            if !quads.is_empty() && quads.iter().all(|q| face_of_quad[q.index()] == FREE) {
                quads.iter().for_each(|q| face_of_quad[q.index()] = faces.len() as u32);
                faces.push(name.clone());
            }
        }
        if face_of_quad.contains(&FREE) {
            face_of_quad.iter_mut().filter(|f| **f == FREE).for_each(|f| *f = faces.len() as u32);
            faces.push("other".to_owned());
        }
        let points = flat.points.iter().zip(&heights).map(|(p, &z)| p.extend(z)).collect();
        let mut mesh = csalf_model::ModelMesh {
            mesh: SurfaceMesh { points, quads: flat.quads },
            sets,
            face_of_quad,
            warnings: notes,
            ..csalf_model::ModelMesh::default()
        };
        mesh.count_sides();
        Self { name, faces, mesh, cell_data, model: None }
    }

    fn surface(&self) -> &SurfaceMesh {
        &self.mesh.mesh
    }

    fn fill(
        &self,
        format: MeshFormat,
        cell_data: &[CellData],
        how: How,
        w: &mut dyn Write,
    ) -> Result<(), IoError> {
        let (flat, heights) = self.surface().split();
        let view =
            MeshView { mesh: &flat, heights: &heights, sets: &self.mesh.sets, cell_data, title: &self.name };
        let model = self.model.as_ref().filter(|_| how.nodes > 4);
        let mid = model.map(|m| second_order::of_model(m.model(), &self.mesh, how.nodes == 9));
        let how = WriteOptions { mid: mid.as_ref(), element: how.element };
        csalf_io::write_mesh_with(format, &view, &how, w)?;
        Ok(w.flush()?)
    }
}

/// Face, its name, why it has no mesh, its flat boundary as a job file.
type Failure = (usize, String, String, Option<Vec<u8>>);
/// Loop, layers asked, made, why not more.
type Layers = (String, usize, usize, String);

#[pymethods]
impl ModelMesh {
    /// A mesh from its parts.
    #[new]
    #[allow(clippy::too_many_arguments, reason = "the parts of a pickle")]
    fn from_parts(
        name: String,
        faces: Vec<String>,
        points: PyReadonlyArray2<'_, f64>,
        quads: PyReadonlyArray2<'_, u32>,
        face_of_quad: Vec<u32>,
        sets: (Named<u32>, Named<[u32; 2]>, Named<u32>),
        failures: Vec<Failure>,
        layers: Vec<Layers>,
        warnings: Vec<String>,
        n_sides: (usize, usize),
    ) -> PyResult<Self> {
        let a = points.as_array();
        if a.ncols() != 3 {
            return Err(errors::value(format!("expected an array of shape (n, 3), not {:?}", a.shape())));
        }
        let points: Vec<DVec3> = a.rows().into_iter().map(|r| DVec3::new(r[0], r[1], r[2])).collect();
        let quads = elements::<4>(&quads, points.len())?;
        if face_of_quad.len() != quads.len() || face_of_quad.iter().any(|&f| f as usize >= faces.len()) {
            return Err(errors::value("one face per quad, each of them there"));
        }
        let sets = named_sets(sets, points.len(), quads.len())?;
        let failure = |(face, name, message, case): Failure| FaceFailure {
            face,
            name,
            message,
            case: case.and_then(|bytes| json::read(&bytes).ok()).map(|d| d.job),
        };
        let layer = |(name, asked, made, why): Layers| LoopLayers { name, asked, made, why };
        let mesh = csalf_model::ModelMesh {
            mesh: SurfaceMesh { points, quads },
            sets,
            face_of_quad,
            failures: failures.into_iter().map(failure).collect(),
            layers: layers.into_iter().map(layer).collect(),
            warnings,
            n_free_sides: n_sides.0,
            n_branching_sides: n_sides.1,
        };
        Ok(Self { name, faces, mesh, cell_data: Vec::new(), model: None })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    #[getter]
    fn n_warnings(&self) -> usize {
        self.mesh.warnings.len()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.mesh.warnings.clone()
    }

    #[getter]
    #[allow(unsafe_code, reason = "shows memory of this object")]
    fn points<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = share::places(&slf.get().surface().points);
        // SAFETY: this object is frozen; its mesh lives until it is dropped.
        unsafe { share::borrowed(rows, slf.clone().into_any()) }
    }

    #[getter]
    #[allow(unsafe_code, reason = "shows memory of this object")]
    fn quads<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        // SAFETY: as for the points.
        unsafe { share::borrowed(share::indices(&slf.get().surface().quads), slf.clone().into_any()) }
    }

    /// There are none.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        PyArray2::zeros(py, [0, 3], false)
    }

    /// Where points and quads lie in memory, for tests.
    fn addresses(&self) -> (usize, usize) {
        (self.surface().points.as_ptr() as usize, self.surface().quads.as_ptr() as usize)
    }

    fn face_of_quad<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.mesh.face_of_quad.clone().into_pyarray(py)
    }

    fn face_names(&self) -> Vec<String> {
        self.faces.clone()
    }

    fn failures(&self, py: Python<'_>) -> PyResult<Vec<Failure>> {
        let case = |job: &csalf_core::Job| -> PyResult<Vec<u8>> {
            let mut bytes = Vec::new();
            json::write(job, &csalf_io::JobOptions::default(), &mut bytes)
                .map_err(|e| errors::of_file(py, &e))?;
            Ok(bytes)
        };
        let one = |f: &FaceFailure| -> PyResult<Failure> {
            Ok((f.face, f.name.clone(), f.message.clone(), f.case.as_ref().map(case).transpose()?))
        };
        self.mesh.failures.iter().map(one).collect()
    }

    fn layers(&self) -> Vec<Layers> {
        let one = |l: &LoopLayers| (l.name.clone(), l.asked, l.made, l.why.clone());
        self.mesh.layers.iter().map(one).collect()
    }

    /// Sides of one quad only; of three and more.
    fn n_sides(&self) -> (usize, usize) {
        (self.mesh.n_free_sides, self.mesh.n_branching_sides)
    }

    fn node_sets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        crate::mesh::node_sets(py, &self.mesh.sets)
    }

    fn edge_sets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        crate::mesh::edge_sets(py, &self.mesh.sets)
    }

    fn quad_sets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        crate::mesh::quad_sets(py, &self.mesh.sets)
    }

    /// Values per element that came with the file.
    fn cell_data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        values_by_name(py, &self.cell_data)
    }

    /// Sides that one quad has alone, in its direction.
    fn boundary<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        let edges = py.detach(|| free_sides(self.surface()));
        numpy::ToPyArray::to_pyarray(&rows(share::indices(&edges)), py)
    }

    /// Values of a metric, each quad in its mean plane.
    fn metric<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let values = py.detach(|| {
            let (mesh, heights) = self.surface().split();
            metrics::in_space(&mesh, &heights, name)
        });
        let unknown =
            || errors::value(format!("no metric '{name}'; known are {}", metrics::NAMES.join(", ")));
        Ok(values.ok_or_else(unknown)?.into_pyarray(py))
    }

    /// The report as JSON.
    fn report_json(&self, py: Python<'_>) -> String {
        py.detach(|| {
            let sj = metrics::scaled_jacobians(self.surface());
            let (n_vertices, n_quads) = (self.surface().points.len(), sj.len());
            let quality = serde_json::json!({
                "n_vertices": n_vertices,
                "n_quads": n_quads,
                "min_sj": sj.iter().copied().fold(1.0, f64::min),
                "mean_sj": sj.iter().sum::<f64>() / n_quads.max(1) as f64,
            });
            let (flat, heights) = self.surface().split();
            let failure = |f: &FaceFailure| serde_json::json!({ "face": f.name, "message": f.message });
            let layer = |l: &LoopLayers| {
                serde_json::json!({ "loop": l.name, "asked": l.asked, "made": l.made, "stopped": l.why })
            };
            let failures: Vec<_> = self.mesh.failures.iter().map(failure).collect();
            let layers: Vec<_> = self.mesh.layers.iter().map(layer).collect();
            serde_json::json!({
                "name": self.name,
                "n_faces": self.faces.len(),
                "n_vertices": n_vertices,
                "n_quads": n_quads,
                "n_triangles": 0,
                "digest": csalf_mesh::digest(&flat, &heights),
                "n_free_sides": self.mesh.n_free_sides,
                "n_branching_sides": self.mesh.n_branching_sides,
                "quality": quality,
                "failures": failures,
                "layers": layers,
                "warnings": self.mesh.warnings,
            })
            .to_string()
        })
    }

    /// What is wrong with the mesh, in words.
    fn findings(&self, py: Python<'_>) -> Vec<String> {
        let bad = py.detach(|| {
            metrics::scaled_jacobians(self.surface()).iter().filter(|q| q.is_nan() || **q <= 0.0).count()
        });
        let mut out: Vec<String> = self
            .mesh
            .failures
            .iter()
            .map(|f| format!("face {} has no mesh: {}", f.name, f.message))
            .collect();
        if bad > 0 {
            out.push(format!("{bad} quads are not convex"));
        }
        out
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
        if how.nodes > 4 && self.model.is_none() {
            return Err(errors::value(
                "mid-side nodes need the model's surfaces, which a stitched, unpickled or read mesh does not know",
            ));
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

/// Sides of one quad only, in the order of the quads.
fn free_sides(mesh: &SurfaceMesh) -> Vec<[VertexId; 2]> {
    let side = |q: &[VertexId; 4], k: usize| [q[k], q[(k + 1) % 4]];
    let key = |[a, b]: [VertexId; 2]| [a.min(b), a.max(b)];
    let mut all: Vec<[VertexId; 2]> =
        mesh.quads.iter().flat_map(|q| (0..4).map(move |k| key(side(q, k)))).collect();
    all.sort_unstable();
    let alone = |s: [VertexId; 2]| {
        let at = all.partition_point(|t| *t < s);
        all.get(at + 1) != Some(&s)
    };
    mesh.quads.iter().flat_map(|q| (0..4).map(move |k| side(q, k))).filter(|s| alone(key(*s))).collect()
}
