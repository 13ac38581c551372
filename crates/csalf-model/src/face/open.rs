//! From the loops in the parameters to polygons in a chart: loops round a closed direction are opened by a cut, or laid
//! round a pole; around the apex of a cone there is a cap.

use super::NodeName;
use super::apex::{Cap, cap};
use super::chart::Chart;
use super::cut::Tube;
use super::trim::{UvLoop, UvNode};
use crate::geometry::{Surface, SurfacePoint};
use glam::{DVec2, DVec3};

/// A node in the chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ChartNode {
    pub(super) name: NodeName,
    pub(super) q: DVec2,
    pub(super) point: DVec3,
}

/// A face in its chart.
#[derive(Clone, Debug)]
pub(super) struct Opened<'a> {
    pub(super) chart: Chart<'a>,
    /// Polygons; each with the loop of the face it came from (a cut joins two: the first counts).
    pub(super) loops: Vec<(usize, Vec<ChartNode>)>,
    /// Points inside that must be nodes.
    pub(super) points: Vec<ChartNode>,
    /// Number of nodes made for this face.
    pub(super) n_own: u32,
    /// Quads around the apex of a cone, which the loops leave out.
    pub(super) cap: Option<Cap>,
}

/// The sizes of a face, as far as cuts and caps need them.
pub(super) struct Sizing<'a> {
    /// The wanted length at a place of the surface.
    pub(super) at: &'a dyn Fn(&SurfacePoint) -> f64,
    /// The smallest that curvature asks for.
    pub(super) least: f64,
    /// Growth per length.
    pub(super) gradation: f64,
}

/// Loops of a sphere, in the order of the nodes: stereographic.
pub(super) fn open_sphere<'a>(surface: &'a Surface, loops: &[UvLoop]) -> Option<Opened<'a>> {
    let Surface::Sphere { frame, radius } = surface else { return None };
    let area = |l: &UvLoop| {
        let n = l.nodes.len();
        let p = |i: usize| l.nodes[i % n].point - frame.origin;
        (0..n).map(|i| p(i).cross(p(i + 1)) * 0.5).sum::<DVec3>()
    };
    let areas: Vec<DVec3> = loops.iter().map(area).collect();
    let sum: DVec3 = areas.iter().sum();
    // Areas of a band between two circles cancel; then either pole will do, and lies in no material.
    const CANCEL: f64 = 0.05;
    let largest = areas.iter().copied().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let middle = if sum.length() > CANCEL * radius * radius { sum } else { largest };
    let chart = Chart::stereographic(surface, frame, *radius, middle);
    let place = |n: &UvNode| ChartNode { name: n.name, q: chart.place_point(n.point), point: n.point };
    let polygons = loops.iter().map(|l| {
        let mut nodes: Vec<ChartNode> = l.nodes.iter().map(place).collect();
        nodes.dedup_by(|a, b| a.name == b.name);
        (l.source, nodes)
    });
    Some(Opened { chart, loops: polygons.collect(), points: Vec::new(), n_own: 0, cap: None })
}

/// Opens the loops of any other surface. `apex`: the node of a vertex loop.
pub(super) fn open<'a>(
    surface: &'a Surface,
    mut loops: Vec<UvLoop>,
    apex: Option<UvNode>,
    sizing: &Sizing<'_>,
) -> Result<Opened<'a>, String> {
    let periods = surface.periods();
    if loops.iter().any(|l| l.winding.iter().any(|w| w.abs() > 1) || l.winding.iter().all(|w| *w != 0)) {
        return Err("a loop winds round the surface more than once".into());
    }
    // Only one direction at a time can be wound round; v is swapped with u while the cut is made.
    let along_v = loops.iter().any(|l| l.winding[1] != 0);
    if along_v {
        if loops.iter().any(|l| l.winding[0] != 0) {
            return Err("loops wind round both directions of the surface".into());
        }
        swap(&mut loops);
    }
    let periods = if along_v { [periods[1], periods[0]] } else { periods };
    let mut n_own = 0;
    let cap = match loops.iter().position(|l| l.winding[0] != 0) {
        Some(k) if loops.iter().filter(|l| l.winding[0] != 0).count() == 1 => {
            cap(surface, &loops, &loops[k], apex, sizing.least, &mut n_own).map(|(ring, cap)| {
                loops.push(ring);
                cap
            })
        }
        _ => None,
    };
    let up = loops.iter().filter(|l| l.winding[0] == 1).count();
    let down = loops.iter().filter(|l| l.winding[0] == -1).count();
    let mean_v = |l: &UvLoop| l.nodes.iter().map(|n| n.uv.y).sum::<f64>() / l.nodes.len().max(1) as f64;
    let mut holes: Vec<UvLoop> = Vec::new();
    let polygon = match (up, down) {
        (0, 0) => None,
        (1, 1) => {
            let take = |loops: &mut Vec<UvLoop>, w: i32| {
                let k = loops.iter().position(|l| l.winding[0] == w).unwrap_or(0);
                loops.remove(k)
            };
            let (mut low, mut high) = (take(&mut loops, 1), take(&mut loops, -1));
            if mean_v(&low) > mean_v(&high) {
                match periods[1] {
                    Some(p) => {
                        let up = p * ((mean_v(&low) - mean_v(&high)) / p).ceil();
                        high.nodes.iter_mut().for_each(|n| n.uv.y += up);
                    }
                    // The file has the face inside out: its loops the wrong way round.
                    None => {
                        for l in [&mut low, &mut high].into_iter().chain(&mut loops) {
                            l.nodes.reverse();
                            l.winding = l.winding.map(|w| -w);
                        }
                        std::mem::swap(&mut low, &mut high);
                    }
                }
            }
            holes = std::mem::take(&mut loops);
            let period = periods[0].ok_or("a loop winds round a direction that is not closed")?;
            let at = |uv: DVec2| surface.eval(if along_v { DVec2::new(uv.y, uv.x) } else { uv });
            let tube = Tube {
                low: &low,
                high: &high,
                holes: &holes,
                period,
                at: &at,
                size: sizing.at,
                gradation: sizing.gradation,
            };
            Some(tube.open(&mut n_own)?)
        }
        (1, 0) | (0, 1) if !along_v => return around_pole(surface, loops, apex, up == 1),
        _ => return Err(format!("{up} loops wind round the surface one way and {down} the other")),
    };
    let mut all: Vec<UvLoop> = polygon.into_iter().chain(holes).chain(loops).collect();
    if along_v {
        swap(&mut all);
    }
    let (low, high) = bounds(&all).ok_or("the face has no loop")?;
    let chart = Chart::band(surface, low, high);
    let place = |n: &UvNode| ChartNode { name: n.name, q: chart.place(n.uv), point: n.point };
    let mut opened = Opened { chart, loops: Vec::new(), points: Vec::new(), n_own, cap };
    for l in &all {
        let mut nodes: Vec<ChartNode> = l.nodes.iter().map(place).collect();
        // A pole that is one place in the chart.
        nodes.dedup_by(|a, b| a.name == b.name && a.q.distance(b.q) <= f64::EPSILON * (1.0 + a.q.length()));
        opened.loops.push((l.source, nodes));
    }
    gather(&mut opened, surface.periods());
    Ok(opened)
}

/// Swaps u and v; loops are reversed, since that mirrors.
fn swap(loops: &mut [UvLoop]) {
    for l in loops {
        l.nodes.reverse();
        l.nodes.iter_mut().for_each(|n| n.uv = DVec2::new(n.uv.y, n.uv.x));
        l.winding = [-l.winding[1], -l.winding[0]];
    }
}

/// Box around loops in the parameters.
fn bounds(loops: &[UvLoop]) -> Option<(DVec2, DVec2)> {
    let all = loops.iter().flat_map(|l| &l.nodes).map(|n| n.uv);
    all.fold(None, |b, p| Some(b.map_or((p, p), |(lo, hi): (DVec2, DVec2)| (lo.min(p), hi.max(p)))))
}

/// Shifts loops by whole periods so that they lie in the largest one.
fn gather(opened: &mut Opened<'_>, periods: [Option<f64>; 2]) {
    if periods == [None, None] || opened.loops.len() < 2 {
        return;
    }
    let area = |l: &[ChartNode]| {
        let n = l.len();
        (0..n).map(|i| l[i].q.perp_dot(l[(i + 1) % n].q)).sum::<f64>().abs()
    };
    let outer = (0..opened.loops.len())
        .max_by(|a, b| area(&opened.loops[*a].1).total_cmp(&area(&opened.loops[*b].1)).then(b.cmp(a)))
        .unwrap_or(0);
    let polygon: Vec<DVec2> = opened.loops[outer].1.iter().map(|n| n.q).collect();
    let steps = |p: Option<f64>| if p.is_some() { vec![0.0, 1.0, -1.0, 2.0, -2.0] } else { vec![0.0] };
    for k in (0..opened.loops.len()).filter(|k| *k != outer) {
        let first = opened.loops[k].1[0].q;
        let uv = opened.chart.parameters(first);
        let shift = steps(periods[0])
            .into_iter()
            .flat_map(|a| steps(periods[1]).into_iter().map(move |b| DVec2::new(a, b)))
            .map(|s| s * DVec2::new(periods[0].unwrap_or(0.0), periods[1].unwrap_or(0.0)))
            .find(|s| inside(&polygon, opened.chart.place(uv + *s)));
        if let Some(s) = shift.filter(|s| *s != DVec2::ZERO) {
            let chart = opened.chart;
            for n in &mut opened.loops[k].1 {
                n.q = chart.place(chart.parameters(n.q) + s);
            }
        }
    }
}

/// Even and odd test of a point in a polygon.
pub(super) fn inside(polygon: &[DVec2], p: DVec2) -> bool {
    let n = polygon.len();
    let crosses = |i: usize| {
        let (a, b) = (polygon[i], polygon[(i + 1) % n]);
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)
    };
    (0..n).filter(|&i| crosses(i)).count() % 2 == 1
}

/// A face with one loop round a pole.
fn around_pole<'a>(
    surface: &'a Surface,
    mut loops: Vec<UvLoop>,
    apex: Option<UvNode>,
    upwards: bool,
) -> Result<Opened<'a>, String> {
    let [below, above] = surface.poles();
    // The material is above a loop that winds +1. Of a file that has it the wrong way round, the only pole is taken.
    let wanted = if upwards { above.or(below) } else { below.or(above) };
    let pole = wanted.ok_or("one loop winds round the surface, which has no pole and no second loop")?;
    let (low, high) = bounds(&loops).ok_or("the face has no loop")?;
    let chart = Chart::polar(surface, pole, low, high);
    let place = |n: &UvNode| ChartNode { name: n.name, q: chart.place(n.uv), point: n.point };
    loops.retain(|l| !l.nodes.is_empty());
    let polygons = loops.iter().map(|l| (l.source, l.nodes.iter().map(place).collect())).collect();
    let mut opened = Opened { chart, loops: polygons, points: Vec::new(), n_own: 0, cap: None };
    // A sharp apex must be a node; a smooth pole need not be.
    if matches!(surface, Surface::Cone { .. }) {
        let point = surface.eval(DVec2::new(0.0, pole)).point;
        let node = match apex {
            Some(n) => ChartNode { name: n.name, q: DVec2::ZERO, point: n.point },
            None => {
                opened.n_own = 1;
                ChartNode { name: NodeName::Own(0), q: DVec2::ZERO, point }
            }
        };
        opened.points.push(node);
    }
    Ok(opened)
}
