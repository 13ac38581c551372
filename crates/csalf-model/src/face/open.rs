//! From the loops in the parameters to polygons in a chart: loops round a closed direction are opened by a cut, or laid
//! round a pole.
//!
//! ```text
//!   ◀──────────────   loop that winds -1        ┌──────────────┐
//!   material               ─cut─▶               │c            c'│   the cut's two copies have the same names
//!   ──────────────▶   loop that winds +1        └──────────────┘
//! ```

use super::NodeName;
use super::chart::Chart;
use super::trim::{UvLoop, UvNode};
use crate::geometry::Surface;
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
    Some(Opened { chart, loops: polygons.collect(), points: Vec::new(), n_own: 0 })
}

/// Opens the loops of any other surface. `apex`: the node of a vertex loop.
pub(super) fn open<'a>(
    surface: &'a Surface,
    mut loops: Vec<UvLoop>,
    apex: Option<UvNode>,
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
            Some(cut(&low, &high, &holes, period, &at, &mut n_own)?)
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
    let mut opened = Opened { chart, loops: Vec::new(), points: Vec::new(), n_own };
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

/// Joins a loop that winds +1 (below) and one that winds -1 (above) by a cut, which is straight in the parameters and
/// as short as it can be without crossing a loop.
fn cut(
    low: &UvLoop,
    high: &UvLoop,
    holes: &[UvLoop],
    period: f64,
    at: &dyn Fn(DVec2) -> crate::geometry::SurfacePoint,
    n_own: &mut u32,
) -> Result<UvLoop, String> {
    /// Pairs of nodes that are tried, shortest first.
    const TRIES: usize = 400;
    let middle = 0.5 * (low.nodes[0].uv + high.nodes[0].uv);
    let scale = {
        let s = at(middle);
        DVec2::new(s.du.length().max(f64::MIN_POSITIVE), s.dv.length().max(f64::MIN_POSITIVE))
    };
    let near = |uv: DVec2, hint: DVec2| DVec2::new(uv.x + ((hint.x - uv.x) / period).round() * period, uv.y);
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (i, a) in low.nodes.iter().enumerate() {
        let best = high
            .nodes
            .iter()
            .enumerate()
            .map(|(j, b)| (((near(b.uv, a.uv) - a.uv) * scale).length_squared(), i, j))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        pairs.extend(best);
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let segments = || {
        [low, high].into_iter().chain(holes).flat_map(|l| {
            let n = l.nodes.len();
            let last = move |i: usize| {
                // The closing segment of a loop that winds leads one period on.
                let next = l.nodes[(i + 1) % n].uv;
                if i + 1 == n { next + DVec2::new(period * f64::from(l.winding[0]), 0.0) } else { next }
            };
            (0..n).map(move |i| (l.nodes[i].uv, last(i)))
        })
    };
    let free = |a: DVec2, b: DVec2| {
        // The ends touch their own loops: the cut is held against everything a little within.
        const WITHIN: f64 = 1e-6;
        let (p, q) = (a + (b - a) * WITHIN, b + (a - b) * WITHIN);
        !segments().any(|(s, t)| {
            [-2.0, -1.0, 0.0, 1.0, 2.0].iter().any(|k| {
                let d = DVec2::new(k * period, 0.0);
                cross(p, q, s + d, t + d)
            })
        })
    };
    let (_, i, j) = pairs
        .into_iter()
        .take(TRIES)
        .find(|&(_, i, j)| free(low.nodes[i].uv, near(high.nodes[j].uv, low.nodes[i].uv)))
        .ok_or("no cut between the two loops that wind round the surface was found")?;
    let (a, b) = (low.nodes[i].uv, near(high.nodes[j].uv, low.nodes[i].uv));
    // Nodes of the cut: as dense as those of the loops beside its ends.
    let spacing = |l: &UvLoop, k: usize| {
        let n = l.nodes.len();
        let p = |k: usize| l.nodes[k % n].point;
        0.5 * (p(k).distance(p(k + 1)) + p(k).distance(p(k + n - 1)))
    };
    let length: f64 = (0..16)
        .map(|k| {
            let p = |k: u32| at(a + (b - a) * (f64::from(k) / 16.0)).point;
            p(k).distance(p(k + 1))
        })
        .sum();
    let h = (spacing(low, i) * spacing(high, j)).sqrt();
    let n = ((length / h).round() as usize).clamp(1, 10_000);
    let first = *n_own;
    *n_own += n as u32 - 1;
    let on_cut = |k: usize, shift: f64| {
        let uv = a + (b - a) * (k as f64 / n as f64);
        UvNode {
            name: NodeName::Own(first + k as u32 - 1),
            uv: uv + DVec2::new(shift, 0.0),
            point: at(uv).point,
        }
    };
    let shifted = |m: &UvNode, s: f64| UvNode { uv: m.uv + DVec2::new(s, 0.0), ..*m };
    let mut nodes = Vec::new();
    let (nl, nh) = (low.nodes.len(), high.nodes.len());
    nodes.extend((0..=nl).map(|k| shifted(&low.nodes[(i + k) % nl], if i + k >= nl { period } else { 0.0 })));
    nodes.extend((1..n).map(|k| on_cut(k, period)));
    let to = b.x + period - high.nodes[j].uv.x;
    nodes.extend(
        (0..=nh).map(|k| shifted(&high.nodes[(j + k) % nh], to - if j + k >= nh { period } else { 0.0 })),
    );
    nodes.extend((1..n).rev().map(|k| on_cut(k, 0.0)));
    Ok(UvLoop { nodes, winding: [0, 0], source: low.source })
}

/// Whether two segments cross properly or touch.
fn cross(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    use csalf_geom::predicates::orient2d;
    let s = |p, q, r| orient2d(p, q, r);
    let (x, y) = (s(a, b, c) * s(a, b, d), s(c, d, a) * s(c, d, b));
    x <= 0.0 && y <= 0.0 && (x < 0.0 || y < 0.0)
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
    let mut opened = Opened { chart, loops: polygons, points: Vec::new(), n_own: 0 };
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
