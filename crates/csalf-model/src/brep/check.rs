//! Checks on import: ends of curves against vertices, edges against the surfaces of their faces, loops that do not
//! close. What can be repaired is repaired and said.

use super::{Edge, FaceShape, Loop, Model};
use crate::geometry::Inverter;
use glam::DVec3;

/// Points of an edge that are held against its surfaces.
const PROBES: u32 = 5;
/// A gap below this share of the model's diagonal is rounding of the file and not worth a word.
const SILENT: f64 = 1e-6;
/// A loop whose edges are farther apart than this share of the diagonal is broken.
const BROKEN: f64 = 1e-2;

/// What the checks found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CheckReport {
    /// Largest distance of a curve's end from its vertex.
    pub end_gap: f64,
    /// Largest distance of an edge from a surface of its faces.
    pub surface_gap: f64,
    /// In words: edge, face, distance.
    pub messages: Vec<String>,
}

/// Checks a model, sets the tolerance of each edge to the gaps found, and takes out edges and loops that cannot be
/// used (of no length, not finite, not closed). Faces are never taken out. Cost: a few inversions per edge.
pub fn check_and_snap(model: &mut Model) -> CheckReport {
    let mut report = CheckReport::default();
    let diagonal = model.diagonal();
    let dropped = degenerate_edges(model, diagonal);
    for face in &mut model.faces {
        for l in &mut face.loops {
            l.uses.retain(|u| !dropped.get(u.edge).copied().unwrap_or(true));
        }
        face.loops.retain(|l| !l.uses.is_empty() || l.vertex.is_some());
    }
    let n_dropped = dropped.iter().filter(|d| **d).count();
    if n_dropped > 0 {
        report
            .messages
            .push(format!("{n_dropped} edges of no length or without finite points were left out"));
    }
    for (edge, gone) in model.edges.iter_mut().zip(&dropped) {
        if *gone {
            continue;
        }
        let gap = (0..2)
            .map(|k| edge.at(f64::from(k)).point.distance(model.vertices[edge.ends[k as usize]].point))
            .fold(0.0, f64::max);
        edge.tolerance = edge.tolerance.max(gap);
        report.end_gap = report.end_gap.max(gap);
        if gap > SILENT * diagonal {
            report.messages.push(format!("{}: its curve ends {gap:.3e} from its vertex", edge.name));
        }
    }
    close_loops(model, diagonal, &mut report);
    surfaces(model, diagonal, &mut report);
    report
}

/// Edges that nothing can be done with.
fn degenerate_edges(model: &Model, diagonal: f64) -> Vec<bool> {
    let bad = |e: &Edge| {
        let finite = (0..=4).all(|k| e.at(f64::from(k) / 4.0).point.is_finite());
        let ends = e.ends.iter().all(|&v| model.vertices.get(v).is_some_and(|v| v.point.is_finite()));
        // An edge shorter than this share of the model is one point with rounding: the file's degenerate edges.
        const NOTHING: f64 = 1e-12;
        !finite || !ends || e.length() <= NOTHING * diagonal
    };
    model.edges.iter().map(bad).collect()
}

/// Orders the edges of each loop end to end, where the file has not.
fn close_loops(model: &mut Model, diagonal: f64, report: &mut CheckReport) {
    let point = |v: usize| model.vertices[v].point;
    let edges = &model.edges;
    let ends = |u: &super::EdgeUse| {
        let [a, b] = edges[u.edge].ends;
        if u.forward { [a, b] } else { [b, a] }
    };
    for face in &mut model.faces {
        for (k, l) in face.loops.iter_mut().enumerate() {
            let gap = |uses: &[super::EdgeUse]| {
                (0..uses.len())
                    .map(|i| {
                        let (a, b) = (ends(&uses[i])[1], ends(&uses[(i + 1) % uses.len()])[0]);
                        point(a).distance(point(b))
                    })
                    .fold(0.0, f64::max)
            };
            let before = gap(&l.uses);
            if before <= BROKEN * diagonal {
                continue;
            }
            let mut rest = l.uses.clone();
            let mut chain: Vec<super::EdgeUse> = rest.drain(..1).collect();
            while let Some(last) = chain.last().map(|u| point(ends(u)[1])) {
                let next = (0..rest.len())
                    .flat_map(|i| [(i, true), (i, false)])
                    .map(|(i, keep)| {
                        let start = if keep { ends(&rest[i])[0] } else { ends(&rest[i])[1] };
                        (point(start).distance(last), !keep, i)
                    })
                    .min_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
                let Some((_, turned, i)) = next else { break };
                let mut u = rest.remove(i);
                u.forward ^= turned;
                chain.push(u);
            }
            let after = gap(&chain);
            if after < before {
                l.uses = chain;
            }
            if after > BROKEN * diagonal {
                let name = &face.name;
                report.messages.push(format!("{name}: loop {} is open by {after:.3e}", k + 1));
            } else {
                report.messages.push(format!("{}: the edges of loop {} were put in order", face.name, k + 1));
            }
        }
    }
}

/// Distance of each edge from the surfaces of its faces.
fn surfaces(model: &mut Model, diagonal: f64, report: &mut CheckReport) {
    let mut gaps: Vec<(usize, f64)> = Vec::new();
    for face in &model.faces {
        let FaceShape::Surface(surface, _) = &face.shape else { continue };
        let inverter = Inverter::new(surface);
        let mut worst: (f64, usize) = (0.0, 0);
        for u in face.loops.iter().flat_map(|l: &Loop| &l.uses) {
            let edge = &model.edges[u.edge];
            let mut hint = None;
            for k in 0..PROBES {
                let p: DVec3 = edge.at((f64::from(k) + 0.5) / f64::from(PROBES)).point;
                let (uv, gap) = inverter.invert(p, hint, SILENT * diagonal);
                hint = Some(uv);
                gaps.push((u.edge, gap));
                if gap > worst.0 {
                    worst = (gap, u.edge);
                }
            }
        }
        report.surface_gap = report.surface_gap.max(worst.0);
        if worst.0 > SILENT * diagonal {
            let edge = &model.edges[worst.1].name;
            report
                .messages
                .push(format!("{}: its edge {edge} is {:.3e} from its surface", face.name, worst.0));
        }
    }
    for (e, gap) in gaps {
        if gap.is_finite() {
            model.edges[e].tolerance = model.edges[e].tolerance.max(gap);
        }
    }
}
