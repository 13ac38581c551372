//! Whole models: read, discretised, meshed in one piece or in shards.
//!
//! ```text
//!   file ─▶ Model ─plan─▶ Plan (nodes on edges) ─mesh──────────────────────▶ ModelMesh
//!                              └─shard i of n─▶ bytes ─┐
//!                         other processes ─────▶ bytes ┴─stitch──────────────▶ ModelMesh
//! ```

use crate::model_mesh::ModelMesh;
use crate::{errors, run};
use csalf_cli::layers::parse_law;
use csalf_cli::model_file::{self, Reading};
use csalf_core::{MeshError, Options, Watch};
use csalf_io::IoError;
use csalf_model::shard::{self, Shard, Stitched};
use csalf_model::{LayerLaw, LayerSpec, ModelOptions, Prepared, SizeRules};
use glam::DVec3;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A model as it was read: sewn and checked.
#[pyclass(module = "csalf._csalf", frozen)]
#[derive(Debug)]
pub(crate) struct Model {
    model: Arc<csalf_model::Model>,
}

/// Pattern, count, law, thicknesses, first thickness.
type Layers = Vec<(String, usize, String, Option<Vec<f64>>, Option<f64>)>;
/// Values by pattern of names.
type Named<T> = Vec<(String, T)>;

/// What is asked of the mesh of a model.
#[derive(Debug, FromPyObject)]
pub(crate) struct Wish {
    size: Option<f64>,
    min_size: Option<f64>,
    per_turn: Option<f64>,
    gradation: Option<f64>,
    face_sizes: Named<f64>,
    edge_sizes: Named<f64>,
    loop_sizes: Named<f64>,
    edge_counts: Named<usize>,
    layers: Layers,
    points: Named<[f64; 3]>,
    method: String,
    preset: String,
}

#[pymethods]
impl Model {
    /// Reads a file.
    #[staticmethod]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        format: Option<&str>,
        feature_angle: Option<f64>,
        sewing: Option<f64>,
    ) -> PyResult<Self> {
        let bytes = py
            .detach(|| std::fs::read(&path))
            .map_err(|source| errors::of_file(py, &IoError::Open { path: path.clone(), source }))?;
        let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let shown = path.display().to_string();
        Self::from_bytes(py, &bytes, &shown, &name, format, feature_angle, sewing)
    }

    /// The model in the bytes of the file `shown`.
    #[staticmethod]
    fn from_bytes(
        py: Python<'_>,
        bytes: &[u8],
        shown: &str,
        name: &str,
        format: Option<&str>,
        feature_angle: Option<f64>,
        sewing: Option<f64>,
    ) -> PyResult<Self> {
        let Some(format) = model_file::format(Path::new(shown), format) else {
            return Err(errors::value(format!("{shown}: a model is .step, .stp, .stl, .obj or .ply")));
        };
        let model =
            py.detach(|| model_file::read(bytes, format, shown, name, Reading { feature_angle, sewing }));
        let model = Arc::new(model.map_err(|e| errors::of_failure(py, &e, format))?);
        Ok(Self { model })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.model.name
    }

    #[getter]
    fn unit(&self) -> &str {
        &self.model.unit
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.model.notes.clone()
    }

    /// Corners of the box around it.
    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let (lo, hi) = self.model.bounds().unwrap_or_default();
        (lo.to_array(), hi.to_array())
    }

    /// Name and kind of surface of each face.
    fn faces(&self) -> Vec<(String, &'static str)> {
        self.model.faces.iter().map(|f| (f.name.clone(), f.shape.kind())).collect()
    }

    /// Names of the edges.
    fn edges(&self) -> Vec<String> {
        self.model.edges.iter().map(|e| e.name.clone()).collect()
    }

    /// Name, face and diameter (of holes) of each loop.
    fn loops(&self) -> Vec<(String, usize, Option<f64>)> {
        csalf_model::named_loops(&self.model).into_iter().map(|l| (l.name, l.face, l.diameter)).collect()
    }

    /// Discretises the edges.
    fn plan(&self, py: Python<'_>, wish: Wish) -> PyResult<Plan> {
        let options = wish.options(&self.model)?;
        let model = csalf_model::Model::clone(&self.model);
        let prepared = run::follow(py, None, move |_| Prepared::new(Cow::Owned(model), &options))?;
        Ok(Plan { prepared: Arc::new(prepared) })
    }
}

impl Wish {
    fn options(self, model: &csalf_model::Model) -> PyResult<ModelOptions> {
        let (method, preset) = run::means(&self.method, &self.preset)?;
        let mut layers = Vec::new();
        for (pattern, count, law, thicknesses, first) in self.layers {
            let law = match thicknesses {
                Some(t) => LayerLaw::Explicit(t),
                None => parse_law(&law).map_err(errors::value)?,
            };
            layers.push((pattern, LayerSpec { count, law, first }));
        }
        let mut rules = self.size.map_or_else(|| SizeRules::of_model(model), SizeRules::of);
        rules.min_size = self.min_size.unwrap_or(rules.min_size);
        rules.per_turn = self.per_turn.unwrap_or(rules.per_turn);
        rules.gradation = self.gradation.unwrap_or(rules.gradation);
        rules.faces = self.face_sizes;
        rules.edges = self.edge_sizes;
        Ok(ModelOptions {
            size: Some(rules),
            layers,
            points: self.points.into_iter().map(|(n, p)| (n, DVec3::from_array(p))).collect(),
            counts: self.edge_counts,
            loop_sizes: self.loop_sizes,
            mesher: Options { method, preset, gradation: self.gradation, ..Options::default() },
        })
    }
}

/// A model whose edges are discretised: its faces can be meshed here or anywhere.
#[pyclass(module = "csalf._csalf", frozen)]
#[derive(Debug)]
pub(crate) struct Plan {
    prepared: Arc<Prepared<'static>>,
}

#[pymethods]
impl Plan {
    #[getter]
    fn n_faces(&self) -> usize {
        self.prepared.n_faces()
    }

    /// What all shards of a run in `count` parts have in common.
    fn fingerprint(&self, py: Python<'_>, count: u32) -> String {
        py.detach(|| format!("{:032x}", self.prepared.fingerprint(count)))
    }

    /// The faces of each part.
    fn parts(&self, py: Python<'_>, count: u32) -> Vec<Vec<usize>> {
        py.detach(|| self.prepared.parts(count))
    }

    /// Meshes all faces, on `threads` threads (0: all cores).
    fn mesh(&self, py: Python<'_>, threads: usize, watch: Option<Bound<'_, PyAny>>) -> PyResult<ModelMesh> {
        let prepared = Arc::clone(&self.prepared);
        let made = run::follow(py, watch.as_ref(), move |line| {
            line.stage("faces");
            let mesh = within(threads, || prepared.mesh_watched(line));
            mesh.map(|mesh| (mesh, line.cancelled()))
        })?;
        let (mesh, cancelled) = made.map_err(errors::value)?;
        if cancelled {
            return Err(errors::of_meshing(py, &MeshError::Cancelled));
        }
        let model = self.prepared.model();
        let faces = model.faces.iter().map(|f| f.name.clone()).collect();
        let made = Stitched { name: model.name.clone(), faces, mesh };
        Ok(ModelMesh::new(made, Some(Arc::clone(&self.prepared))))
    }

    /// Meshes part `index` (from 1) of `count`: the bytes of a shard.
    fn shard<'py>(
        &self,
        py: Python<'py>,
        index: u32,
        count: u32,
        threads: usize,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let prepared = Arc::clone(&self.prepared);
        let work = move |line: &dyn Watch| within(threads, || prepared.shard(index, count, line));
        let shard = run::follow(py, None, work)?.map_err(errors::value)?;
        let shard = shard.ok_or_else(|| errors::value(format!("there is no part {index} of {count}")))?;
        let bytes = py.detach(|| shard.to_bytes()).map_err(|e| errors::of_shards(py, &[e]))?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// Runs `work` on so many threads; 0: all cores.
fn within<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T, String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    Ok(pool.map_err(|e| e.to_string())?.install(work))
}

/// One mesh out of the bytes of shards, each with the name that messages call it by.
#[pyfunction]
pub(crate) fn stitch(py: Python<'_>, shards: Vec<(String, Vec<u8>)>) -> PyResult<ModelMesh> {
    let stitched = py.detach(|| {
        let read = shards.iter().map(|(name, bytes)| Shard::from_bytes(name, bytes));
        let (good, bad): (Vec<_>, Vec<_>) = read.partition(Result::is_ok);
        let errors: Vec<_> = bad.into_iter().filter_map(Result::err).collect();
        if !errors.is_empty() {
            return Err(errors);
        }
        shard::stitch(good.into_iter().filter_map(Result::ok).collect())
    });
    stitched.map(|made| ModelMesh::new(made, None)).map_err(|e| errors::of_shards(py, &e))
}
