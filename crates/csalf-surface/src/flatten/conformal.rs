//! Least squares conformal map with a free boundary.
//!
//! 1. Energy E = Dirichlet(u, v) - area(u, v) >= 0, zero for conformal maps: the Dirichlet part by the
//!    gradients of the facets, the area as a sum over boundary sides.
//! 2. Two vertices far apart on the boundary are pinned at their distance in space.
//! 3. One sparse solve.
//!
//! Source: Levy et al. 2002; in this form Desbrun et al. 2002 (handbook 9.2).

use super::map::gradients;
use super::sparse::{Order, Symmetric};
use super::{Flat, assemble};
use crate::patch::{Chart, next};
use glam::DVec2;

/// The conformal map, or `None` if there is no boundary or the system cannot be solved.
pub(crate) fn conformal(chart: &Chart, order: &Order) -> Option<Flat> {
    let boundary: Vec<u32> = chart.loops.iter().flatten().map(|&h| chart.tail(h)).collect();
    let p = |v: u32| chart.points[v as usize];
    let farthest = |from: u32| {
        boundary.iter().copied().max_by(|&a, &b| {
            p(a).distance_squared(p(from)).total_cmp(&p(b).distance_squared(p(from))).then(b.cmp(&a))
        })
    };
    let a = farthest(*boundary.first()?)?;
    let b = farthest(a)?;
    let width = p(a).distance(p(b));
    if a == b || width <= 0.0 {
        return None;
    }
    let mut flat = vec![DVec2::NAN; chart.vertex.len()];
    flat[a as usize] = DVec2::ZERO;
    flat[b as usize] = DVec2::new(width, 0.0);
    let mut terms = Vec::with_capacity(18 * chart.triangles.len());
    for t in &chart.triangles {
        let (g, area) = gradients(t.map(p));
        for i in 0..3 {
            for j in i..3 {
                let w = area * g[i].dot(g[j]);
                let (v, w2) = (t[i], t[j]);
                terms.push(((v, 0), (w2, 0), w));
                terms.push(((v, 1), (w2, 1), w));
            }
        }
    }
    for &h in chart.loops.iter().flatten() {
        let (i, j) = (chart.tail(h), chart.tail(next(h)));
        terms.push(((i, 0), (j, 1), -0.5));
        terms.push(((j, 0), (i, 1), 0.5));
    }
    assemble(order, &terms, &mut flat, Symmetric::new)?;
    Some(flat)
}
