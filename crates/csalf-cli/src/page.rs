//! `--report FILE.html`: one page with everything about a run; no network, no other file.
//!
//! The page (`page/`) is plain HTML, CSS and script; the mesh goes into it as base64 of 32-bit numbers, points relative
//! to the box of the mesh, so that nothing is lost far from the origin. About 60 bytes per quad.

use crate::json;
use base64::Engine as _;
use csalf_core::Meshed;
use csalf_geom::polygon::bounds;
use csalf_mesh::quality::QualityReport;
use csalf_mesh::quality::metrics::{self, SCALES, Scale, WARPAGE};
use csalf_model::ModelMesh;
use csalf_sizemap::SizeField;
use glam::DVec3;
use serde_json::{Map, Value, json};

/// What one mesh contributes to the page.
#[derive(Debug)]
pub struct Shown<'a> {
    /// What came out.
    pub meshed: &'a Meshed,
    /// Figures of the mesh.
    pub quality: &'a QualityReport,
    /// The sizes it was asked for.
    pub field: Option<&'a dyn SizeField>,
    /// Name, about, times: entries of the JSON report.
    pub entries: Map<String, Value>,
    /// A sentence about the input.
    pub about: &'a str,
}

/// The page for the meshes of one run, made by `command`. Cost O(n).
pub fn page(meshes: &[Shown<'_>], command: &str) -> String {
    let title = match meshes {
        [one] => one.entries.get("name").and_then(Value::as_str).unwrap_or("mesh").to_owned(),
        all => format!("{} meshes", all.len()),
    };
    let models: Vec<Value> = meshes.iter().map(|m| plane(m, command)).collect();
    assemble(&title, &models.into(), include_str!("page/plane.js"), HOW_PLANE)
}

/// What a whole model contributes to its page.
#[derive(Debug)]
pub struct ShownModel<'a> {
    /// The mesh of all faces.
    pub meshed: &'a ModelMesh,
    /// The entries of the full JSON report, with one entry per face.
    pub entries: Map<String, Value>,
    /// A sentence about the model.
    pub about: &'a str,
}

/// The page for a model, meshed by `command`: to be turned, its faces listed. Cost O(n).
pub fn model_page(shown: &ShownModel<'_>, command: &str) -> String {
    let title = shown.entries.get("name").and_then(Value::as_str).unwrap_or("model");
    let models = json!([space(shown, command)]);
    assemble(title, &models, include_str!("page/space.js"), HOW_SPACE)
}

/// What the view says of itself.
const HOW_PLANE: &str = "Drag to move, wheel or two fingers to zoom, arrows and + - 0 on the keyboard";
/// See [`HOW_PLANE`].
const HOW_SPACE: &str =
    "Drag to turn, shift or two fingers to move, wheel or pinch to zoom, arrows and + - 0 on the keyboard";

/// Puts a page together: its data, and the script of its view.
fn assemble(title: &str, models: &Value, view: &str, how: &str) -> String {
    // The text stands in a script element: no `<` may close it.
    let data = models.to_string().replace('<', "\\u003c");
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    let script = format!("{}\n{}", include_str!("page/common.js").trim_end(), view.trim_end());
    include_str!("page/page.html")
        .replacen("@TITLE@", &title, 1)
        .replace("@HOW@", how)
        .replacen("@CSS@", include_str!("page/page.css").trim_end(), 1)
        .replacen("@SCRIPT@", &script, 1)
        // The data comes last: nothing is looked for in it.
        .replacen("@DATA@", &data, 1)
}

fn space(shown: &ShownModel<'_>, command: &str) -> Value {
    let (mesh, heights) = shown.meshed.mesh.split();
    let points = || shown.meshed.mesh.points.iter();
    let low = points().fold(DVec3::INFINITY, |a, p| a.min(*p));
    let high = points().fold(DVec3::NEG_INFINITY, |a, p| a.max(*p));
    let (low, scale) = if low.x <= high.x { (low, (high - low).max_element()) } else { (DVec3::ZERO, 1.0) };
    let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
    let scales = SCALES.iter().filter(|s| s.name != "size_ratio").chain([&WARPAGE]);
    let metrics: Vec<Value> =
        scales.filter_map(|s| Some(metric(s, metrics::in_space(&mesh, &heights, s.name)?))).collect();
    let mut report = shown.entries.clone();
    let faces = report.remove("faces");
    report.insert("quality".into(), json::quality(&QualityReport::in_space(&mesh, &heights), false));
    json!({
        "about": shown.about,
        "command": command,
        "report": report,
        "origin": low.to_array(),
        "scale": scale,
        "points": base64(points().flat_map(|p| ((*p - low) / scale).to_array()).map(|x| x as f32), f32::to_le_bytes),
        "quads": base64(mesh.quads.iter().flatten().map(|v| v.0), u32::to_le_bytes),
        "triangles": "",
        "edges": "",
        "faces": faces,
        "face_of_quad": base64(shown.meshed.face_of_quad.iter().copied(), u32::to_le_bytes),
        "metrics": metrics,
    })
}

/// A metric and its values, for the page.
fn metric(s: &Scale, values: Vec<f64>) -> Value {
    let values = base64(values.into_iter().map(|x| x as f32), f32::to_le_bytes);
    json!({
        "name": s.name, "label": s.label, "good": s.good, "low": s.low, "high": s.high, "values": values
    })
}

fn plane(shown: &Shown<'_>, command: &str) -> Value {
    let mesh = &shown.meshed.mesh;
    let (low, high) = bounds(mesh.points.iter().copied()).unwrap_or_default();
    let scale = (high - low).max_element();
    let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
    let points = mesh.points.iter().flat_map(|p| ((*p - low) / scale).to_array());
    let edges = shown.meshed.sets.edges.iter().flat_map(|(_, e)| e.iter().flatten());
    let with_field = shown.field.is_some();
    let metrics: Vec<Value> = SCALES
        .iter()
        .filter(|s| s.name != "size_ratio" || with_field)
        .filter_map(|s| Some(metric(s, metrics::values(mesh, s.name, shown.field)?)))
        .collect();
    let mut report = shown.entries.clone();
    report.insert("quality".into(), json::quality(shown.quality, false));
    json!({
        "about": shown.about,
        "command": command,
        "report": report,
        "origin": [low.x, low.y],
        "scale": scale,
        "points": base64(points.map(|x| x as f32), f32::to_le_bytes),
        "quads": base64(mesh.quads.iter().flatten().map(|v| v.0), u32::to_le_bytes),
        "triangles": base64(mesh.triangles.iter().flatten().map(|v| v.0), u32::to_le_bytes),
        "edges": base64(edges.map(|v| v.0), u32::to_le_bytes),
        "metrics": metrics,
    })
}

fn base64<T>(values: impl Iterator<Item = T>, bytes: impl Fn(T) -> [u8; 4]) -> String {
    let raw: Vec<u8> = values.flat_map(bytes).collect();
    base64::engine::general_purpose::STANDARD.encode(raw)
}

/// The command line of this process, quoted where a shell would need it.
pub fn command_line() -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    let quote = |word: String| {
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    };
    let mut words = std::env::args_os().map(|w| w.to_string_lossy().into_owned());
    let program = words.next().unwrap_or_default();
    let program = std::path::Path::new(&program).file_stem().map_or("csalf".into(), |s| s.to_string_lossy());
    std::iter::once(quote(program.into_owned())).chain(words.map(quote)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_core::{Options, mesh};

    #[test]
    fn the_page_is_whole_and_asks_for_nothing() {
        let mut job = crate::commands::demo::plate();
        job.name = "plate </script> & \"co\"".into();
        let meshed = mesh(&job, &Options::default()).unwrap();
        let quality = QualityReport::new(&meshed.mesh, None, None);
        let mut entries = json::report(&meshed.report, true);
        entries.insert("name".into(), job.name.clone().into());
        entries.insert("mesh_s".into(), 0.5.into());
        let shown =
            Shown { meshed: &meshed, quality: &quality, field: None, entries, about: "@DATA@ of a test" };
        let page = page(&[shown], "csalf mesh 'a b.json'");
        for wrong in ["http://", "https://", "src=", "@CSS@", "@SCRIPT@", "@TITLE@", "@HOW@", "import "] {
            assert!(!page.contains(wrong), "{wrong}");
        }
        assert_eq!(page.matches("</script>").count(), 2);
        assert!(page.contains("<title>plate &lt;/script> &amp;"));
        let start = page.find("id=\"data\">").unwrap() + 10;
        let end = start + page[start..].find("</script>").unwrap();
        let data: Value = serde_json::from_str(&page[start..end]).unwrap();
        let decode = |key: &str| {
            base64::engine::general_purpose::STANDARD.decode(data[0][key].as_str().unwrap()).unwrap()
        };
        assert_eq!(decode("quads").len(), 16 * meshed.mesh.n_quads());
        assert_eq!(decode("points").len(), 8 * meshed.mesh.n_vertices());
        assert_eq!(data[0]["metrics"].as_array().unwrap().len(), SCALES.len() - 1);
        assert_eq!(data[0]["about"], "@DATA@ of a test");
    }
}
