//! Size queries and the building of background meshes.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use csalf_bench::{Random, jittered_background, wavy_loop};
use csalf_geom::Point2;
use csalf_sizemap::{Hint, SizeField, build::of_boundary, line::LineSizes};
use std::hint::black_box;

fn lookups(c: &mut Criterion, name: &str, field: &dyn SizeField) {
    let mut group = c.benchmark_group(format!("size/{name}"));
    group.throughput(Throughput::Elements(1));
    let mut rnd = Random(7);
    let random: Vec<_> =
        (0..1 << 16).map(|_| Point2::new(rnd.number() - 0.5, rnd.number() - 0.5) * 1.2).collect();
    let mut i = 0;
    let mut next = move || {
        i = (i + 1) & 0xffff;
        i
    };
    group.bench_function("random", |b| b.iter(|| field.h(black_box(random[next()]), &mut Hint::default())));
    let mut hint = Hint::default();
    group.bench_function("random, stale hint", |b| b.iter(|| field.h(black_box(random[next()]), &mut hint)));
    // Rows of points, one edge length apart.
    let row = |k: usize| Point2::new((k & 255) as f64 / 256.0 - 0.5, (k >> 8) as f64 / 256.0 - 0.5);
    group.bench_function("coherent", |b| b.iter(|| field.h(black_box(row(next())), &mut hint)));
    let outside = |k: usize| Point2::new((k & 255) as f64 / 256.0 - 0.5, 1.3);
    group.bench_function("outside", |b| b.iter(|| field.h(black_box(outside(next())), &mut hint)));
    group.bench_function("line of 8", |b| {
        b.iter(|| {
            let a = row(next());
            LineSizes::new(a, a + Point2::splat(0.05), field, &mut hint).wanted_segments()
        })
    });
    group.finish();
}

fn sizemap(c: &mut Criterion) {
    lookups(c, "100k triangles", &jittered_background(223));
    // Always valid: a star-shaped loop.
    if let Ok(field) = of_boundary(&[wavy_loop(4000)]) {
        lookups(c, "boundary 4k", &field);
    }
    let mut group = c.benchmark_group("build");
    group.sample_size(10);
    for n in [4_000, 20_000] {
        let nodes = [wavy_loop(n)];
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(format!("boundary {n}"), |b| b.iter(|| of_boundary(black_box(&nodes))));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_secs(1));
    targets = sizemap
}
criterion_main!(benches);
