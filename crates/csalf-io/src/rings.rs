//! Jobs from rings of points: what GeoJSON and TopoJSON have in common.

use csalf_core::Job;
use csalf_geom::{Domain, Loop, LoopKind, Point2};

/// The job of one polygon: its outer ring, then its holes. Rings may repeat their first point at the end. Equal
/// successive points are dropped; if the total is odd, the longest segment gets a node in its middle.
pub(crate) fn job_of_polygon(name: &str, rings: Vec<Vec<Point2>>, notes: &mut Vec<String>) -> Job {
    let mut domain = Domain::default();
    let mut n_repeated = 0;
    for (k, mut ring) in rings.into_iter().enumerate() {
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        let n = ring.len();
        ring.dedup();
        while ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        n_repeated += n - ring.len();
        let (kind, loop_name) = match k.checked_sub(1) {
            None => (LoopKind::Outer, "outer".to_owned()),
            Some(k) => (LoopKind::Hole, format!("hole{k}")),
        };
        domain.loops.push(Loop { kind, name: loop_name, nodes: ring });
    }
    if n_repeated > 0 {
        notes.push(format!("{name}: {n_repeated} repeated points were dropped"));
    }
    make_even(name, &mut domain, notes);
    Job { name: name.to_owned(), domain, ..Job::default() }
}

/// Puts a node into the middle of the longest segment if the total is odd.
fn make_even(name: &str, domain: &mut Domain, notes: &mut Vec<String>) {
    if domain.loops.iter().map(|l| l.nodes.len()).sum::<usize>() % 2 == 0 {
        return;
    }
    let mut longest: Option<(f64, usize, usize)> = None;
    for (k, l) in domain.loops.iter().enumerate() {
        for i in 0..l.nodes.len() {
            let length = l.nodes[i].distance(l.nodes[(i + 1) % l.nodes.len()]);
            if longest.is_none_or(|best| length > best.0) {
                longest = Some((length, k, i));
            }
        }
    }
    if let Some((_, k, i)) = longest {
        let l = &mut domain.loops[k];
        let middle = l.nodes[i].midpoint(l.nodes[(i + 1) % l.nodes.len()]);
        l.nodes.insert(i + 1, middle);
        notes.push(format!(
            "{name}: a node was added to {} at ({}, {}) to make the number of segments even",
            l.name, middle.x, middle.y
        ));
    }
}

/// Names for the parts of one feature: its own, with `_0`, `_1` ... if there are several parts.
pub(crate) fn part_name(name: &str, k: usize, n: usize) -> String {
    if n > 1 { format!("{name}_{k}") } else { name.to_owned() }
}

/// The name of a feature: the first of the usual properties that holds a text or a number.
pub(crate) fn feature_name(get: impl Fn(&str) -> Option<serde_json::Value>) -> Option<String> {
    let text = |v: serde_json::Value| match v {
        serde_json::Value::String(s) if !s.trim().is_empty() => Some(s),
        serde_json::Value::Number(n) => Some(n.to_string()),
        _ => None,
    };
    ["NAME", "name", "Name", "title", "id", "ID", "NAMELSAD"].iter().find_map(|k| get(k).and_then(text))
}
