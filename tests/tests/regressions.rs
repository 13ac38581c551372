//! Domains that once failed, as `cargo xtask reduce` printed them, each named after the rule that it broke; and every
//! fixture by every method.

use csalf_core::{Job, Method, Options};
use csalf_geom::{Domain, Point2};
use csalf_testkit::{fixtures, run};

#[test]
fn every_fixture_meshes_by_every_method() {
    for job in fixtures::all() {
        for method in [Method::Csalf, Method::Paper, Method::Tqm] {
            let options = Options { method, threads: 1, ..Options::default() };
            if let Err(failure) = run(&job, &options, &[]) {
                panic!("{} by {method:?}: {failure}", job.name);
            }
        }
    }
}

fn p(list: &[(f64, f64)]) -> Vec<Point2> {
    list.iter().map(|&q| Point2::from(q)).collect()
}

fn must_mesh(domain: Domain) {
    let job = Job { name: "regression".into(), domain, ..Job::default() };
    for method in [Method::Csalf, Method::Paper, Method::Tqm] {
        let options = Options { method, threads: 1, ..Options::default() };
        if let Err(failure) = run(&job, &options, &[]) {
            panic!("by {method:?}: {failure}");
        }
    }
}

/// Opening a boundary singlet rotated a scar away (stress seed 6036).
#[test]
fn singlets_do_not_rotate_scars() {
    let outer = [(9.52, 4.57), (9.52, 3.45), (9.35, 3.13), (8.33, 2.19), (3.72, 0.0), (4.05, 10.0)];
    must_mesh(
        Domain::new(p(&outer))
            .with_scar(p(&[(8.33, 2.19), (6.19, 6.09)]))
            .with_point(Point2::new(7.09, 1.86)),
    );
}
