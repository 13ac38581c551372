//! A corrugated panel of many faces, meshed as one model: quads per processor second, and what threads gain.
//!
//! ```text
//!   cargo run --release -p csalf-bench --example panel -- [--pieces N] [--bays N] [--size H] [--runs N]
//! ```
//!
//! 100 pieces by 100 bays are 10,000 faces: planes, planes with a hole, quarter cylinders.
#![allow(clippy::print_stdout, reason = "a program")]

use cpu_time::ProcessTime;
use csalf_model::shapes::panel;
use csalf_model::{ModelMesh, ModelOptions, SizeRules, mesh_model};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut pieces, mut bays, mut size, mut runs) = (100, 100, 1.0, 3);
    let mut args = std::env::args().skip(1);
    while let Some(a) = args.next() {
        let value = args.next().ok_or("a number is missing")?;
        match a.as_str() {
            "--pieces" => pieces = value.parse()?,
            "--bays" => bays = value.parse()?,
            "--size" => size = value.parse()?,
            "--runs" => runs = value.parse()?,
            _ => return Err(format!("what is {a}?").into()),
        }
    }
    let model = panel(pieces, bays);
    let options = ModelOptions { size: Some(SizeRules::of(size)), ..ModelOptions::default() };
    let mut wall_of_one = None;
    let mut first: Option<ModelMesh> = None;
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let (mut cpu, mut wall) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..runs {
            let (c, w) = (ProcessTime::try_now()?, Instant::now());
            let m = pool.install(|| mesh_model(&model, &options));
            (cpu, wall) = (cpu.min(c.try_elapsed()?.as_secs_f64()), wall.min(w.elapsed().as_secs_f64()));
            match &first {
                None => first = Some(m),
                Some(f) => assert!(f.mesh == m.mesh, "the mesh depends on the threads"),
            }
        }
        let Some(m) = &first else { break };
        let n = m.mesh.quads.len();
        println!(
            "{threads} threads: {} faces ({} failed), {n} quads, cpu {cpu:.3} s, wall {wall:.3} s, {:.0} quads per cpu \
             second, {:.2} times as fast as one thread; {} sides of three quads",
            model.faces.len(),
            m.failures.len(),
            n as f64 / cpu,
            *wall_of_one.get_or_insert(wall) / wall,
            m.n_branching_sides,
        );
    }
    Ok(())
}
