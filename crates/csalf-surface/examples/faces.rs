//! Meshes faces made by code and prints their figures; with a folder as argument, writes each mesh there as
//! `.obj`.

#![allow(clippy::print_stdout, reason = "a program")]

#[path = "../tests/shapes/mod.rs"]
mod shapes;

use csalf_core::{Job, Method, Options};
use csalf_geom::Domain;
use csalf_surface::{DVec3, FaceInput, FaceMesh, FaceSize, Quality3d, mesh_face};
use shapes::Shape;
use std::fmt::Write as _;
use std::time::Instant;

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

/// A patch, tube or torus of 8 x 8 cells with spikes.
fn rough(k: usize) -> Shape {
    let mut seed = 12345u64;
    let z: Vec<f64> = (0..81)
        .map(|_| {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as f64 / f64::from(1u32 << 30) - 1.0
        })
        .collect();
    let facets = shapes::grid(8, 8, (k > 0, k > 1), |s, t| {
        let i = (8.0 * t).round() as usize * 9 + (8.0 * s).round() as usize;
        let (a, b) = (std::f64::consts::TAU * s, std::f64::consts::TAU * t);
        let bump = 0.18 * z[i];
        match k {
            0 => DVec3::new(s, t, bump),
            1 => DVec3::new((1.0 + bump) * a.cos(), (1.0 + bump) * a.sin(), 3.0 * t),
            _ => {
                let r = 3.0 + (1.0 + bump) * b.cos();
                DVec3::new(r * a.cos(), r * a.sin(), (1.0 + bump) * b.sin())
            }
        }
    });
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

/// CPU-bound time of small faces beside that of the planar mesher alone, in this thread.
fn speed() {
    let flat = shapes::disc(6, |x, y| DVec3::new(x, y, 0.0));
    let bent = shapes::gutter(1.5, 2.0, 24, 12);
    let plane = Shape { loops: shapes::boundary(&flat, 1), facets: flat };
    let dome = shapes::cap(0.8, 6, 1);
    for (name, s) in [("disc", &plane), ("cylinder", &bent), ("cap", &dome)] {
        let input = FaceInput {
            facets: &s.facets,
            loops: &s.loops,
            scars: &[],
            points: &[],
            size: FaceSize::Boundary,
            flat: None,
            surface: None,
        };
        let outline = s.loops[0].nodes.iter().map(|&v| s.facets.points[v as usize]);
        let outline = outline.map(|p| match name {
            "cylinder" => glam::DVec2::new(p.y.atan2(p.x), p.z),
            _ => p.truncate(),
        });
        let job = Job { domain: Domain::new(outline.collect()), ..Job::default() };
        let mut best = [f64::INFINITY; 2];
        let mut n = 0;
        for _ in 0..5 {
            let t = Instant::now();
            for _ in 0..40 {
                n = mesh_face(&input, &Options::default()).map_or(0, |m| m.quads.len());
            }
            best[0] = best[0].min(t.elapsed().as_secs_f64() / 40.0);
            let t = Instant::now();
            for _ in 0..40 {
                let _ = csalf_core::mesh(&job, &Options::default());
            }
            best[1] = best[1].min(t.elapsed().as_secs_f64() / 40.0);
        }
        println!("{name}: {n} quads, face {:.0} us, plane alone {:.0} us", 1e6 * best[0], 1e6 * best[1]);
    }
}

fn main() {
    if std::env::args().nth(1).is_some_and(|a| a == "speed") {
        return speed();
    }
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
    let mut spike = Shape {
        facets: shapes::grid(8, 8, (false, false), |s, t| DVec3::new(s, t, 0.3 * (5.0 * s).sin() * t)),
        loops: Vec::new(),
    };
    spike.loops = shapes::boundary(&spike.facets, 1);
    for (v, d) in [(2, 0.050723326236938676), (11, 1.5074577791973205)] {
        spike.facets.points[v] += DVec3::new(d, -d, 0.5 * d);
    }
    cases.push(("spike", spike, FaceSize::Boundary));
    for (k, name) in ["rough0", "rough1", "rough2"].into_iter().enumerate() {
        cases.push((name, rough(k), if k == 2 { FaceSize::Uniform(0.5) } else { FaceSize::Boundary }));
    }
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
        let start = Instant::now();
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
