//! The convex map: the longest loop on a circle, every inner vertex a weighted mean of its neighbours.
//!
//! Positive weights make it free of flips (Tutte 1963, Floater 1997). Holes are filled by a fan round a
//! centre first; a part of an injective map is injective (handbook 9.3).

use super::map::gradients;
use super::sparse::{Order, Symmetric};
use super::{Flat, assemble};
use crate::patch::{Chart, next};
use glam::{DVec2, DVec3};

/// Weights are cotangents kept within these bounds: positive whatever the facets are.
const WEIGHTS: (f64, f64) = (0.05, 20.0);

/// The map, with the area of the chart; `None` if rounding spoils it.
pub(crate) fn tutte(chart: &Chart) -> Option<Flat> {
    let p = |v: u32| chart.points[v as usize];
    let side = |h: u32| p(chart.tail(h)).distance(p(chart.tail(next(h))));
    let length = |l: &Vec<u32>| l.iter().map(|&h| side(h)).sum::<f64>();
    let outer = (0..chart.loops.len())
        .max_by(|&a, &b| length(&chart.loops[a]).total_cmp(&length(&chart.loops[b])).then(b.cmp(&a)))?;
    let radius = (chart.area() / std::f64::consts::PI).sqrt();
    let mut points = chart.points.clone();
    let mut triangles = chart.triangles.clone();
    for (_, l) in chart.loops.iter().enumerate().filter(|(k, _)| *k != outer) {
        let centre = points.len() as u32;
        points.push(l.iter().map(|&h| p(chart.tail(h))).sum::<DVec3>() / l.len() as f64);
        triangles.extend(l.iter().map(|&h| [chart.tail(next(h)), chart.tail(h), centre]));
    }
    let mut flat = vec![DVec2::NAN; points.len()];
    let total = length(&chart.loops[outer]);
    let mut s = 0.0;
    for &h in &chart.loops[outer] {
        flat[chart.tail(h) as usize] = radius * DVec2::from_angle(std::f64::consts::TAU * s / total);
        s += side(h);
    }
    // Cotangents per side, bounded as sums: a side inside has two facets, so half of the bounds each.
    let mut terms = Vec::with_capacity(8 * triangles.len());
    for t in &triangles {
        let (g, area) = gradients(t.map(|v| points[v as usize]));
        for k in 0..3 {
            let (i, j) = (k, (k + 1) % 3);
            let w = (-area * g[i].dot(g[j])).clamp(0.5 * WEIGHTS.0, 0.5 * WEIGHTS.1);
            let w = if w.is_finite() { w } else { WEIGHTS.0 };
            for c in 0..2 {
                terms.push(((t[i], c), (t[i], c), w));
                terms.push(((t[j], c), (t[j], c), w));
                terms.push(((t[i], c), (t[j], c), -w));
            }
        }
    }
    let order = Order::new(&points, &triangles);
    assemble(&order, &terms, &mut flat, Symmetric::new)?;
    flat.truncate(chart.vertex.len());
    Some(flat)
}
