//! Meshes faces made by code and prints their figures; with a folder as argument, writes each mesh there as `.obj`.

#![allow(clippy::print_stdout, reason = "a program")]

#[path = "../tests/shapes/mod.rs"]
mod shapes;

use csalf_core::{Method, Options};
use csalf_surface::{DVec3, FaceInput, FaceMesh, FaceSize, Quality3d, mesh_face};
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

/// Triangles (or polygons, as fans) of an `.obj`.
fn read_obj(file: &str) -> Shape {
    let mut facets = csalf_surface::Facets::default();
    for line in std::fs::read_to_string(file).unwrap_or_default().lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let x: Vec<f64> = words.filter_map(|w| w.parse().ok()).collect();
                facets.points.push(DVec3::new(x[0], x[1], x[2]));
            }
            Some("f") => {
                let id = |w: &str| w.split('/').next().and_then(|w| w.parse::<u32>().ok()).map(|i| i - 1);
                let v: Vec<u32> = words.filter_map(id).collect();
                facets.triangles.extend((1..v.len() - 1).map(|k| [v[0], v[k], v[k + 1]]));
            }
            _ => {}
        }
    }
    let loops = shapes::boundary(&facets, 1);
    Shape { facets, loops }
}

/// The paper's Fig. 5: a dome with a hole, sizes 1 : 10; tau within 1.5 radii of the hole and over all.
fn fig5() {
    let hole = 0.13f64;
    let shape = shapes::dome(hole, 1.3356, 64, 48);
    let loops = &shape.loops;
    let input = FaceInput {
        facets: &shape.facets,
        loops,
        scars: &[],
        points: &[],
        size: FaceSize::Boundary,
        flat: None,
        surface: None,
    };
    for method in [Method::Csalf, Method::Paper, Method::Tqm] {
        let Ok(m) = mesh_face(&input, &Options { method, ..Options::default() }) else { continue };
        let near = |q: &&[u32; 4]| {
            let c = 0.25 * q.iter().map(|&v| m.points[v as usize]).sum::<DVec3>();
            c.truncate().length() <= 1.5 * hole.sin() && c.z > 0.0
        };
        let local: Vec<[u32; 4]> = m.quads.iter().filter(near).copied().collect();
        let l = Quality3d::measure(&m.points, &m.normals, &local);
        let q = m.report.quality;
        println!(
            "fig5 {method:?}: {} quads, tau_l {:.3} ({} quads), tau_g {:.3}, sj {:.3} {:.3}, rings {:?}",
            m.quads.len(),
            l.tau,
            local.len(),
            q.tau,
            q.min_sj,
            q.mean_sj,
            m.report.layers
        );
    }
}

fn main() {
    fig5();
    let args: Vec<String> = std::env::args().skip(1).collect();
    let mut cases: Vec<(&str, Shape, FaceSize<'static>)> = vec![
        ("coarse", shapes::beast(16), FaceSize::Uniform(0.25)),
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
    if let (Some(file), Some(size)) = (args.get(2), args.get(3)) {
        let h = size.parse().unwrap_or(0.1);
        cases.push(("file", read_obj(file), FaceSize::Uniform(h)));
    }
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
                     warp {:.3} dev {:.4} bad {} healed {} | {:.0} ms {:?}",
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
                    r.n_healed,
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
