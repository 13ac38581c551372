//! GeoJSON polygons (RFC 7946): each polygon is a job, named after its feature. Coordinates are taken as they are,
//! without any projection; a third one is dropped.

use crate::{
    Input, IoError, JobInput, JobOptions, Place,
    rings::{feature_name, job_of_polygon, part_name},
};
use csalf_geom::Point2;
use geojson::{Feature, GeoJson, GeometryValue, feature::Id};

const FORMAT: &str = "GeoJSON";

/// Reads polygons, multi-polygons, features and collections of them; other geometries are noted and left out.
///
/// # Errors
/// [`IoError::Syntax`]; [`IoError::Empty`] if there is no polygon.
pub fn read(bytes: &[u8]) -> Result<JobInput, IoError> {
    let text = std::str::from_utf8(bytes)
        .map_err(|e| IoError::syntax(FORMAT, Place::Byte(e.valid_up_to()), "not UTF-8"))?;
    let parsed: GeoJson = text
        .trim_start_matches('\u{feff}')
        .parse()
        .map_err(|e: geojson::Error| IoError::syntax(FORMAT, Place::Whole, e.to_string()))?;
    let mut out = Gathered::default();
    match &parsed {
        GeoJson::Geometry(g) => out.add("", &g.value, 0),
        GeoJson::Feature(f) => out.add_feature(f, 0),
        GeoJson::FeatureCollection(c) => {
            c.features.iter().enumerate().for_each(|(k, f)| out.add_feature(f, k))
        }
    }
    if out.jobs.is_empty() {
        return Err(IoError::Empty { format: FORMAT, wanted: "polygon" });
    }
    if out.n_other > 0 {
        out.notes.push(format!("{} points and lines were left out", out.n_other));
    }
    Ok(JobInput { input: Input::Jobs(out.jobs), options: JobOptions::default(), notes: out.notes })
}

/// Depth of nested collections that is followed; deeper ones are left out.
const MAX_DEPTH: usize = 16;

#[derive(Default)]
struct Gathered {
    jobs: Vec<csalf_core::Job>,
    notes: Vec<String>,
    n_other: usize,
}

impl Gathered {
    fn add_feature(&mut self, f: &Feature, k: usize) {
        let Some(g) = &f.geometry else { return };
        let id = f.id.as_ref().map(|id| match id {
            Id::String(s) => s.clone(),
            Id::Number(n) => n.to_string(),
        });
        let name =
            feature_name(|key| f.property(key).cloned()).or(id).unwrap_or_else(|| format!("feature{k}"));
        self.add(&name, &g.value, 0);
    }

    fn add(&mut self, name: &str, value: &GeometryValue, depth: usize) {
        let xy = |p: &geojson::Position| match p.as_slice() {
            [x, y, ..] => Point2::new(*x, *y),
            _ => Point2::NAN,
        };
        let polygon = |rings: &[Vec<geojson::Position>]| -> Vec<Vec<Point2>> {
            rings.iter().map(|r| r.iter().map(xy).collect()).collect()
        };
        match value {
            GeometryValue::Polygon { coordinates } => {
                self.jobs.push(job_of_polygon(name, polygon(coordinates), &mut self.notes));
            }
            GeometryValue::MultiPolygon { coordinates } => {
                for (k, p) in coordinates.iter().enumerate() {
                    let name = part_name(name, k, coordinates.len());
                    self.jobs.push(job_of_polygon(&name, polygon(p), &mut self.notes));
                }
            }
            GeometryValue::GeometryCollection { geometries } if depth < MAX_DEPTH => {
                for (k, g) in geometries.iter().enumerate() {
                    self.add(&part_name(name, k, geometries.len()), &g.value, depth + 1);
                }
            }
            _ => self.n_other += 1,
        }
    }
}
