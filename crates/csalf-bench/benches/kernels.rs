//! The kernels under the meshers: predicates, one pattern fill, one ring, one smoothing.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use csalf_bench::{Random, shaken_grid, wavy_loop};
use csalf_clean::smooth::{SmoothOptions, smooth};
use csalf_geom::{Point2, Tolerance, predicates::orient2d};
use csalf_mesh::{Contour, QuadTopology, RegionMesher, RegionTask};
use csalf_pave::{LayerSpec, LayerTask, PavingRules, Walk, WalkKind, pave_layers};
use csalf_sizemap::Uniform;
use csalf_tfi::{TfiRules, Transfinite};
use std::hint::black_box;

fn predicates(c: &mut Criterion) {
    let mut rnd = Random(3);
    let points: Vec<Point2> = (0..1 << 12).map(|_| Point2::new(rnd.number(), rnd.number())).collect();
    let mut group = c.benchmark_group("orient2d");
    group.throughput(Throughput::Elements(1 << 12));
    let left = |p: &[Point2]| p.windows(3).filter(|w| orient2d(w[0], w[1], w[2]) > 0.0).count();
    group.bench_function("general", |b| b.iter(|| left(black_box(&points))));
    let line: Vec<Point2> = points.iter().map(|p| Point2::new(p.x, 0.7 * p.x)).collect();
    group.bench_function("nearly on a line", |b| b.iter(|| left(black_box(&line))));
    group.finish();
}

/// A disk of `n` nodes, and the wanted length that makes its boundary regular.
fn disk(n: usize) -> (Contour, f64, Tolerance) {
    let points = wavy_loop(n);
    let h = std::f64::consts::TAU / n as f64;
    let tolerance = Tolerance::of_points(points.iter().copied());
    (Contour::from_ring(&points, h), h, tolerance)
}

fn patterns(c: &mut Criterion) {
    let mut group = c.benchmark_group("pattern");
    let mesher = Transfinite::new(TfiRules::default());
    for n in [16, 40, 120] {
        let (contour, h, tolerance) = disk(n);
        let size = Uniform(h);
        let task = RegionTask { contour: &contour, size: &size, tolerance };
        group.bench_function(format!("glance, {n} nodes"), |b| b.iter(|| mesher.glance(black_box(&task))));
        group.bench_function(format!("foresee, {n} nodes"), |b| b.iter(|| mesher.foresee(black_box(&task))));
        group.bench_function(format!("mesh, {n} nodes"), |b| b.iter(|| mesher.mesh(black_box(&task))));
    }
    group.finish();
}

fn rings(c: &mut Criterion) {
    let mut group = c.benchmark_group("ring");
    for n in [100, 1000] {
        let points = wavy_loop(n);
        let tolerance = Tolerance::of_points(points.iter().copied());
        let size = Uniform(std::f64::consts::TAU / n as f64);
        let walks = [Walk {
            nodes: (0..n as u32).collect(),
            kind: WalkKind::Outer,
            asked: Some(LayerSpec { count: 3, ..LayerSpec::default() }),
        }];
        let task = LayerTask {
            points: &points,
            walks: &walks,
            size: &size,
            tolerance,
            rules: PavingRules::default(),
            defaults: false,
            partial: false,
        };
        group.throughput(Throughput::Elements(3 * n as u64));
        group.bench_function(format!("3 of {n} nodes"), |b| b.iter(|| pave_layers(black_box(&task))));
    }
    group.finish();
}

fn smoothing(c: &mut Criterion) {
    let mut group = c.benchmark_group("smooth");
    for n in [30, 200] {
        let mesh = shaken_grid(n, 0.25);
        let topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
        let size = Uniform(1.0);
        let options = SmoothOptions { threshold: 2.0, ..SmoothOptions::default() };
        group.throughput(Throughput::Elements(mesh.n_quads() as u64));
        group.bench_function(format!("{n} x {n} quads"), |b| {
            b.iter_batched(
                || mesh.clone(),
                |mut mesh| smooth(&mut mesh, &topology, &[], &size, &options),
                BatchSize::LargeInput,
            )
        });
        group.bench_function(format!("topology of {n} x {n} quads"), |b| {
            b.iter(|| QuadTopology::new(mesh.n_vertices(), black_box(&mesh.quads)))
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_secs(1));
    targets = predicates, patterns, rings, smoothing
}
criterion_main!(benches);
