//! Facets of a face: a triangulation of its chart, fine enough for its curvature, with all boundary nodes as vertices.

use super::NodeName;
use super::chart::{Chart, Kind};
use super::open::{ChartNode, Opened, inside};
use crate::geometry::Surface;
use csalf_surface::{Facets, Projector, SurfacePoint};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Turn of the normal from one facet to the next, radians: 12 degrees.
const TURN: f64 = 0.21;
/// Most points inside a face.
const MOST: usize = 6000;
/// Points closer to the boundary than this share of their spacing are left out.
const CLEAR: f64 = 0.4;

/// The facets and what they came from.
#[derive(Clone, Debug)]
pub(super) struct ChartFacets {
    pub(super) facets: Facets,
    /// Name of each facet vertex; `None` of those inside.
    pub(super) names: Vec<Option<NodeName>>,
    /// Loops as facet vertices, with the loop of the face each came from.
    pub(super) loops: Vec<(usize, Vec<u32>)>,
    /// Facet vertices of the points inside that must be nodes.
    pub(super) points: Vec<u32>,
    /// Places of the corners of each facet in the chart.
    pub(super) corners: Vec<[DVec2; 3]>,
    /// Place of each facet vertex in the chart (mirrored if the face is turned over); empty where a pole is two places.
    pub(super) flat: Vec<DVec2>,
}

/// Triangulates the chart. `forward` is false if the face's normal is against the surface's.
pub(super) fn facets(opened: &Opened<'_>, forward: bool) -> Result<ChartFacets, String> {
    let chart = &opened.chart;
    let mut nodes: Vec<ChartNode> = Vec::new();
    let mut loops: Vec<(usize, Vec<u32>)> = Vec::new();
    for (source, l) in &opened.loops {
        if l.len() < 3 {
            return Err(format!("loop {} has fewer than three nodes", source + 1));
        }
        let first = nodes.len() as u32;
        nodes.extend(l);
        loops.push((*source, (first..nodes.len() as u32).collect()));
    }
    let n_loop_nodes = nodes.len();
    nodes.extend(&opened.points);
    let mut places: Vec<DVec2> = nodes.iter().map(|n| n.q).collect();
    places.extend(interior(chart, &loops, &places, n_loop_nodes));
    let polygons: Vec<Vec<u32>> = loops.iter().map(|l| l.1.clone()).collect();
    let mut triangles = csalf_sizemap::triangulate_loops(&places, &polygons)
        .map_err(|_| "two nodes of its boundary are at one place, or it has no area".to_owned())?;
    check_boundary(&triangles, &polygons, &nodes)?;
    let corners_of = |t: &[u32; 3]| t.map(|v| places[v as usize]);
    // A pole that is two places next to each other on a loop becomes one vertex.
    let mut same: Vec<u32> = (0..places.len() as u32).collect();
    let mut split_pole = false;
    for (_, l) in &mut loops {
        let n = l.len();
        for i in 0..n {
            let (a, b) = (l[i], l[(i + 1) % n]);
            if nodes[a as usize].name == nodes[b as usize].name {
                same[b as usize] = same[a as usize];
                split_pole = true;
            }
        }
        l.retain(|&v| same[v as usize] == v);
    }
    triangles.retain(|t| {
        let [a, b, c] = t.map(|v| same[v as usize]);
        a != b && b != c && c != a
    });
    let mut corners: Vec<[DVec2; 3]> = triangles.iter().map(corners_of).collect();
    for t in &mut triangles {
        *t = t.map(|v| same[v as usize]);
    }
    let mut flat = if split_pole { Vec::new() } else { places.clone() };
    if !forward {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
        corners.iter_mut().for_each(|c| c.swap(1, 2));
        flat.iter_mut().for_each(|q| *q = DVec2::new(q.y, q.x));
    }
    let names = (0..places.len()).map(|v| nodes.get(v).map(|n| n.name)).collect();
    let points = (0..places.len())
        .map(|v| nodes.get(v).map_or_else(|| chart.eval(places[v]).point, |n| n.point))
        .collect();
    let (facets, points) =
        (Facets { points, triangles }, (n_loop_nodes as u32..nodes.len() as u32).collect());
    Ok(ChartFacets { facets, names, loops, points, corners, flat })
}

/// Every side of a loop must be a side of exactly one triangle, and no other side may be.
fn check_boundary(triangles: &[[u32; 3]], loops: &[Vec<u32>], nodes: &[ChartNode]) -> Result<(), String> {
    let mut sides: Vec<[u32; 2]> =
        triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).collect();
    sides.iter_mut().for_each(|s| s.sort_unstable());
    sides.sort_unstable();
    let single: Vec<[u32; 2]> =
        sides.chunk_by(|a, b| a == b).filter(|r| r.len() == 1).map(|r| r[0]).collect();
    let mut wanted: Vec<[u32; 2]> =
        loops.iter().flat_map(|l| (0..l.len()).map(|i| [l[i], l[(i + 1) % l.len()]])).collect();
    wanted.iter_mut().for_each(|s| s.sort_unstable());
    wanted.sort_unstable();
    match wanted.iter().find(|s| single.binary_search(s).is_err()) {
        Some(s) => {
            let p = nodes[s[0] as usize].point;
            Err(format!("its boundary crosses or touches itself near ({:.6}, {:.6}, {:.6})", p.x, p.y, p.z))
        }
        None if single.len() != wanted.len() => Err("its loops do not bound one area".into()),
        None => Ok(()),
    }
}

/// Points inside the loops, spaced by curvature.
fn interior(
    chart: &Chart<'_>,
    loops: &[(usize, Vec<u32>)],
    places: &[DVec2],
    n_loop_nodes: usize,
) -> Vec<DVec2> {
    let boundary = &places[..n_loop_nodes];
    let (low, high) =
        boundary.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), q| (a.min(*q), b.max(*q)));
    let candidates = candidates(chart, low, high, boundary);
    let segments: Vec<(DVec2, DVec2)> = loops
        .iter()
        .flat_map(|(_, l)| {
            (0..l.len()).map(|i| (places[l[i] as usize], places[l[(i + 1) % l.len()] as usize]))
        })
        .collect();
    let polygons: Vec<Vec<DVec2>> =
        loops.iter().map(|(_, l)| l.iter().map(|&v| places[v as usize]).collect()).collect();
    let fixed = &places[n_loop_nodes..];
    let keep = |(q, spacing): &(DVec2, DVec2)| {
        polygons.iter().filter(|p| inside(p, *q)).count() % 2 == 1
            && segments.iter().all(|(a, b)| {
                let (a, b) = ((*a - *q) / *spacing, (*b - *q) / *spacing);
                let d = b - a;
                let t = (-a.dot(d) / d.length_squared()).clamp(0.0, 1.0);
                (a + d * t).length_squared() >= CLEAR * CLEAR
            })
            && fixed.iter().all(|p| ((*p - *q) / *spacing).length_squared() >= CLEAR * CLEAR)
    };
    candidates.into_iter().filter(keep).map(|c| c.0).collect()
}

/// Places and the spacing around each.
fn candidates(chart: &Chart<'_>, low: DVec2, high: DVec2, boundary: &[DVec2]) -> Vec<(DVec2, DVec2)> {
    let extent = high - low;
    match (chart.kind, chart.surface) {
        (Kind::Plane, _) => Vec::new(),
        (Kind::Stereo { radius, .. }, _) => {
            let far = boundary.iter().map(|q| q.length()).fold(0.0, f64::max);
            rings(2.0 * (far / (2.0 * radius)).atan(), |a| 2.0 * radius * (0.5 * a).tan(), |a| a.sin())
        }
        (Kind::Polar { .. }, _) => {
            let far = boundary.iter().map(|q| q.length()).fold(0.0, f64::max);
            // As on a half sphere.
            rings(0.5 * std::f64::consts::PI, |a| far * a / (0.5 * std::f64::consts::PI), |a| a)
        }
        (_, Surface::Cylinder { radius, .. }) => {
            let dx = radius.abs() * TURN;
            grid(low, high, DVec2::new(dx, 2.0 * dx))
        }
        (_, Surface::Cone { .. }) => {
            let middle = chart.eval(0.5 * (low + high));
            let [k, _] = middle.curvatures();
            let dx = if k > 0.0 { TURN / k } else { extent.max_element() };
            grid(low, high, DVec2::new(dx, 2.0 * dx))
        }
        (Kind::Torus { major, minor, scale }, _) => {
            grid(low, high, DVec2::new(scale * TURN, scale * TURN * minor / (major + minor)))
        }
        _ => {
            let n = turns(chart, low, high);
            grid(low, high, extent / n)
        }
    }
}

/// Pieces along x and along y that keep the turn of the normal within [`TURN`].
fn turns(chart: &Chart<'_>, low: DVec2, high: DVec2) -> DVec2 {
    /// Samples per direction.
    const N: usize = 16;
    let at = |i: usize, j: usize| {
        let s = DVec2::new(i as f64, j as f64) / N as f64;
        chart.eval(low + (high - low) * s).normal()
    };
    let angle = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b));
    let (mut x, mut y) = (0.0_f64, 0.0_f64);
    for j in 0..=N {
        x = x.max((0..N).map(|i| angle(at(i, j), at(i + 1, j))).fold(0.0, f64::max) * N as f64);
        y = y.max((0..N).map(|i| angle(at(j, i), at(j, i + 1))).fold(0.0, f64::max) * N as f64);
    }
    let pieces = |a: f64| (a / TURN).ceil().clamp(2.0, 64.0);
    DVec2::new(pieces(x), pieces(y))
}

/// A staggered grid.
fn grid(low: DVec2, high: DVec2, spacing: DVec2) -> Vec<(DVec2, DVec2)> {
    let extent = high - low;
    let mut spacing = spacing.min(extent.max(DVec2::splat(f64::MIN_POSITIVE)));
    let count = |s: DVec2| (extent.x / s.x + 1.0) * (extent.y / s.y + 1.0);
    if !count(spacing).is_finite() {
        return Vec::new();
    }
    while count(spacing) > MOST as f64 {
        spacing *= 1.25;
    }
    let (nx, ny) = ((extent.x / spacing.x).ceil() as u32, (extent.y / spacing.y).ceil() as u32);
    let step = DVec2::new(extent.x / f64::from(nx.max(1)), extent.y / f64::from(ny.max(1)));
    let mut out = Vec::new();
    for j in 1..ny.max(2) {
        for i in 0..=nx {
            let stagger = if j % 2 == 0 { 0.0 } else { 0.5 };
            let y = if ny < 2 { 0.5 } else { f64::from(j) };
            let step = if ny < 2 { DVec2::new(step.x, extent.y) } else { step };
            out.push((low + step * DVec2::new(f64::from(i) + stagger, y), spacing));
        }
    }
    out
}

/// Rings round the origin at even angles up to `most`; `radius` gives the distance of each, `share` the size of a ring.
fn rings(most: f64, radius: impl Fn(f64) -> f64, share: impl Fn(f64) -> f64) -> Vec<(DVec2, DVec2)> {
    let n = (most / TURN).ceil().max(2.0) as u32;
    let mut out = Vec::new();
    for k in 0..n {
        let a = most * f64::from(k) / f64::from(n);
        let (r, next) = (radius(a), radius(most * f64::from(k + 1) / f64::from(n)));
        let m = if k == 0 { 1 } else { (TAU * share(a) / TURN).ceil().clamp(6.0, 64.0) as u32 };
        for i in 0..m {
            let angle = TAU * (f64::from(i) + if k % 2 == 0 { 0.0 } else { 0.5 }) / f64::from(m);
            out.push((DVec2::from_angle(angle) * r, DVec2::splat(next - r)));
        }
    }
    out
}

/// The exact surface beneath the facets.
#[derive(Debug)]
pub(super) struct Beneath<'a> {
    pub(super) chart: Chart<'a>,
    pub(super) corners: &'a [[DVec2; 3]],
    pub(super) forward: bool,
}

impl Projector for Beneath<'_> {
    fn project(&self, _: DVec3, facet: u32, bary: [f64; 3]) -> Option<SurfacePoint> {
        let c = self.corners.get(facet as usize)?;
        let q = c[0] * bary[0] + c[1] * bary[1] + c[2] * bary[2];
        let at = self.chart.eval(q);
        let normal = match self.chart.surface {
            Surface::Sphere { frame, .. } => (at.point - frame.origin).try_normalize()?,
            _ => at.du.cross(at.dv).try_normalize()?,
        };
        Some(SurfacePoint { point: at.point, normal: if self.forward { normal } else { -normal } })
    }

    fn is_map(&self) -> bool {
        true
    }
}
