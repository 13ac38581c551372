//! Hard points (weld spots) given in space: each goes to the face whose material is nearest, and becomes a node there.

use super::NodeName;
use super::chart::Kind;
use super::mesh::{Context, open_face};
use super::open::{ChartNode, Opened, inside};
use crate::brep::FaceShape;
use crate::facets::Patch;
use crate::geometry::Inverter;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A point that a face must have as a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hard {
    /// Which of the given points.
    pub(crate) index: usize,
    /// Where it was given.
    pub(crate) point: DVec3,
}

/// For each face the points that belong to it, and the distance of each point from its face (infinite: from none).
/// Cost: an inversion per face and point.
pub(crate) fn assign(cx: &Context<'_>, points: &[DVec3]) -> (Vec<Vec<Hard>>, Vec<f64>) {
    let mut faces = vec![Vec::new(); cx.model.faces.len()];
    if points.is_empty() {
        return (faces, Vec::new());
    }
    let distances: Vec<Vec<f64>> =
        (0..faces.len()).into_par_iter().map(|f| distances(cx, f, points)).collect();
    let mut nearest = Vec::with_capacity(points.len());
    for (index, &point) in points.iter().enumerate() {
        let best = (0..faces.len()).min_by(|a, b| distances[*a][index].total_cmp(&distances[*b][index]));
        let d = best.map_or(f64::INFINITY, |f| distances[f][index]);
        nearest.push(d);
        if let Some(f) = best.filter(|_| d.is_finite()) {
            faces[f].push(Hard { index, point });
        }
    }
    (faces, nearest)
}

/// Distance of each point from the material of a face; infinite where its foot is outside.
fn distances(cx: &Context<'_>, index: usize, points: &[DVec3]) -> Vec<f64> {
    let face = &cx.model.faces[index];
    let far = || vec![f64::INFINITY; points.len()];
    match &face.shape {
        FaceShape::Unread => far(),
        FaceShape::Facets(p) => {
            points.iter().map(|&q| nearest_facet(p, q).map_or(f64::INFINITY, |n| n.0)).collect()
        }
        FaceShape::Surface(surface, forward) => {
            let inverter = Inverter::new(surface);
            let Ok(opened) = open_face(cx, face, &inverter, *forward) else { return far() };
            points.iter().map(|&p| foot(&opened, &inverter, p).map_or(f64::INFINITY, |f| f.0)).collect()
        }
    }
}

/// The foot of a point on a face: distance, place in the chart, position. `None` if it is outside the loops.
fn foot(opened: &Opened<'_>, inverter: &Inverter<'_>, p: DVec3) -> Option<(f64, DVec2, DVec3)> {
    let (uv, d) = inverter.invert(p, None, 0.0);
    let at = inverter.surface().eval(uv).point;
    let polygons: Vec<Vec<DVec2>> = opened.loops.iter().map(|l| l.1.iter().map(|n| n.q).collect()).collect();
    let within = |q: DVec2| polygons.iter().filter(|l| inside(l, q)).count() % 2 == 1;
    if matches!(opened.chart.kind, Kind::Stereo { .. }) {
        let q = opened.chart.place_point(at);
        return within(q).then_some((d, q, at));
    }
    let [pu, pv] = inverter.surface().periods();
    let shifts = |p: Option<f64>| p.map_or(vec![0.0], |p| vec![0.0, p, -p]);
    let places = shifts(pu).into_iter().flat_map(|a| shifts(pv).into_iter().map(move |b| DVec2::new(a, b)));
    places.map(|s| opened.chart.place(uv + s)).find(|q| within(*q)).map(|q| (d, q, at))
}

/// Adds the points to an opened face; returns their numbers among the face's own nodes.
pub(super) fn add(opened: &mut Opened<'_>, inverter: &Inverter<'_>, hard: &[Hard]) -> Vec<(usize, u32)> {
    let mut out = Vec::new();
    for h in hard {
        let Some((_, q, point)) = foot(opened, inverter, h.point) else { continue };
        opened.points.push(ChartNode { name: NodeName::Own(opened.n_own), q, point });
        out.push((h.index, opened.n_own));
        opened.n_own += 1;
    }
    out
}

/// The nearest point of a patch: distance, triangle, position.
pub(super) fn nearest_facet(patch: &Patch, p: DVec3) -> Option<(f64, usize, DVec3)> {
    let foot = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| patch.points[v as usize]);
        nearest_on_triangle(a, b, c, p)
    };
    let all = patch.triangles.iter().enumerate().map(|(i, t)| {
        let q = foot(t);
        (q.distance(p), i, q)
    });
    all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
}

/// The point of a triangle nearest to `p`: its foot in the plane if that is inside, else on a side.
fn nearest_on_triangle(a: DVec3, b: DVec3, c: DVec3, p: DVec3) -> DVec3 {
    let n = (b - a).cross(c - a);
    let within =
        |q: DVec3| [(a, b), (b, c), (c, a)].iter().all(|(s, t)| (*t - *s).cross(q - *s).dot(n) >= 0.0);
    if n.length_squared() > 0.0 {
        let q = p - n * ((p - a).dot(n) / n.length_squared());
        if within(q) {
            return q;
        }
    }
    let on_side = |s: DVec3, t: DVec3| {
        let d = t - s;
        let l = d.length_squared();
        if l > 0.0 { s + d * ((p - s).dot(d) / l).clamp(0.0, 1.0) } else { s }
    };
    let sides = [on_side(a, b), on_side(b, c), on_side(c, a)];
    sides.into_iter().min_by(|x, y| x.distance(p).total_cmp(&y.distance(p))).unwrap_or(a)
}
