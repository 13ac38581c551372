//! `cargo xtask paper`: the experiments of the CSALF-Q paper, rebuilt as cases made by code.
//!
//! ```text
//!   case (Figs. 4 to 8) ──▶ tqm, paper, csalf ──▶ figures ─┬─▶ table in docs/paper.md
//!                                                          └─▶ docs/images/paper/*.svg
//! ```
//!
//! The paper prints no coordinates: the cases here have its proportions, in the plane. Times are told on the
//! terminal only, so that `--check` compares what does not depend on the machine.

mod cases;

use crate::generated::put;
use crate::{Outcome, say};
use cases::{Experiment, experiments};
use csalf_core::{Job, Meshed, Method, Options, mesh};
use csalf_geom::arrangement::{Arrangement, CheckOptions};
use csalf_geom::{Point2, VertexId};
use csalf_io::{MeshView, picture};
use csalf_mesh::quality::QualityReport;
use csalf_mesh::{NamedSets, QuadMesh};
use csalf_sizemap::{Extras, SizeField};
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

const METHODS: [(Method, &str); 3] =
    [(Method::Tqm, "tqm"), (Method::Paper, "paper"), (Method::Csalf, "csalf")];

const HEAD: &str = "\
# The paper's experiments

Made by `cargo xtask paper`; `cargo xtask paper --check` tells whether this file is up to date. Each case is meshed
three times: `tqm` is recursive subdivision alone, `paper` the flow and the formulas of the paper as printed, `csalf`
the default. The paper gives no coordinates, so the cases have its proportions, not its numbers.

| figure | meaning |
|---|---|
| tau_l | harmonic mean of Jmin/Jmax over the quads with their centre within 1.5 hole radii |
| tau_g | the same over all quads |
| angle | largest interior angle, degrees |
| mean SJ | mean scaled Jacobian |
| rings | closed rings around the loops, holes first, the outer loop last |
| row 1 | boundary segments whose quad has only regular nodes, % |
| irregular | inner nodes with other than four edges, % |
| size | inner edges within 0.7 to 1.4 of the wanted length, % |

`csalf` is better than `tqm` in tau_g, mean SJ and irregular share in every case. Its size share is within 0.05 of
`tqm`'s but where layers are asked for whose thickness is not the wanted size (fig4, fig5_fine).

A ring of n quads that are square at mid height allows tau_l = (n - π)/(n + π): 0.906 for 64, 0.981 for 320.
";

/// Writes (or compares) docs/paper.md and its pictures.
///
/// # Errors
/// A case is not meshed; a file cannot be written; with `check`, one differs.
pub(crate) fn run(root: &Path, check: bool) -> Outcome {
    let mut text = HEAD.to_owned();
    for e in experiments() {
        let _ = write!(text, "\n## {}\n\n{}\n\n", e.title, e.about);
        text.push_str(
            "| case | method | quads | tau_l | tau_g | angle | mean SJ | rings | row 1 | irregular | size |\n\
             |---|---|--:|--:|--:|--:|--:|---|--:|--:|--:|\n",
        );
        let mut shown = String::new();
        for job in &e.jobs {
            for (method, name) in METHODS {
                let m = mesh(job, &Options { method, ..Options::default() })
                    .map_err(|error| format!("{} by {name}: {error}", job.name))?;
                say(&format!("{:16} {name:6} {:7.3} s", job.name, m.report.timing.wall_s));
                text.push_str(&row(job, name, &m)?);
                if method == Method::Paper || (method == Method::Tqm && e.jobs.len() > 1) {
                    continue; // pictures of what is worth comparing
                }
                let file = format!("images/paper/{}-{name}.svg", job.name);
                put(root, &format!("docs/{file}"), &draw(job, name, &m, &e)?, check, "paper")?;
                let _ = writeln!(shown, "![{} by {name}]({file})", job.name);
            }
        }
        let _ = write!(text, "\n{shown}");
    }
    put(root, "docs/paper.md", &text, check, "paper")
}

/// One line of the table.
fn row(job: &Job, method: &str, m: &Meshed) -> Result<String, String> {
    let field = field(job)?;
    let r = QualityReport::new(&m.mesh, Some(field.as_ref()), job.local_region);
    let figure = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.2}"));
    let percent = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{:.1}", 100.0 * x));
    let rings = r.structure.as_ref().map_or_else(String::new, |s| {
        // Loops come in the order of the input: the outer one first.
        let mut n = s.closed_rings_per_loop.clone();
        let first = n.len().min(1);
        n.rotate_left(first);
        n.iter().map(usize::to_string).collect::<Vec<_>>().join(" ")
    });
    Ok(format!(
        "| {} | {method} | {} | {} | {:.2} | {:.0} | {:.3} | {rings} | {} | {} | {} |\n",
        job.name,
        r.n_quads,
        figure(r.tau_local),
        r.tau_global.unwrap_or(0.0),
        r.max_angle,
        r.mean_sj,
        percent(r.structure.as_ref().map(|s| s.row1_share)),
        percent(r.irregular_share),
        percent(r.size.as_ref().map(|s| s.share)),
    ))
}

/// The size field as the job gives it, against which all methods are measured.
fn field(job: &Job) -> Result<Arc<dyn SizeField>, String> {
    let a = Arrangement::new(&job.domain, &CheckOptions::default()).map_err(|e| format!("{e:?}"))?;
    let points = |l: &Vec<u32>| l.iter().map(|&v| a.points[v as usize]).collect();
    let loops: Vec<Vec<Point2>> = a.loops.iter().map(points).collect();
    let extras = Extras { hard_points: &[], gradation: None };
    csalf_sizemap::build(&job.size, &loops, &extras, a.tolerance).map_err(|e| e.to_string())
}

/// A picture of the part of the mesh within the frame.
fn draw(job: &Job, method: &str, m: &Meshed, e: &Experiment) -> Result<String, String> {
    let [lo, hi] = e.frame;
    let inside = |q: &[VertexId; 4]| {
        let p = q.map(|v| m.mesh.points[v.index()]);
        let c = (p[0] + p[1] + p[2] + p[3]) * 0.25;
        c.cmpge(lo).all() && c.cmple(hi).all()
    };
    // Quads of the picture, and where the others have gone.
    let mut number = vec![None; m.mesh.quads.len()];
    let mut part = QuadMesh { points: m.mesh.points.clone(), ..QuadMesh::default() };
    for (k, q) in m.mesh.quads.iter().enumerate().filter(|(_, q)| inside(q)) {
        number[k] = Some(csalf_geom::QuadId::new(part.quads.len()));
        part.quads.push(*q);
    }
    compact(&mut part);
    let quads = m
        .sets
        .quads
        .iter()
        .map(|(name, ids)| (name.clone(), ids.iter().filter_map(|q| number[q.index()]).collect()));
    let sets = NamedSets { quads: quads.collect(), ..NamedSets::default() };
    let title = format!("{} by {method}", job.name);
    let view = MeshView { mesh: &part, heights: &[], sets: &sets, cell_data: &[], title: &title };
    let mut out = Vec::new();
    picture::write_svg(&view, &mut out).map_err(|e| e.to_string())?;
    String::from_utf8(out).map_err(|e| e.to_string())
}

/// Drops the points that no quad uses.
fn compact(mesh: &mut QuadMesh) {
    let old = std::mem::take(&mut mesh.points);
    let mut number = vec![None; old.len()];
    for v in mesh.quads.iter_mut().flatten() {
        *v = *number[v.index()].get_or_insert_with(|| {
            mesh.points.push(old[v.index()]);
            VertexId::new(mesh.points.len() - 1)
        });
    }
}
