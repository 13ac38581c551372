//! Meshes faces made by code and prints their figures; with a folder as argument, writes each mesh there as `.obj`.

#[path = "../tests/shapes/mod.rs"]
mod shapes;

use csalf_core::Options;
use csalf_surface::{FaceInput, FaceMesh, FaceSize, mesh_face};
use shapes::Shape;
use std::fmt::Write as _;

fn obj(m: &FaceMesh) -> String {
    let mut out = String::new();
    for p in &m.points {
        let _ = writeln!(out, "v {} {} {}", p.x, p.y, p.z);
    }
    for q in &m.quads {
        let [a, b, c, d] = q.map(|v| v + 1);
        let _ = writeln!(out, "f {a} {b} {c} {d}");
    }
    out
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let cases: Vec<(&str, Shape, FaceSize<'static>)> = vec![
        ("dome", shapes::dome(0.1, 1.2, 36, 48), FaceSize::Boundary),
        ("cap", shapes::cap(1.5, 24, 3), FaceSize::Boundary),
        ("tube", shapes::tube(6.0, 48, 40, 2), FaceSize::Boundary),
        ("gutter", shapes::gutter(2.5, 2.0, 25, 20), FaceSize::Boundary),
        ("cone", shapes::cone(2.5, 24, 16), FaceSize::Boundary),
        ("saddle", shapes::saddle(0.7, 20), FaceSize::Boundary),
        ("torus", shapes::torus(3.0, 1.0, 60, 24), FaceSize::Uniform(0.25)),
        ("sphere", shapes::ball(16, |d| d), FaceSize::Uniform(0.12)),
        ("beast", shapes::beast(32), FaceSize::Uniform(0.1)),
    ];
    for (name, shape, size) in &cases {
        if args.get(1).is_some_and(|only| !only.split(',').any(|o| o == *name)) {
            continue;
        }
        let input = FaceInput {
            facets: &shape.facets,
            loops: &shape.loops,
            scars: &[],
            points: &[],
            size: *size,
            flat: None,
            surface: None,
        };
        let start = std::time::Instant::now();
        match mesh_face(&input, &Options::default()) {
            Ok(m) => {
                let (r, q) = (&m.report, &m.report.quality);
                println!(
                    "{name:8} facets {:6} quads {:6} charts {:2} {:?} aniso {:.2} scale {:.2} | sj {:.3} {:.4} tau {:.3} \
                     warp {:.3} dev {:.4} bad {} | {:.0} ms {:?}",
                    shape.facets.triangles.len(),
                    m.quads.len(),
                    r.n_charts,
                    r.flattening,
                    r.anisotropy,
                    r.scale_range,
                    q.min_sj,
                    q.mean_sj,
                    q.tau,
                    q.max_warpage,
                    q.max_deviation,
                    q.n_nonpositive,
                    start.elapsed().as_secs_f64() * 1e3,
                    r.warnings,
                );
                if let Some(folder) = args.first() {
                    let _ = std::fs::write(format!("{folder}/{name}.obj"), obj(&m));
                }
            }
            Err(e) => println!("{name:8} {e}"),
        }
    }
}
