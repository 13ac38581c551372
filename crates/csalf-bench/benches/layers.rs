//! Layers round the holes of perforated plates: the rings alone, and the whole meshing.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use csalf_bench::perforated;
use csalf_core::{Job, Options, mesh};
use csalf_geom::{Domain, Tolerance};
use csalf_pave::{LayerTask, PavingRules, Walk, WalkKind, pave_layers};
use csalf_sizemap::{SizeSpec, Uniform};
use std::hint::black_box;

/// Quads of the rings per second: the same for 100 and 10,000 holes but for a logarithm.
fn rings(c: &mut Criterion) {
    let mut group = c.benchmark_group("rings");
    group.sample_size(10);
    for k in [10, 32, 100] {
        let loops = perforated(k);
        let points = loops.concat();
        let mut first = 0;
        let walks: Vec<Walk> = loops
            .iter()
            .enumerate()
            .map(|(i, l)| {
                let nodes = (first..first + l.len() as u32).collect();
                first += l.len() as u32;
                Walk { nodes, kind: if i == 0 { WalkKind::Outer } else { WalkKind::Hole }, asked: None }
            })
            .collect();
        let task = LayerTask {
            points: &points,
            walks: &walks,
            size: &Uniform(1.0),
            tolerance: Tolerance::of_points(points.iter().copied()),
            rules: PavingRules::Corrected,
            defaults: true,
            partial: true,
        };
        group.throughput(Throughput::Elements(pave_layers(&task).quads.len() as u64));
        group.bench_function(format!("{} holes", k * k), |b| b.iter(|| pave_layers(black_box(&task))));
    }
    group.finish();
}

/// Quads per second of the whole meshing on one thread, layers included. The plate of 10,000 holes takes a minute:
/// `cargo bench -p csalf-bench --bench layers -- 10000`.
fn plates(c: &mut Criterion) {
    let mut group = c.benchmark_group("perforated");
    group.sample_size(10);
    let options = Options { threads: 1, ..Options::default() };
    for k in [10, 100] {
        let loops = perforated(k);
        let mut domain = Domain::new(loops[0].clone());
        for l in &loops[1..] {
            domain = domain.with_hole(l.clone());
        }
        let job = Job { domain, size: SizeSpec::Uniform { h: 1.0 }, ..Job::default() };
        group.throughput(Throughput::Elements(70 * (k * k) as u64));
        group.bench_function(format!("{} holes", k * k), |b| {
            b.iter(|| mesh(black_box(&job), &options).is_ok())
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_secs(1));
    targets = rings, plates
}
criterion_main!(benches);
