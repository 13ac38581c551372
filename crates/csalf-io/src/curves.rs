//! Outlines out of loose curves, for DXF and SVG.
//!
//! 1. [`chain`]: ends closer than a tolerance are one node; curves are joined at nodes where just two meet. A chain
//!    that comes back is a loop, any other a scar.
//! 2. [`outlines`]: loops inside an even number of others are outer loops, the others holes of the loop around
//!    them; each outer loop makes one geometry. Insides are told on polygons of samples.

use crate::{Input, IoError, JobInput, JobOptions, NamedGeometry};
use csalf_geom::curve::Curve;
use csalf_geom::geometry::{CurveLoop, CurveScar, Edge};
use csalf_geom::polygon::{Side, locate, signed_area};
use csalf_geom::{Geometry, LoopKind, Point2};

/// A curve and the same one backwards.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub ahead: Curve,
    pub back: Curve,
}

impl Piece {
    /// A polyline, arc or Bezier curve; `None` of others, which cannot be turned without their parts.
    pub(crate) fn new(ahead: Curve) -> Option<Self> {
        let back = match &ahead {
            Curve::Polyline(p) => Curve::Polyline(p.iter().rev().copied().collect()),
            &Curve::Arc { center, radii, rotation, start, sweep } => {
                Curve::Arc { center, radii, rotation, start: start + sweep, sweep: -sweep }
            }
            &Curve::Quadratic([a, b, c]) => Curve::Quadratic([c, b, a]),
            &Curve::Cubic([a, b, c, d]) => Curve::Cubic([d, c, b, a]),
            _ => return None,
        };
        Some(Self { ahead, back })
    }
}

/// Samples of a curve without its end: enough to tell inside from outside.
fn samples(curve: &Curve) -> Vec<Point2> {
    if let Curve::Polyline(p) = curve {
        return p.iter().take(p.len().saturating_sub(1)).copied().collect();
    }
    /// Samples between two breaks. *Arbitrary*; finer than the eye on a full circle.
    const PER_SPAN: u32 = 32;
    let (t0, t1) = curve.range();
    let ends: Vec<f64> = std::iter::once(t0).chain(curve.breaks()).chain([t1]).collect();
    let at = |w: &[f64], k: u32| curve.eval(w[0] + (w[1] - w[0]) * f64::from(k) / f64::from(PER_SPAN)).point;
    ends.windows(2).flat_map(|w| (0..PER_SPAN).map(|k| at(w, k)).collect::<Vec<_>>()).collect()
}

/// Joins pieces end to end. Loops first, then open chains.
pub(crate) fn chain(pieces: Vec<Piece>, tolerance: f64) -> (Vec<Vec<Curve>>, Vec<Vec<Curve>>) {
    // End 2k is the start of piece k, 2k + 1 its end; nodes are groups of near ends.
    let ends: Vec<Point2> = pieces.iter().flat_map(|p| [p.ahead.start(), p.ahead.end()]).collect();
    let mut order: Vec<usize> = (0..ends.len()).collect();
    order.sort_by(|&a, &b| ends[a].x.total_cmp(&ends[b].x).then(a.cmp(&b)));
    let mut node: Vec<usize> = (0..ends.len()).collect();
    for (i, &a) in order.iter().enumerate() {
        for &b in order[i + 1..].iter().take_while(|&&b| ends[b].x - ends[a].x <= tolerance) {
            if ends[a].distance(ends[b]) <= tolerance {
                let (from, to) = (node[a].max(node[b]), node[a].min(node[b]));
                // Few ends are near each other: renaming those of one x window is cheap.
                order.iter().filter(|&&e| (ends[e].x - ends[a].x).abs() <= 2.0 * tolerance).for_each(|&e| {
                    if node[e] == from {
                        node[e] = to;
                    }
                });
            }
        }
    }
    let mut at: Vec<Vec<usize>> = vec![Vec::new(); ends.len()];
    (0..ends.len()).for_each(|e| at[node[e]].push(e));
    let mut used = vec![false; pieces.len()];
    let (mut loops, mut open) = (Vec::new(), Vec::new());
    // First from nodes where chains must break, then the rest, which are plain loops.
    for pass in 0..2 {
        for first in 0..ends.len() {
            let from = node[first];
            if used[first / 2] || (pass == 0 && at[from].len() == 2) {
                continue;
            }
            let (mut e, mut curves) = (first, Vec::new());
            let closed = loop {
                used[e / 2] = true;
                let p = &pieces[e / 2];
                curves.push(if e % 2 == 0 { p.ahead.clone() } else { p.back.clone() });
                let to = node[e ^ 1];
                if to == from {
                    break true;
                }
                match at[to].iter().find(|&&g| !used[g / 2]) {
                    Some(&g) if at[to].len() == 2 => e = g,
                    _ => break false,
                }
            };
            if closed { loops.push(curves) } else { open.push(curves) }
        }
    }
    (loops, open)
}

/// Sorts loops into outer loops and holes and gives scars to the outline around them.
///
/// # Errors
/// [`IoError::Empty`] if there is no loop.
pub(crate) fn outlines(
    format: &'static str,
    loops: Vec<(String, Vec<Curve>)>,
    scars: Vec<(String, Vec<Curve>)>,
    mut notes: Vec<String>,
) -> Result<JobInput, IoError> {
    let edges = |curves: Vec<Curve>| curves.into_iter().map(Edge::from).collect::<Vec<_>>();
    let rings: Vec<(Vec<Point2>, f64)> = loops
        .iter()
        .map(|(_, curves)| {
            let ring: Vec<Point2> = curves.iter().flat_map(samples).collect();
            let area = signed_area(&ring).abs();
            (ring, area)
        })
        .collect();
    let holds = |a: usize, q: Point2| locate(&rings[a].0, q) == Side::Inside;
    // Loops do not cross: one is in another if a sample of it is, and that other is larger.
    let around: Vec<Vec<usize>> = (0..loops.len())
        .map(|b| {
            let larger = (0..loops.len()).filter(|&a| a != b && rings[a].1 > rings[b].1);
            let mut list: Vec<usize> = larger
                .filter(|&a| {
                    let side =
                        rings[b].0.iter().map(|&q| locate(&rings[a].0, q)).find(|&s| s != Side::Boundary);
                    side == Some(Side::Inside)
                })
                .collect();
            list.sort_by(|&x, &y| rings[x].1.total_cmp(&rings[y].1).then(x.cmp(&y)));
            list
        })
        .collect();
    let is_outer: Vec<bool> = around.iter().map(|a| a.len() % 2 == 0).collect();
    let mut place = vec![usize::MAX; loops.len()];
    let mut out: Vec<NamedGeometry> = Vec::new();
    let mut outer_of: Vec<usize> = Vec::new();
    let mut holes = Vec::new();
    for (k, (name, curves)) in loops.into_iter().enumerate() {
        if is_outer[k] {
            place[k] = out.len();
            outer_of.push(k);
            let edges = edges(curves);
            let outer = CurveLoop { kind: LoopKind::Outer, name: "outer".into(), edges };
            out.push(NamedGeometry {
                name,
                geometry: Geometry { loops: vec![outer], ..Geometry::default() },
            });
        } else {
            holes.push((k, edges(curves)));
        }
    }
    for (k, edges) in holes {
        let Some(g) = around[k].first().and_then(|&a| out.get_mut(place[a])) else { continue };
        let name = format!("hole{}", g.geometry.loops.len() - 1);
        g.geometry.loops.push(CurveLoop { kind: LoopKind::Hole, name, edges });
    }
    let mut n_outside = 0;
    for (_, curves) in scars {
        let all: Vec<Point2> = curves.iter().flat_map(samples).collect();
        let middle = match all[..] {
            [] => Point2::NAN,
            [a] => a.midpoint(curves.last().map_or(a, Curve::end)),
            _ => all[all.len() / 2],
        };
        let home = (0..outer_of.len()).filter(|&i| holds(outer_of[i], middle));
        match home.min_by(|&a, &b| rings[outer_of[a]].1.total_cmp(&rings[outer_of[b]].1)) {
            Some(i) => {
                let name = format!("scar{}", out[i].geometry.scars.len());
                out[i].geometry.scars.push(CurveScar { name, edges: edges(curves) });
            }
            None => n_outside += 1,
        }
    }
    if n_outside > 0 {
        notes.push(format!("{n_outside} open curves lie in no closed one and were left out"));
    }
    if out.is_empty() {
        return Err(IoError::Empty { format, wanted: "closed curve" });
    }
    Ok(JobInput { input: Input::Curves(out), options: JobOptions::default(), notes })
}
