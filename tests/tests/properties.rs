//! What must hold for any valid domain, by any method. Domains come from the generator's seeds; a seed that fails
//! is shrunk by `cargo xtask reduce SEED`, not by proptest, which cannot shrink a seed.

use csalf_core::{Job, Meshed, Method, Options};
use csalf_geom::Point2;
use csalf_sizemap::SizeSpec;
use csalf_testkit::check::faults;
use csalf_testkit::run::same_bytes;
use csalf_testkit::{Recipe, job};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Small jobs: a run of all properties takes seconds.
const RECIPE: Recipe = Recipe { nasty: None, layers: false, most_nodes: 200, most_quads: 700.0 };

fn methods() -> impl Strategy<Value = Method> {
    prop::sample::select(vec![Method::Csalf, Method::Paper, Method::Tqm])
}

fn config(cases: u32) -> ProptestConfig {
    // The same seeds every time, so that a gate tells of the change and not of luck; `cargo xtask stress` explores.
    ProptestConfig {
        cases,
        failure_persistence: None,
        max_shrink_iters: 0,
        rng_seed: RngSeed::Fixed(2026),
        ..ProptestConfig::default()
    }
}

/// Triangulations hash with seeds that differ from one to the next, even in one process: the mesh must not show it.
#[test]
fn the_same_job_gives_the_same_bytes_again() {
    // Nasty ones need triangulations most: bridges, sizes, fallbacks.
    for seed in 0..12 {
        let (job, base) = job(seed, &Recipe { nasty: Some(true), ..RECIPE });
        let run = || csalf_core::mesh(&job, &base).unwrap_or_else(|e| panic!("seed {seed}: {e}")).mesh;
        let first = run();
        assert!((0..3).all(|_| same_bytes(&first, &run())), "seed {seed}");
    }
}

fn mesh(job: &Job, options: &Options) -> Result<Meshed, TestCaseError> {
    csalf_core::mesh(job, options).map_err(|e| TestCaseError::fail(format!("{}: {e}", job.name)))
}

fn with(method: Method, threads: usize, base: Options) -> Options {
    Options { method, threads, ..base }
}

fn map_points(job: &mut Job, map: impl Fn(Point2) -> Point2) {
    let d = &mut job.domain;
    let curves = d.loops.iter_mut().map(|l| &mut l.nodes).chain(d.scars.iter_mut().map(|s| &mut s.nodes));
    curves.flatten().for_each(|p| *p = map(*p));
    d.points.iter_mut().for_each(|p| p.xy = map(p.xy));
}

/// The job with all lengths times `f`.
fn scaled(job: &Job, f: f64) -> Job {
    let mut out = job.clone();
    map_points(&mut out, |p| p * f);
    out.domain.points.iter_mut().for_each(|p| p.size = p.size.map(|h| h * f));
    match &mut out.size {
        SizeSpec::Boundary => {}
        SizeSpec::Uniform { h } => *h *= f,
        SizeSpec::Sources { far, sources } => {
            *far *= f;
            for s in sources {
                (s.xy, s.h, s.radius, s.falloff) = (s.xy * f, s.h * f, s.radius * f, s.falloff * f);
            }
        }
        SizeSpec::Background { points, values, .. } => {
            points.iter_mut().for_each(|p| *p *= f);
            values.iter_mut().for_each(|h| *h *= f);
        }
    }
    out
}

proptest! {
    #![proptest_config(config(60))]

    /// Convex quads, conforming edges, the boundary bit for bit, scars, points, area, Euler: the independent judge.
    #[test]
    fn every_mesh_is_valid(seed in any::<u32>(), method in methods()) {
        let (job, base) = job(u64::from(seed), &RECIPE);
        let meshed = mesh(&job, &with(method, 1, base))?;
        prop_assert_eq!(faults(&job, &meshed.mesh), vec![], "seed {}", seed);
    }

    /// With layers of random laws on random loops, too.
    #[test]
    fn every_mesh_with_layers_is_valid(seed in any::<u32>()) {
        let (job, base) = job(u64::from(seed), &Recipe { layers: true, ..RECIPE });
        let meshed = mesh(&job, &with(Method::Csalf, 1, base))?;
        prop_assert_eq!(faults(&job, &meshed.mesh), vec![], "seed {}", seed);
    }
}

proptest! {
    #![proptest_config(config(24))]

    /// N/2 + I - 1 + k quads for N boundary segments (scars count on both sides), I free vertices, k holes.
    #[test]
    fn the_number_of_quads_follows_from_euler(seed in any::<u32>(), method in methods()) {
        let (job, base) = job(u64::from(seed), &RECIPE);
        let mesh = mesh(&job, &with(method, 1, base))?.mesh;
        let n: usize = job.domain.loops.iter().map(|l| l.nodes.len()).sum();
        prop_assert_eq!(n % 2, 0);
        // Every vertex off the loops counts as free, those of scars and points as well.
        let free = mesh.points.len() - n;
        prop_assert_eq!(mesh.quads.len() + 2, n / 2 + free + job.domain.loops.len(), "seed {}", seed);
    }

    /// One, two and four threads give the same bytes.
    #[test]
    fn threads_do_not_matter(seed in any::<u32>(), method in methods()) {
        let (job, base) = job(u64::from(seed), &RECIPE);
        let one = mesh(&job, &with(method, 1, base.clone()))?;
        for threads in [2, 4] {
            let other = mesh(&job, &with(method, threads, base.clone()))?;
            prop_assert!(same_bytes(&one.mesh, &other.mesh), "seed {}, {} threads", seed, threads);
        }
    }

    /// Times a power of two: the same quads, the points scaled bit for bit.
    #[test]
    fn powers_of_two_give_the_same_mesh(seed in any::<u32>(), method in methods(), k in -20i32..20) {
        let (job, base) = job(u64::from(seed), &RECIPE);
        let f = 2f64.powi(k);
        let one = mesh(&job, &with(method, 1, base.clone()))?.mesh;
        let other = mesh(&scaled(&job, f), &with(method, 1, base))?.mesh;
        prop_assert!(one.quads == other.quads, "seed {}: other quads at 2^{}", seed, k);
        prop_assert!(one.points.iter().zip(&other.points).all(|(p, q)| *p * f == *q), "seed {}", seed);
    }

    /// Another start node gives a valid mesh that is about as good.
    #[test]
    fn the_start_node_does_not_matter(seed in any::<u32>(), method in methods(), turn in 1usize..1000) {
        let (job, base) = job(u64::from(seed), &RECIPE);
        let mut turned = job.clone();
        for l in &mut turned.domain.loops {
            let n = l.nodes.len();
            l.nodes.rotate_left(turn % n);
        }
        let one = mesh(&job, &with(method, 1, base.clone()))?.mesh;
        let other = mesh(&turned, &with(method, 1, base))?.mesh;
        prop_assert_eq!(faults(&turned, &other), vec![], "seed {}", seed);
        let mean = |m: &csalf_mesh::QuadMesh| csalf_mesh::QualityReport::new(m, None, None).mean_sj;
        let (a, b) = (mean(&one), mean(&other));
        prop_assert!((a - b).abs() < 0.15, "seed {}: mean scaled Jacobian {} and {}", seed, a, b);
    }
}

proptest! {
    #![proptest_config(config(100))]

    /// The generator keeps its promise: valid, even, and the same again.
    #[test]
    fn generated_jobs_are_valid_and_repeatable(seed in any::<u64>(), layers in any::<bool>()) {
        let recipe = Recipe { layers, ..RECIPE };
        let (job, options) = job(seed, &recipe);
        prop_assert_eq!(job.domain.check(), vec![]);
        let again = csalf_testkit::job(seed, &recipe);
        prop_assert!(again == (job, options));
    }
}

/// A loop that has fewer layers than were asked for has a reason for it.
#[test]
fn layers_that_were_not_made_have_a_reason() {
    let mut short = 0;
    for seed in 0..40 {
        let (job, base) = job(seed, &Recipe { layers: true, ..RECIPE });
        let meshed = csalf_core::mesh(&job, &base).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        for l in meshed.report.loops.iter().filter(|l| l.made < l.asked) {
            assert!(!l.stopped.is_empty(), "seed {seed}: {l:?}");
            short += 1;
        }
    }
    assert!(short > 20, "the domains must give the rule something to do: {short}");
}
