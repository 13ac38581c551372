//! What the engine answers to a document: a head of JSON and arrays of 32-bit numbers, little-endian.
//!
//! ```text
//!   | length of the head, u32 | head, filled up with blanks to a multiple of 4 | array | array | ...
//! ```
//!
//! `arrays` in the head gives for each name where it starts behind the head and how many numbers it has.
//! Points are
//! relative to `origin` and divided by `scale`, so that 32 bits lose nothing far from the origin.

use crate::document::{Document, Ready};
use csalf_core::{Job, MeshError, Meshed};
use csalf_geom::{LoopKind, Point2, polygon};
use csalf_io::outlines::Unplaced;
use csalf_mesh::quality::QualityReport;
use csalf_mesh::quality::metrics::{self, SCALES};
use serde_json::{Map, Value, json};

/// Most defects told one by one.
const MAX_DEFECTS: usize = 200;

/// A reply being put together.
#[derive(Debug)]
struct Reply {
    head: Map<String, Value>,
    arrays: Map<String, Value>,
    body: Vec<u8>,
    origin: Point2,
    scale: f64,
}

impl Reply {
    /// The outline, and where all points are measured from.
    fn new(job: &Job, notes: &[String]) -> Self {
        let d = &job.domain;
        let chains = d.loops.iter().map(|l| &l.nodes).chain(d.scars.iter().map(|s| &s.nodes));
        let points = chains.flatten().copied().filter(|p| p.is_finite());
        let (low, high) = polygon::bounds(points).unwrap_or_default();
        let extent = (high - low).max_element();
        let scale = if extent > 0.0 && extent.is_finite() { extent } else { 1.0 };
        let (head, arrays) = (Map::new(), Map::new());
        let mut out = Self { head, arrays, body: Vec::new(), origin: low, scale };
        out.put("name", &job.name);
        out.put("notes", notes);
        out.put("origin", [low.x, low.y]);
        out.put("scale", scale);
        out.outline(job);
        out
    }

    fn put(&mut self, key: &str, value: impl serde::Serialize) {
        self.head.insert(key.to_owned(), serde_json::to_value(value).unwrap_or_default());
    }

    fn array(&mut self, name: &str, values: impl Iterator<Item = [u8; 4]>) {
        let start = self.body.len();
        self.body.extend(values.flatten());
        self.arrays.insert(name.to_owned(), json!([start, (self.body.len() - start) / 4]));
    }

    fn points(&mut self, name: &str, points: impl Iterator<Item = Point2>) {
        let (origin, scale) = (self.origin, self.scale);
        self.array(
            name,
            points.flat_map(|p| ((p - origin) / scale).to_array()).map(|x| (x as f32).to_le_bytes()),
        );
    }

    /// Loops, scars and points as they are drawn.
    fn outline(&mut self, job: &Job) {
        let d = &job.domain;
        let mean = |p: &[Point2]| if p.is_empty() { 0.0 } else { polygon::perimeter(p) / p.len() as f64 };
        let loops: Vec<Value> = d
            .loops
            .iter()
            .map(|l| {
                let kind = if l.kind == LoopKind::Outer { "outer" } else { "hole" };
                json!({"name": l.name, "kind": kind, "n": l.nodes.len(), "segment": mean(&l.nodes)})
            })
            .collect();
        let scars: Vec<Value> = d.scars.iter().map(|s| json!({"name": s.name, "n": s.nodes.len()})).collect();
        self.put("loops", loops);
        self.put("scars", scars);
        let nodes = d.loops.iter().flat_map(|l| &l.nodes).chain(d.scars.iter().flat_map(|s| &s.nodes));
        self.points("outline", nodes.copied());
        self.points("hard_points", d.points.iter().map(|p| p.xy));
    }

    fn errors(mut self, errors: Vec<(String, Vec<Point2>)>) -> Vec<u8> {
        let list: Vec<Value> = errors
            .iter()
            .take(MAX_DEFECTS)
            .map(|(text, at)| {
                json!({"text": text, "places": at.iter().map(|p| p.to_array()).collect::<Vec<_>>()})
            })
            .collect();
        self.put("ok", false);
        self.put("n_errors", errors.len());
        self.put("errors", list);
        self.bytes()
    }

    fn bytes(mut self) -> Vec<u8> {
        self.head.insert("arrays".into(), self.arrays.into());
        let mut head = Value::Object(self.head).to_string().into_bytes();
        head.resize(head.len().next_multiple_of(4), b' ');
        let mut out = Vec::with_capacity(4 + head.len() + self.body.len());
        out.extend((head.len() as u32).to_le_bytes());
        out.extend(head);
        out.extend(self.body);
        out
    }
}

/// The reply to a document that got no nodes.
pub(crate) fn unplaced(document: &Document, why: &Unplaced) -> Vec<u8> {
    let errors = match why {
        Unplaced::Curves(defects) => {
            defects.iter().map(|d| (d.to_string(), d.place().into_iter().collect())).collect()
        }
        Unplaced::Size(e) => vec![(format!("the wanted sizes are invalid: {e}"), Vec::new())],
    };
    Reply::new(&document.sketch(), &document.notes).errors(errors)
}

/// The reply to a job that was refused.
pub(crate) fn refused(ready: &Ready, notes: &[String], why: &MeshError) -> Vec<u8> {
    let errors = match why {
        MeshError::Invalid(defects) => defects.iter().map(|d| (d.to_string(), d.places())).collect(),
        other => vec![(other.to_string(), Vec::new())],
    };
    Reply::new(&ready.job, notes).errors(errors)
}

/// The reply with a mesh: all that the page draws and tells. Cost O(n), and some size queries per element.
pub(crate) fn done(ready: &Ready, notes: &[String], meshed: &Meshed, gradation: Option<f64>) -> Vec<u8> {
    let (job, mesh) = (&ready.job, &meshed.mesh);
    let field = job.size_field(gradation).ok();
    let mut out = Reply::new(job, notes);
    out.put("ok", true);
    out.put("default_size", ready.default_size);
    out.put("n_vertices", mesh.n_vertices());
    out.put("n_quads", mesh.n_quads());
    out.put("n_triangles", mesh.triangles.len());
    out.put("mesh_s", meshed.report.timing.wall_s);
    out.put("quality", QualityReport::new(mesh, field.as_deref(), job.local_region));
    let layers = meshed.report.loops.iter().map(|l| {
        json!({
            "name": l.name, "asked": l.asked, "made": l.made, "stopped": l.stopped,
            "thickness_error": l.thickness_error,
        })
    });
    out.put("layers", layers.collect::<Vec<_>>());
    out.put("warnings", meshed.report.warnings.iter().map(ToString::to_string).collect::<Vec<_>>());
    out.points("points", mesh.points.iter().copied());
    out.array("quads", mesh.quads.iter().flatten().map(|v| v.0.to_le_bytes()));
    out.array("triangles", mesh.triangles.iter().flatten().map(|v| v.0.to_le_bytes()));
    let mut shown = Vec::new();
    for s in SCALES {
        if let Some(values) = metrics::values(mesh, s.name, field.as_deref()) {
            out.array(s.name, values.into_iter().map(|x| (x as f32).to_le_bytes()));
            shown.push(
                json!({"name": s.name, "label": s.label, "good": s.good, "low": s.low, "high": s.high}),
            );
        }
    }
    out.put("metrics", shown);
    out.bytes()
}
