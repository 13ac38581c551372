//! Whole meshes of a wavy disk, 1 thousand to 1 million quads, on one thread and on all.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use csalf_bench::wavy_loop;
use csalf_core::{Job, Options, mesh};
use csalf_geom::Domain;
use std::f64::consts::PI;
use std::hint::black_box;

fn meshes(c: &mut Criterion) {
    let mut group = c.benchmark_group("mesh");
    group.sample_size(10);
    for quads in [1_000usize, 10_000, 100_000, 1_000_000] {
        // About pi / h² quads, 2 pi / h boundary nodes, an even number.
        let n = ((4.0 * PI * quads as f64).sqrt() / 2.0).round() as usize * 2;
        let job = Job { domain: Domain::new(wavy_loop(n)), ..Job::default() };
        group.throughput(Throughput::Elements(quads as u64));
        for (threads, name) in [(1, "one thread"), (0, "all threads")] {
            let options = Options { threads, ..Options::default() };
            group.bench_function(format!("{quads} quads, {name}"), |b| {
                b.iter(|| mesh(black_box(&job), &options))
            });
        }
    }
    group.finish();
}

criterion_group!(benches, meshes);
criterion_main!(benches);
