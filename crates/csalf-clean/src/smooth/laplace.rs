//! Length- and size-weighted smart Laplace: cheap, evens out bad positions.
//!
//! ```text
//!              o            each neighbour pulls with the length of its edge in units of the wanted length;
//!              │            long edges pull more, so lengths even out and the grading stays
//!      o───────v──o
//!              │
//!              o
//! ```
//!
//! A move is kept if the worst corner around does not get worse, or stays above the floor. Source: handbook
//! 7.2.

use super::{
    energy::{is_above, worst_corner},
    region::Region,
};
use csalf_geom::Point2;

/// Where free vertex `v` goes; its own place if the mesh around would get worse. `floor` is the scaled
/// Jacobian down to which a corner may get worse, squared. Cost about 0.1 us.
pub(crate) fn step(region: &Region, v: u32, floor: f64) -> Point2 {
    let old = region.points[v as usize];
    let (mut sum, mut weight) = (Point2::ZERO, 0.0);
    for &h in region.star(v) {
        let (q, k) = ((h / 4) as usize, (h & 3) as usize);
        let e = region.points[region.quads[q][(k + 1) & 3] as usize] - old;
        let w = e.length() * region.inverse[q][k & 1];
        sum += w * e;
        weight += w;
    }
    if weight <= 0.0 {
        return old;
    }
    let goal = old + sum / weight;
    let good =
        is_above(region, v, goal, floor) || worst_corner(region, v, goal) >= worst_corner(region, v, old);
    if good { goal } else { old }
}
