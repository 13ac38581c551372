//! TopoJSON polygons: arcs are decoded (delta-coded integers with a transform, or plain coordinates) and joined to
//! rings; each polygon is a job.

use crate::{
    Input, IoError, JobInput, JobOptions, Place,
    rings::{feature_name, job_of_polygon, part_name},
};
use csalf_geom::Point2;
use serde::Deserialize;
use serde_json::{Map, Value};

const FORMAT: &str = "TopoJSON";

#[derive(Deserialize)]
struct Topology {
    #[serde(rename = "type")]
    kind: String,
    transform: Option<Transform>,
    arcs: Vec<Vec<Vec<f64>>>,
    objects: Map<String, Value>,
}

#[derive(Deserialize)]
struct Transform {
    scale: [f64; 2],
    translate: [f64; 2],
}

#[derive(Deserialize)]
struct Geometry {
    #[serde(rename = "type")]
    kind: Option<String>,
    id: Option<Value>,
    properties: Option<Map<String, Value>>,
    arcs: Option<Value>,
    geometries: Option<Vec<Value>>,
}

/// Reads all polygons of all objects.
///
/// # Errors
/// [`IoError::Syntax`]; [`IoError::Empty`] if there is no polygon.
pub fn read(bytes: &[u8]) -> Result<JobInput, IoError> {
    let file: Topology = serde_json::from_slice(bytes)
        .map_err(|e| IoError::syntax(FORMAT, Place::Line(e.line()), e.to_string()))?;
    if file.kind != "Topology" {
        return Err(IoError::syntax(FORMAT, Place::Path("type".into()), "is not \"Topology\""));
    }
    let arcs: Vec<Vec<Point2>> = file.arcs.iter().map(|a| decode(a, file.transform.as_ref())).collect();
    let mut reader = Reader { arcs, jobs: Vec::new(), notes: Vec::new(), n_other: 0 };
    for (name, object) in &file.objects {
        reader.add(name, object, &format!("objects.{name}"), 0)?;
    }
    if reader.jobs.is_empty() {
        return Err(IoError::Empty { format: FORMAT, wanted: "polygon" });
    }
    if reader.n_other > 0 {
        reader.notes.push(format!("{} points and lines were left out", reader.n_other));
    }
    Ok(JobInput { input: Input::Jobs(reader.jobs), options: JobOptions::default(), notes: reader.notes })
}

/// The points of an arc: with a transform, sums of differences, then scaled and moved.
fn decode(arc: &[Vec<f64>], transform: Option<&Transform>) -> Vec<Point2> {
    let mut sum = Point2::ZERO;
    let mut point = |p: &Vec<f64>| {
        let p = if let [x, y, ..] = p[..] { Point2::new(x, y) } else { Point2::NAN };
        match transform {
            None => p,
            Some(t) => {
                sum += p;
                sum * Point2::from_array(t.scale) + Point2::from_array(t.translate)
            }
        }
    };
    arc.iter().map(&mut point).collect()
}

/// Depth of nested collections that is followed.
const MAX_DEPTH: usize = 16;

struct Reader {
    arcs: Vec<Vec<Point2>>,
    jobs: Vec<csalf_core::Job>,
    notes: Vec<String>,
    n_other: usize,
}

impl Reader {
    fn add(&mut self, fallback: &str, value: &Value, path: &str, depth: usize) -> Result<(), IoError> {
        let fail = |m: String| IoError::syntax(FORMAT, Place::Path(path.to_owned()), m);
        let g = Geometry::deserialize(value).map_err(|e| fail(e.to_string()))?;
        let property = |key: &str| g.properties.as_ref().and_then(|p| p.get(key).cloned());
        let id = || feature_name(|key| if key == "id" { g.id.clone() } else { None });
        let name = feature_name(property).or_else(id).unwrap_or_else(|| fallback.to_owned());
        let arcs = g.arcs.unwrap_or(Value::Null);
        match g.kind.as_deref() {
            Some("Polygon") => {
                let rings: Vec<Vec<i64>> = Vec::deserialize(&arcs).map_err(|e| fail(e.to_string()))?;
                let rings = self.rings(&rings, path)?;
                self.jobs.push(job_of_polygon(&name, rings, &mut self.notes));
            }
            Some("MultiPolygon") => {
                let parts: Vec<Vec<Vec<i64>>> = Vec::deserialize(&arcs).map_err(|e| fail(e.to_string()))?;
                for (k, rings) in parts.iter().enumerate() {
                    let rings = self.rings(rings, path)?;
                    let name = part_name(&name, k, parts.len());
                    self.jobs.push(job_of_polygon(&name, rings, &mut self.notes));
                }
            }
            Some("GeometryCollection") if depth < MAX_DEPTH => {
                for (k, member) in g.geometries.unwrap_or_default().iter().enumerate() {
                    self.add(&format!("{name}_{k}"), member, &format!("{path}.geometries[{k}]"), depth + 1)?;
                }
            }
            _ => self.n_other += 1,
        }
        Ok(())
    }

    /// Joins arcs to rings; ~i is arc i backwards. An arc begins where the one before it ends.
    fn rings(&self, rings: &[Vec<i64>], path: &str) -> Result<Vec<Vec<Point2>>, IoError> {
        let mut out = Vec::new();
        for ring in rings {
            let mut points: Vec<Point2> = Vec::new();
            for &i in ring {
                let k = usize::try_from(if i < 0 { !i } else { i }).ok();
                let arc = k.and_then(|k| self.arcs.get(k)).ok_or_else(|| {
                    IoError::syntax(FORMAT, Place::Path(path.to_owned()), format!("there is no arc {i}"))
                })?;
                let joint = usize::from(!points.is_empty());
                if i < 0 {
                    points.extend(arc.iter().rev().skip(joint));
                } else {
                    points.extend(arc.iter().skip(joint));
                }
            }
            out.push(points);
        }
        Ok(out)
    }
}
