//! Domains that once failed, as `cargo xtask reduce` printed them, each named after the rule that it broke; and every
//! fixture by every method.

use csalf_core::{Method, Options};
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
