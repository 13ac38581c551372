//! Who may import whom: strictly downward, never sideways.
//!
//! ```text
//!   9  py  wasm
//!   8  cli                             bench and xtask stand above, the testkit beside the tower:
//!   7  step     studio
//!   6  model
//!   5  surface  io                       xtask may see all; the testkit all up to io,
//!   4  core                              and anyone may use it in tests
//!   3  pave  subdiv  tfi  clean
//!   2  mesh
//!   1  sizemap
//!   0  geom
//! ```
//!
//! Cargo refuses cycles, but not tfi → pave; this does.

use super::{list, text};
use serde_json::Value;

/// The layer of each crate of ours.
const LAYERS: [(&str, u32); 19] = [
    ("csalf-geom", 0),
    ("csalf-sizemap", 1),
    ("csalf-mesh", 2),
    ("csalf-pave", 3),
    ("csalf-subdiv", 3),
    ("csalf-tfi", 3),
    ("csalf-clean", 3),
    ("csalf-core", 4),
    ("csalf-surface", 5),
    ("csalf-io", 5),
    ("csalf-testkit", 6),
    ("csalf-model", 6),
    ("csalf-step", 7),
    ("csalf-studio", 7),
    ("csalf-cli", 8),
    ("csalf-py", 9),
    ("csalf-wasm", 9),
    ("csalf-bench", 9),
    ("xtask", 10),
];

/// Third-party crates that only some of ours may use, because a rule hangs on it.
const RESERVED: [(&str, &[&str], &str); 5] = [
    ("robust", &["csalf-geom"], "signs are decided by csalf_geom::predicates alone"),
    ("nalgebra", &["csalf-clean"], "linear algebra stays inside the optimiser"),
    ("clap", &["csalf-cli", "xtask"], "libraries do not parse command lines"),
    ("axum", &["csalf-studio"], "one crate serves pages, behind a feature"),
    ("tracing-subscriber", &["csalf-cli"], "libraries do not install subscribers"),
];

/// The name of the crate that all may use in tests.
const TESTKIT: &str = "csalf-testkit";

fn layer(name: &str) -> Option<u32> {
    LAYERS.iter().find(|(n, _)| *n == name).map(|&(_, l)| l)
}

/// All edges of the crate graph that break the rule, one line each.
pub(super) fn check(metadata: &Value) -> Vec<String> {
    let ours = list(metadata, "workspace_members");
    let mut findings = Vec::new();
    for package in list(metadata, "packages").iter().filter(|p| ours.contains(&p["id"])) {
        let from = text(package, "name");
        if layer(from).is_none() {
            findings.push(format!("{from}: has no layer; add it to xtask/src/tidy/layers.rs"));
        }
        for d in list(package, "dependencies") {
            let in_tests = text(d, "kind") == "dev";
            findings.extend(judge(from, text(d, "name"), in_tests));
        }
    }
    findings
}

/// What is wrong with one edge, if anything.
fn judge(from: &str, to: &str, in_tests: bool) -> Option<String> {
    if let Some((_, users, why)) = RESERVED.iter().find(|(n, ..)| *n == to) {
        return (!users.contains(&from))
            .then(|| format!("{from} uses {to}, which only {users:?} may: {why}"));
    }
    let (a, b) = (layer(from)?, layer(to)?);
    if b < a || (in_tests && to == TESTKIT) {
        return None;
    }
    Some(format!("{from} (layer {a}) depends on {to} (layer {b}): only lower layers are allowed"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn downward_is_allowed_and_sideways_is_not() {
        assert_eq!(judge("csalf-core", "csalf-pave", false), None);
        assert_eq!(judge("csalf-geom", "csalf-testkit", true), None);
        assert_eq!(judge("csalf-geom", "glam", false), None);
        assert!(judge("csalf-tfi", "csalf-pave", false).is_some());
        assert!(judge("csalf-tfi", "csalf-pave", true).is_some());
        assert!(judge("csalf-geom", "csalf-testkit", false).is_some());
        assert!(judge("csalf-sizemap", "csalf-mesh", false).is_some());
        assert!(judge("csalf-clean", "robust", false).is_some());
    }

    #[test]
    fn a_crate_without_a_layer_is_found() {
        let m = serde_json::json!({
            "workspace_members": ["a"],
            "packages": [{"id": "a", "name": "csalf-new", "dependencies": []}],
        });
        assert_eq!(check(&m).len(), 1);
    }
}
