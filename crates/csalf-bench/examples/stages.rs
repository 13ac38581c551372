//! Where the time of whole meshes goes: the stages of each job, in microseconds per quad, the least of some runs.
//!
//! ```text
//!   cargo run --release -p csalf-bench --example stages -- [--runs N] [--threads N] FILE.json ...
//! ```
//!
//! Reads what the benchmarks need of the JSON job format (loops, scars, points, uniform and boundary sizes, sources,
//! layers by count), without the program's readers, so that it builds quickly.
#![allow(clippy::print_stdout, reason = "a program")]

use cpu_time::ProcessTime;
use csalf_bench::job_of_json;
use csalf_core::{Options, mesh};
use csalf_mesh::quality::QualityReport;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut runs, mut threads, mut files) = (5usize, 1usize, Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(a) = args.next() {
        let mut number = || args.next().and_then(|v| v.parse().ok()).ok_or("a number is missing");
        match a.as_str() {
            "--runs" => runs = number()?,
            "--threads" => threads = number()?,
            _ => files.push(a),
        }
    }
    let options = Options { threads, ..Options::default() };
    println!("{:<24} {:>8} {:>8} {:>8} | us per quad", "job", "quads", "cpu ms", "wall ms");
    let mut total = 0.0;
    for file in files {
        let job = job_of_json(&std::fs::read_to_string(&file)?).ok_or("not a job")?;
        let mut best: Option<(f64, csalf_core::Meshed)> = None;
        for _ in 0..runs {
            let start = ProcessTime::try_now()?;
            let meshed = mesh(&job, &options)?;
            let cpu = start.try_elapsed()?.as_secs_f64();
            if best.as_ref().is_none_or(|b| cpu < b.0) {
                best = Some((cpu, meshed));
            }
        }
        let Some((cpu, meshed)) = best else { continue };
        total += cpu;
        let n = meshed.mesh.n_quads();
        let t = &meshed.report.timing;
        let per = 1e6 / n as f64;
        let stages: Vec<String> = t.stages.iter().map(|(name, s)| format!("{name} {:.2}", s * per)).collect();
        let q = QualityReport::new(&meshed.mesh, None, None);
        println!(
            "{:<24} {n:>8} {:>8.3} {:>8.3} | {:.2}: {} | min {:.3} mean {:.4} irregular {}",
            job.name,
            cpu * 1e3,
            t.wall_s * 1e3,
            cpu * per,
            stages.join(" "),
            q.min_sj,
            q.mean_sj,
            q.n_irregular,
        );
    }
    println!("total {:.3} ms", total * 1e3);
    Ok(())
}
