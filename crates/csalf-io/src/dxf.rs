//! DXF drawings: LINE, LWPOLYLINE and POLYLINE (with bulges), ARC, CIRCLE, ELLIPSE, SPLINE. Other entities are
//! counted in a note. Coordinates are taken as they are; units and layers do not matter.

use crate::{
    IoError, JobInput, Place,
    curves::{Piece, chain, outlines},
};
use csalf_geom::curve::{Curve, nurbs::Nurbs};
use csalf_geom::{Geometry, Point2};
use dxf::entities::{EntityType, Spline};
use std::f64::consts::TAU;

const FORMAT: &str = "DXF";

/// Reads the outlines of a drawing.
///
/// # Errors
/// [`IoError::Syntax`] if it is no DXF; [`IoError::Empty`] if nothing in it closes to a loop.
pub fn read(bytes: &[u8]) -> Result<JobInput, IoError> {
    let drawing = dxf::Drawing::load(&mut &bytes[..])
        .map_err(|e| IoError::syntax(FORMAT, Place::Whole, e.to_string()))?;
    let mut pieces: Vec<Piece> = Vec::new();
    let mut notes = Vec::new();
    let (mut n_other, mut n_bad) = (0, 0);
    for entity in drawing.entities() {
        let xy = |p: &dxf::Point| Point2::new(p.x, p.y);
        let mut curves: Vec<Option<Piece>> = Vec::new();
        let mut add =
            |c: Curve, normal_z: f64| curves.push(Piece::new(if normal_z < 0.0 { mirrored(c) } else { c }));
        match &entity.specific {
            EntityType::Line(l) => add(Curve::line(xy(&l.p1), xy(&l.p2)), 1.0),
            EntityType::Circle(c) => add(Curve::circle(xy(&c.center), c.radius), c.normal.z),
            EntityType::Arc(a) => {
                let start = a.start_angle.to_radians();
                add(
                    Curve::arc(xy(&a.center), a.radius, start, sweep(start, a.end_angle.to_radians())),
                    a.normal.z,
                );
            }
            EntityType::Ellipse(e) => {
                let axis = Point2::new(e.major_axis.x, e.major_axis.y);
                let (a, start) = (axis.length(), e.start_parameter);
                // Centre and axes are in world coordinates: a normal downward only turns the parameter round.
                let sign = if e.normal.z < 0.0 { -1.0 } else { 1.0 };
                let (center, radii) = (xy(&e.center), Point2::new(a, a * e.minor_axis_ratio.abs()));
                let (start, sweep) = (sign * start, sign * sweep(start, e.end_parameter));
                add(Curve::Arc { center, radii, rotation: axis.to_angle(), start, sweep }, 1.0);
            }
            EntityType::LwPolyline(p) => {
                let nodes: Vec<(Point2, f64)> =
                    p.vertices.iter().map(|v| (Point2::new(v.x, v.y), v.bulge)).collect();
                polyline(&nodes, p.is_closed()).into_iter().for_each(|c| add(c, p.extrusion_direction.z));
            }
            EntityType::Polyline(p) => {
                let nodes: Vec<(Point2, f64)> = p.vertices().map(|v| (xy(&v.location), v.bulge)).collect();
                polyline(&nodes, p.is_closed()).into_iter().for_each(|c| add(c, p.normal.z));
            }
            EntityType::Spline(s) => curves.push(spline(s)),
            _ => n_other += 1,
        }
        for c in curves {
            match c.filter(|p| p.ahead.is_finite()) {
                Some(p) => pieces.push(p),
                None => n_bad += 1,
            }
        }
    }
    if n_other > 0 {
        notes.push(format!("{n_other} entities that are no curves were left out"));
    }
    if n_bad > 0 {
        notes.push(format!("{n_bad} curves of no length or with broken numbers were left out"));
    }
    let size = Geometry::new(pieces.iter().map(|p| p.ahead.clone()).collect()).diagonal();
    pieces.retain(|p| !is_point(&p.ahead, Geometry::MAX_GAP * size));
    let (loops, open) = chain(pieces, Geometry::MAX_GAP * size);
    let unnamed = |list: Vec<Vec<Curve>>| list.into_iter().map(|c| (String::new(), c)).collect();
    outlines(FORMAT, unnamed(loops), unnamed(open), notes)
}

/// Angle from `start` to `end`, counter-clockwise, in (0, 2π].
fn sweep(start: f64, end: f64) -> f64 {
    let s = (end - start).rem_euclid(TAU);
    if s <= 0.0 { TAU } else { s }
}

/// True of a curve that stays within `gap` of its start.
fn is_point(c: &Curve, gap: f64) -> bool {
    let (t0, t1) = c.range();
    (1..=4).all(|k| c.eval(t0 + (t1 - t0) * f64::from(k) / 4.0).point.distance(c.start()) <= gap)
}

/// Entities drawn from below (normal −z) have x to the left.
fn mirrored(c: Curve) -> Curve {
    let flip = |p: Point2| Point2::new(-p.x, p.y);
    match c {
        Curve::Polyline(p) => Curve::Polyline(p.into_iter().map(flip).collect()),
        Curve::Arc { center, radii, rotation, start, sweep } => {
            let turn = std::f64::consts::PI;
            Curve::Arc {
                center: flip(center),
                radii,
                rotation: turn - rotation,
                start: -start,
                sweep: -sweep,
            }
        }
        other => other,
    }
}

/// Runs of straight segments as one polyline each, arcs for bulges.
fn polyline(nodes: &[(Point2, f64)], closed: bool) -> Vec<Curve> {
    let n = nodes.len();
    let mut out = Vec::new();
    let mut straight: Vec<Point2> = Vec::new();
    for i in 0..if closed { n } else { n.saturating_sub(1) } {
        let ((a, bulge), (b, _)) = (nodes[i], nodes[(i + 1) % n]);
        if a == b {
            continue;
        }
        if bulge == 0.0 {
            if straight.is_empty() {
                straight.push(a);
            }
            straight.push(b);
        } else {
            if !straight.is_empty() {
                out.push(Curve::Polyline(std::mem::take(&mut straight)));
            }
            out.push(Curve::bulge(a, b, bulge));
        }
    }
    if !straight.is_empty() {
        out.push(Curve::Polyline(straight));
    }
    out
}

/// By control points if there are any, else through the fit points.
fn spline(s: &Spline) -> Option<Piece> {
    let xy = |p: &dxf::Point| Point2::new(p.x, p.y);
    let points: Vec<Point2> = s.control_points.iter().map(xy).collect();
    if points.is_empty() {
        let mut fit: Vec<Point2> = s.fit_points.iter().map(xy).collect();
        fit.dedup();
        let closed = fit.len() > 3 && fit.first() == fit.last();
        if closed {
            fit.pop();
        }
        let ahead = Curve::through(&fit, closed).ok()?;
        fit.reverse();
        return Some(Piece { ahead, back: Curve::through(&fit, closed).ok()? });
    }
    let degree = usize::try_from(s.degree_of_curve).ok()?;
    let weights = if s.weight_values.len() == points.len() { s.weight_values.clone() } else { Vec::new() };
    let ahead = Nurbs::new(degree, &s.knot_values, &points, &weights).ok()?;
    let reversed = |v: &[f64]| v.iter().rev().copied().collect::<Vec<_>>();
    let knots: Vec<f64> = s.knot_values.iter().rev().map(|k| -k).collect();
    let turned: Vec<Point2> = points.iter().rev().copied().collect();
    let back = Nurbs::new(degree, &knots, &turned, &reversed(&weights)).ok()?;
    Some(Piece { ahead: Curve::Nurbs(ahead), back: Curve::Nurbs(back) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Input;

    fn outlines_of(entities: &str) -> Vec<Geometry> {
        let text = format!("0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n");
        match read(text.as_bytes()).unwrap().input {
            Input::Curves(c) => c.into_iter().map(|c| c.geometry).collect(),
            Input::Jobs(_) => Vec::new(),
        }
    }

    fn line(a: [f64; 2], b: [f64; 2]) -> String {
        format!("0\nLINE\n8\n0\n10\n{}\n20\n{}\n11\n{}\n21\n{}\n", a[0], a[1], b[0], b[1])
    }

    #[test]
    fn loose_lines_in_any_direction_join_and_circles_nest() {
        let square = [
            line([0., 0.], [4., 0.]),
            line([4., 4.], [4., 0.]),
            line([0., 4.], [4., 4.]),
            line([0., 4.], [1e-9, 0.]),
            line([1., 1.], [2., 1.]),
            "0\nCIRCLE\n8\n0\n10\n3\n20\n3\n40\n0.5\n".into(),
            "0\nCIRCLE\n8\n0\n10\n3\n20\n3\n40\n0.2\n".into(),
        ]
        .concat();
        let g = outlines_of(&square);
        assert_eq!(g.len(), 2);
        assert_eq!((g[0].loops.len(), g[0].loops[0].edges.len(), g[0].scars.len()), (2, 4, 1));
        assert_eq!((g[1].loops.len(), g[1].scars.len()), (1, 0));
        assert_eq!(g[0].check(), []);
    }

    #[test]
    fn bulges_become_arcs() {
        let slot = "0\nLWPOLYLINE\n8\n0\n90\n4\n70\n1\n10\n0\n20\n0\n10\n2\n20\n0\n42\n1\n10\n2\n20\n1\n\
                    10\n0\n20\n1\n42\n1\n";
        let g = outlines_of(slot);
        assert_eq!((g.len(), g[0].loops[0].edges.len()), (1, 4));
        let arcs = g[0].loops[0].edges.iter().filter(|e| matches!(e.curve, Curve::Arc { .. })).count();
        assert_eq!(arcs, 2);
        assert_eq!(g[0].check(), []);
    }
}
