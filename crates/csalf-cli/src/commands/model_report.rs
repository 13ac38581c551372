//! What a run on a model tells: a few lines, one line of JSON, or all of it face by face.

use crate::files::{self, Output};
use crate::metrics::scaled_jacobians;
use crate::timing::{self, Seconds};
use csalf_mesh::digest;
use csalf_model::ModelMesh;
use csalf_model::brep::Model;
use serde_json::{Map, Value, json};
use std::fmt::Write as _;

/// Most failures, warnings and loops in the line of JSON.
const MAX_LISTED: usize = 8;

/// One model, meshed and written.
pub(super) struct Done<'a> {
    pub(super) model: &'a Model,
    pub(super) meshed: &'a ModelMesh,
    pub(super) outputs: &'a [Output],
    pub(super) read_s: Seconds,
    pub(super) mesh_s: Seconds,
    pub(super) write_s: Seconds,
}

impl Done<'_> {
    /// A few lines for a person.
    pub(super) fn summary(&self) -> String {
        let (model, meshed) = (self.model, self.meshed);
        let (least, mean) = of_list(&scaled_jacobians(&meshed.mesh));
        let n_faces = model.faces.len();
        let mut s = format!(
            "{}: {} of {n_faces} faces, {} quads, {} nodes in {:.3} s",
            model.name,
            n_faces - meshed.failures.len(),
            meshed.mesh.quads.len(),
            meshed.mesh.points.len(),
            self.mesh_s.wall
        );
        let _ = write!(s, "\n  scaled Jacobian at least {least:.3}, mean {mean:.3}");
        let _ = write!(
            s,
            "\n  sides of one quad only: {}; of three and more: {}",
            meshed.n_free_sides, meshed.n_branching_sides
        );
        for l in meshed.layers.iter().filter(|l| l.made < l.asked) {
            let _ = write!(s, "\n  {}: {} of {} layers: {}", l.name, l.made, l.asked, l.why);
        }
        let outputs = self.outputs.iter().filter(|o| !files::is_standard(&o.path));
        let files: Vec<String> = outputs.map(|o| o.path.display().to_string()).collect();
        if !files.is_empty() {
            let _ = write!(s, "\nwrote {}", files.join(", "));
        }
        s
    }

    /// The entries of the JSON report; `full`: nothing is left out, and each face has its figures.
    pub(super) fn entries(&self, full: bool) -> Map<String, Value> {
        let (model, meshed) = (self.model, self.meshed);
        let quality = scaled_jacobians(&meshed.mesh);
        let (least, mean) = of_list(&quality);
        let shown = |n: usize| if full { n } else { n.min(MAX_LISTED) };
        let mut m = Map::new();
        let mut put = |key: &str, value: Value| {
            m.insert(key.to_owned(), value);
        };
        put("name", model.name.clone().into());
        put("n_faces", model.faces.len().into());
        put("n_vertices", meshed.mesh.points.len().into());
        put("n_quads", meshed.mesh.quads.len().into());
        put("min_sj", least.into());
        put("mean_sj", mean.into());
        let (flat, heights) = meshed.mesh.split();
        put("digest", digest(&flat, &heights).into());
        put("n_free_sides", meshed.n_free_sides.into());
        put("n_branching_sides", meshed.n_branching_sides.into());
        put("read_s", self.read_s.wall.into());
        put("mesh_s", self.mesh_s.wall.into());
        put("mesh_cpu_s", self.mesh_s.cpu.into());
        put("write_s", self.write_s.wall.into());
        put("peak_memory_mb", timing::peak_memory_mb().into());
        let layers = meshed.layers.iter().filter(|l| full || l.made < l.asked).take(shown(usize::MAX));
        let layers =
            layers.map(|l| json!({ "loop": l.name, "asked": l.asked, "made": l.made, "stopped": l.why }));
        put("layers", layers.collect());
        put("n_failures", meshed.failures.len().into());
        let failures = meshed.failures.iter().take(shown(meshed.failures.len()));
        put("failures", failures.map(|f| json!({ "face": f.name, "message": f.message })).collect());
        put("n_warnings", meshed.warnings.len().into());
        put("warnings", meshed.warnings.iter().take(shown(meshed.warnings.len())).cloned().collect());
        if full {
            put("faces", faces(model, meshed, &quality));
        }
        put("outputs", self.outputs.iter().map(|o| Value::from(o.path.display().to_string())).collect());
        m
    }
}

/// One entry per face.
fn faces(model: &Model, meshed: &ModelMesh, quality: &[f64]) -> Value {
    let mut of_face: Vec<Vec<f64>> = vec![Vec::new(); model.faces.len()];
    for (f, q) in meshed.face_of_quad.iter().zip(quality) {
        of_face[*f as usize].push(*q);
    }
    let entry = |(face, q): (&csalf_model::brep::Face, &Vec<f64>)| {
        let (least, mean) = of_list(q);
        let kind = face.shape.kind();
        json!({ "name": face.name, "kind": kind, "n_quads": q.len(), "min_sj": least, "mean_sj": mean })
    };
    model.faces.iter().zip(&of_face).map(entry).collect()
}

/// Smallest and mean.
pub(super) fn of_list(values: &[f64]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    (values.iter().copied().fold(1.0, f64::min), values.iter().sum::<f64>() / n)
}
