//! What `--json` prints and `--report` writes.
//!
//! `--json` ends standard output with **one line**, kept to a few kilobytes however large the model is: loops with
//! the same outcome are one entry, warnings beyond the first few are only counted. `--report` has all of it.

use csalf_core::{LoopReport, MeshReport};
use serde_json::{Map, Value, json};

/// Most warnings in the line.
const MAX_WARNINGS: usize = 8;

/// Most groups of loops in the line.
const MAX_GROUPS: usize = 12;

/// Longest text made of loop names, in bytes.
const MAX_NAMES: usize = 120;

/// Longest list of numbers in the line.
const MAX_LIST: usize = 128;

/// The line that ends a successful run: `ok` true and these entries.
pub fn success(entries: Map<String, Value>) -> String {
    let mut all = Map::new();
    all.insert("ok".into(), true.into());
    all.insert("exit_code".into(), crate::exit::DONE.into());
    all.extend(entries);
    Value::Object(all).to_string()
}

/// The line that ends a failed run.
pub fn failure(failure: &crate::exit::Failure) -> String {
    let errors: Vec<String> = match failure {
        crate::exit::Failure::Invalid { defects, .. } => defects.clone(),
        crate::exit::Failure::Several { errors, .. } => errors.clone(),
        other => other.to_string().lines().map(str::to_owned).collect(),
    };
    json!({
        "ok": false,
        "exit_code": failure.code(),
        "n_errors": errors.len(),
        "errors": &errors[..errors.len().min(MAX_WARNINGS)],
    })
    .to_string()
}

/// Layers per loop, members and warnings, short or (`full`) loop by loop.
pub fn report(report: &MeshReport, full: bool) -> Map<String, Value> {
    let mut out = Map::new();
    let groups: Vec<Value> = if full {
        report.loops.iter().map(|l| layer_entry(&l.name, 1, l)).collect()
    } else {
        grouped(&report.loops)
    };
    out.insert("layers".into(), groups.into());
    let members: Map<String, Value> = report.members.iter().map(|&(n, k)| (n.to_owned(), k.into())).collect();
    out.insert("members".into(), members.into());
    let stages: Map<String, Value> =
        report.timing.stages.iter().map(|&(n, s)| (n.to_owned(), s.into())).collect();
    out.insert("stages".into(), stages.into());
    let n = if full { report.warnings.len() } else { report.warnings.len().min(MAX_WARNINGS) };
    let warnings: Vec<String> = report.warnings[..n].iter().map(ToString::to_string).collect();
    out.insert("n_warnings".into(), report.warnings.len().into());
    out.insert("warnings".into(), warnings.into());
    out
}

/// The quality report; in the short form lists with one entry per loop are left out if they are long.
pub fn quality(report: &impl serde::Serialize, full: bool) -> Value {
    let mut value = serde_json::to_value(report).unwrap_or_default();
    if !full {
        drop_long_lists(&mut value);
    }
    value
}

fn drop_long_lists(value: &mut Value) {
    match value {
        Value::Array(list) if list.len() > MAX_LIST => *value = Value::Null,
        Value::Array(list) => list.iter_mut().for_each(drop_long_lists),
        Value::Object(map) => map.values_mut().for_each(drop_long_lists),
        _ => {}
    }
}

fn layer_entry(names: &str, n_loops: usize, l: &LoopReport) -> Value {
    json!({
        "loops": names,
        "n_loops": n_loops,
        "asked": l.asked,
        "made": l.made,
        "stopped": l.stopped,
        "thickness_error": l.thickness_error,
    })
}

/// One entry per outcome, in order of first appearance, with the largest thickness error.
fn grouped(loops: &[LoopReport]) -> Vec<Value> {
    let mut groups: Vec<(LoopReport, Vec<&str>)> = Vec::new();
    for l in loops {
        let same = |g: &&mut (LoopReport, Vec<&str>)| {
            (g.0.asked, g.0.made, &g.0.stopped) == (l.asked, l.made, &l.stopped)
        };
        match groups.iter_mut().find(same) {
            Some((worst, names)) => {
                worst.thickness_error = worst.thickness_error.max(l.thickness_error);
                names.push(&l.name);
            }
            None => groups.push((l.clone(), vec![&l.name])),
        }
    }
    let rest: usize = groups.iter().skip(MAX_GROUPS).map(|(_, names)| names.len()).sum();
    let mut out: Vec<Value> = groups
        .iter()
        .take(MAX_GROUPS)
        .map(|(l, names)| layer_entry(&ranges(names), names.len(), l))
        .collect();
    if rest > 0 {
        out.push(json!({ "loops": "others", "n_loops": rest }));
    }
    out
}

/// `outer, hole0..hole63`: names that count up are joined; a long text is cut.
pub fn ranges(names: &[&str]) -> String {
    let mut out = String::new();
    let mut i = 0;
    while i < names.len() {
        let mut j = i;
        while j + 1 < names.len() && follows(names[j], names[j + 1]) {
            j += 1;
        }
        if !out.is_empty() {
            out.push_str(", ");
        }
        if out.len() > MAX_NAMES {
            out.push_str("...");
            break;
        }
        out.push_str(names[i]);
        if j > i {
            out.push_str(if j == i + 1 { ", " } else { ".." });
            out.push_str(names[j]);
        }
        i = j + 1;
    }
    out
}

/// True if both are the same text with successive numbers behind it.
fn follows(a: &str, b: &str) -> bool {
    let split = |s: &str| {
        let stem = s.trim_end_matches(|c: char| c.is_ascii_digit());
        let number = s[stem.len()..].parse::<u64>().ok()?;
        Some((stem.to_owned(), number))
    };
    match (split(a), split(b)) {
        (Some((s, i)), Some((t, j))) => s == t && i.checked_add(1) == Some(j),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loop_report(name: &str, asked: usize, made: usize) -> LoopReport {
        LoopReport { name: name.into(), asked, made, ..LoopReport::default() }
    }

    #[test]
    fn names_that_count_up_are_joined() {
        assert_eq!(
            ranges(&["outer", "hole0", "hole1", "hole2", "hole4", "hole5", "x"]),
            "outer, hole0..hole2, hole4, hole5, x"
        );
        let many: Vec<String> = (0..1000).map(|i| format!("loop{}", 2 * i)).collect();
        assert!(ranges(&many.iter().map(String::as_str).collect::<Vec<_>>()).len() < MAX_NAMES + 20);
    }

    #[test]
    fn loops_with_the_same_outcome_are_one_entry() {
        let mut loops: Vec<LoopReport> = (0..64).map(|i| loop_report(&format!("hole{i}"), 2, 2)).collect();
        loops[7].made = 1;
        loops[9].thickness_error = 0.5;
        let g = grouped(&loops);
        assert_eq!(g.len(), 2);
        assert_eq!(g[0]["n_loops"], 63);
        assert_eq!(g[0]["loops"], "hole0..hole6, hole8..hole63");
        assert_eq!(g[0]["thickness_error"], 0.5);
        assert_eq!(g[1]["made"], 1);
    }

    #[test]
    fn the_line_stays_short_and_the_report_has_everything() {
        let loops = (0..5000).map(|i| loop_report(&format!("hole{i}"), i, i / 2)).collect();
        let r = MeshReport { loops, ..MeshReport::default() };
        assert!(Value::Object(report(&r, false)).to_string().len() < 3000);
        assert_eq!(report(&r, true)["layers"].as_array().map(Vec::len), Some(5000));
    }

    #[test]
    fn a_failure_is_one_line_too() {
        let defects = vec!["a".to_owned(), "b".to_owned()];
        let line = failure(&crate::exit::Failure::Invalid { input: "x".into(), defects });
        let v: Value = serde_json::from_str(&line).unwrap();
        assert_eq!(
            (v["ok"].as_bool(), v["exit_code"].as_u64(), v["n_errors"].as_u64()),
            (Some(false), Some(3), Some(2))
        );
    }
}
