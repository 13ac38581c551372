//! Meshes models at several sizes and measures what must hold: all faces, all quads, conforming, nodes on their surfaces,
//! normals the right way, quality in space.
//!
//! `cargo run --release -p csalf-step --example survey -- SIZES FILE...`: sizes are shares of the diagonal, separated by
//! commas (`0.025,0.01`); files are `.step`, `.stl`, `.obj`, `.ply`, or `panel:NxM` for the panel of the benches.

#![allow(clippy::print_stdout, reason = "a program")]

use csalf_geom::QuadId;
use csalf_io::facets::{FacetFormat, read as read_facets};
use csalf_model::brep::{FaceShape, Model};
use csalf_model::facets::{FacetOptions, model_of_triangles};
use csalf_model::geometry::{Inverter, Surface};
use csalf_model::shapes::panel;
use csalf_model::{ModelMesh, ModelOptions, SizeRules, check_and_snap, mesh_model, sew};
use glam::DVec3;
use std::path::Path;
use std::time::Instant;

/// A quad below this is poor.
const POOR: f64 = 0.2;

fn main() {
    let mut args = std::env::args().skip(1);
    let sizes: Vec<f64> = args.next().unwrap_or_default().split(',').filter_map(|s| s.parse().ok()).collect();
    println!(
        "file size faces quads free branching off/diagonal turned min-sj mean-sj poor corner-bound warnings s"
    );
    for file in args {
        let path = Path::new(&file);
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let model = match read(path) {
            Ok(m) => m,
            Err(e) => {
                println!("{name}: {e}");
                continue;
            }
        };
        for note in &model.notes {
            println!("  note: {note}");
        }
        for s in &sizes {
            let h = s * model.diagonal();
            let options = ModelOptions { size: Some(SizeRules::of(h)), ..ModelOptions::default() };
            let start = Instant::now();
            let m = mesh_model(&model, &options);
            let seconds = start.elapsed().as_secs_f64();
            measure(&format!("{name} {s}"), &model, &m, seconds);
        }
    }
}

fn read(path: &Path) -> Result<Model, String> {
    if let Some((n, m)) = path.to_string_lossy().strip_prefix("panel:").and_then(|s| s.split_once('x')) {
        let number = |s: &str| s.parse::<usize>().map_err(|e| e.to_string());
        return Ok(panel(number(n)?, number(m)?));
    }
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let mut model = if extension == "step" || extension == "stp" {
        csalf_step::read(&bytes).map_err(|e| e.to_string())?
    } else {
        let format = FacetFormat::from_name(&extension).ok_or("unknown format")?;
        let data = read_facets(format, &bytes).map_err(|e| e.to_string())?;
        let points: Vec<DVec3> = data.points.into_iter().map(DVec3::from_array).collect();
        model_of_triangles(&points, &data.triangles, &FacetOptions::default())
    };
    let tolerance = 1e-6 * model.diagonal();
    sew(&mut model, tolerance);
    let report = check_and_snap(&mut model);
    model.notes.extend(report.messages);
    Ok(model)
}

/// The surface's normal on the face's side, by a point near it.
fn normal(surface: &Surface, inverter: &Inverter<'_>, forward: bool, p: DVec3) -> (DVec3, f64) {
    let (uv, d) = inverter.invert(p, None, 0.0);
    let n = match surface {
        Surface::Sphere { frame, .. } => (p - frame.origin).normalize_or_zero(),
        _ => surface.eval(uv).normal(),
    };
    (if forward { n } else { -n }, d)
}

fn measure(what: &str, model: &Model, m: &ModelMesh, seconds: f64) {
    let diagonal = model.diagonal();
    let inverters: Vec<Option<Inverter<'_>>> = model
        .faces
        .iter()
        .map(|f| match &f.shape {
            FaceShape::Surface(s, _) => Some(Inverter::new(s)),
            FaceShape::Facets(_) | FaceShape::Unread => None,
        })
        .collect();
    let (mut off, mut turned, mut least, mut sum, mut poor) = (0.0_f64, 0, f64::INFINITY, 0.0, 0);
    let mut worst = (f64::INFINITY, 0, DVec3::ZERO);
    for (q, f) in m.face_of_quad.iter().enumerate() {
        let p = m.mesh.corners(QuadId(q as u32));
        let mut n = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
        if let (FaceShape::Surface(s, forward), Some(i)) =
            (&model.faces[*f as usize].shape, &inverters[*f as usize])
        {
            let mut sum = DVec3::ZERO;
            for c in p {
                let (n, d) = normal(s, i, *forward, c);
                sum += n;
                if d > off {
                    off = d;
                    if d > 1e-6 * diagonal {
                        println!("  off {:.1e}: {} at {c}", d / diagonal, model.faces[*f as usize].name);
                    }
                }
            }
            if n.dot(sum) <= 0.0 {
                turned += 1;
                n = -n;
            }
        }
        let corner = |k: usize| {
            let (a, b) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
            let l = a.length() * b.length();
            if l > 0.0 { a.cross(b).dot(n) / l } else { -1.0 }
        };
        let sj = (0..4).map(corner).fold(1.0, f64::min);
        sum += sj;
        least = least.min(sj);
        poor += usize::from(sj < POOR);
        if sj < worst.0 {
            worst = (sj, *f as usize, p[0]);
        }
    }
    let n = m.face_of_quad.len().max(1);
    println!(
        "{what} {}/{} {} {} {} {:.1e} {turned} {least:.3} {:.4} {poor} {:.3} {} {seconds:.2}",
        model.faces.len() - m.failures.len(),
        model.faces.len(),
        m.face_of_quad.len(),
        m.n_free_sides,
        m.n_branching_sides,
        off / diagonal,
        sum / n as f64,
        corner_bound(model),
        m.warnings.len(),
    );
    if worst.0 < 0.4 {
        let face = &model.faces[worst.1];
        println!("  worst {:.3} in {} ({}) at {}", worst.0, face.name, face.shape.kind(), worst.2);
    }
    for f in &m.failures {
        println!("  FAILED {}: {}", f.name, f.message);
    }
    for w in m.warnings.iter().filter(|w| !model.notes.contains(w)).take(6) {
        println!("  {w}");
    }
}

/// Sine of the sharpest angle between successive edges of a loop of a surface's face: no quad there can be better.
fn corner_bound(model: &Model) -> f64 {
    const SHORT: f64 = 1e-3;
    let mut least = 1.0_f64;
    for face in &model.faces {
        for l in &face.loops {
            for (i, u) in l.uses.iter().enumerate() {
                let w = &l.uses[(i + 1) % l.uses.len()];
                let (e, g) = (&model.edges[u.edge], &model.edges[w.edge]);
                let share = |forward: bool, s: f64| if forward { s } else { 1.0 - s };
                let here = e.at(share(u.forward, 1.0)).point;
                let back = e.at(share(u.forward, 1.0 - SHORT)).point - here;
                let on = g.at(share(w.forward, SHORT)).point - here;
                let angle = back.cross(on).length().atan2(back.dot(on));
                if angle < std::f64::consts::FRAC_PI_2 {
                    least = least.min(angle.sin());
                }
            }
        }
    }
    least
}
