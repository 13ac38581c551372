//! `cargo xtask gallery`: pictures of fixtures and of models made by code, for the book.
//!
//! ```text
//!   fixtures, shapes ──mesh──▶ docs/images/gallery/*.svg ──▶ docs/gallery.md, with the figures beside
//! ```

use crate::generated::put;
use crate::{Outcome, say};
use csalf_core::{Options, mesh};
use csalf_io::{MeshView, picture};
use csalf_mesh::quality::QualityReport;
use csalf_mesh::{NamedSets, QuadMesh};
use csalf_model::brep::Model;
use csalf_model::geometry::{Frame, Surface};
use csalf_model::shapes::{
    Piece, circle, closed_surface, cone, extrude, half_sphere, panel, rectangle, sheet,
};
use csalf_model::{LayerSpec, ModelOptions, SizeRules, mesh_model};
use csalf_testkit::fixtures;
use glam::DVec2;
use std::fmt::Write;
use std::path::Path;

const HEAD: &str = "\
# Gallery

Made by `cargo xtask gallery`; `cargo xtask gallery --check` tells whether it is up to date. Colours: the scaled Jacobian,
from orange (0) over yellow to green (1); layers blue; red dots: irregular vertices.

## Outlines

The jobs are in `fixtures/NAME/job.json`: `csalf mesh fixtures/NAME/job.json -o NAME.vtu -o NAME.svg` makes these pictures.
";

const MODELS: &str = "
## Models

Made by `csalf_model::shapes`, with two layers round every hole; a model from a file goes the same way:
`csalf mesh part.step -o part.vtu -o part.svg --layers 'hole*=2'`.
";

/// What is shown of the fixtures, in this order.
const OUTLINES: [&str; 11] = [
    "ring_and_scar_layers",
    "sprocket",
    "welded_plate",
    "freeform_face",
    "disk_sources",
    "plate_layers",
    "sieve",
    "glyph_r",
    "spiral",
    "rake",
    "kissing_holes",
];

/// Writes (or compares) docs/gallery.md and its pictures.
///
/// # Errors
/// Something is not meshed; a file cannot be written; with `check`, one differs.
pub(crate) fn run(root: &Path, check: bool) -> Outcome {
    let mut text = HEAD.to_owned();
    let jobs = fixtures::all();
    for name in OUTLINES {
        let job = jobs.iter().find(|j| j.name == name).ok_or_else(|| format!("no fixture {name}"))?;
        let m = mesh(job, &Options::default()).map_err(|e| format!("{name}: {e}"))?;
        let quality = QualityReport::new(&m.mesh, None, None);
        show(root, check, &mut text, (name, &job.about), (&m.mesh, &[], &m.sets), &quality)?;
    }
    text.push_str(MODELS);
    for (name, about, model, size) in models() {
        let layers = vec![("hole*".to_owned(), LayerSpec { count: 2, ..LayerSpec::default() })];
        let options = ModelOptions { size: Some(SizeRules::of(size)), layers, ..ModelOptions::default() };
        let m = mesh_model(&model, &options);
        if let Some(f) = m.failures.first() {
            return Err(format!("{name}: {}: {}", f.name, f.message));
        }
        let (flat, heights) = m.mesh.split();
        let quality = QualityReport::in_space(&flat, &heights);
        show(root, check, &mut text, (name, about), (&flat, &heights, &m.sets), &quality)?;
    }
    put(root, "docs/gallery.md", &text, check, "gallery")
}

/// Draws a mesh and adds it to the page.
fn show(
    root: &Path,
    check: bool,
    text: &mut String,
    (name, about): (&str, &str),
    (mesh, heights, sets): (&QuadMesh, &[f64], &NamedSets),
    quality: &QualityReport,
) -> Outcome {
    let view = MeshView { mesh, heights, sets, cell_data: &[], title: name };
    let mut drawn = Vec::new();
    picture::write_svg(&view, &mut drawn).map_err(|e| format!("{name}: {e}"))?;
    let drawn = String::from_utf8(drawn).map_err(|e| e.to_string())?;
    let file = format!("images/gallery/{name}.svg");
    put(root, &format!("docs/{file}"), &drawn, check, "gallery")?;
    let _ = write!(
        text,
        "\n### {name}\n\n{about}: {} quads, scaled Jacobian at least {:.2}, mean {:.3}, {:.1} % of the inner vertices irregular.\n\n\
         ![{name}]({file})\n",
        quality.n_quads,
        quality.min_sj,
        quality.mean_sj,
        100.0 * quality.irregular_share.unwrap_or(0.0)
    );
    say(&format!("{name:24} {} quads", quality.n_quads));
    Ok(())
}

/// Name, what it is, the model, the size.
fn models() -> Vec<(&'static str, &'static str, Model, f64)> {
    let p = DVec2::new;
    let mut block = vec![rectangle(80.0, 50.0), vec![circle(p(40.0, 25.0), 12.0).reversed()]];
    block.extend(
        [(12.0, 12.0), (68.0, 12.0), (12.0, 38.0), (68.0, 38.0)]
            .map(|(x, y)| vec![circle(p(x, y), 4.0).reversed()]),
    );
    let hat =
        [(0.0, 0.0), (15.0, 0.0), (25.0, 20.0), (55.0, 20.0), (65.0, 0.0), (80.0, 0.0)].map(|(x, y)| p(x, y));
    let hat: Vec<Piece> = hat.windows(2).map(|w| Piece::Line(w[0], w[1])).collect();
    let torus = Surface::Torus { frame: Frame::WORLD, major: 10.0, minor: 4.0 };
    vec![
        ("bolted_block", "block with a bore and four bolt holes", extrude(&block, 20.0), 3.0),
        ("hat_section", "hat section, a sheet of five faces", sheet(&hat, 100.0), 4.0),
        ("panel", "corrugated panel with holes", panel(6, 3), 0.7),
        ("dome", "half a sphere on a disk", half_sphere(10.0), 1.2),
        ("cone", "cone with its apex, on a disk", cone(10.0, 18.0), 1.2),
        ("torus", "torus, one face without edges", closed_surface(torus), 1.4),
    ]
}
