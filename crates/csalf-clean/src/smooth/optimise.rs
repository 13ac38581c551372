//! Shape and size optimisation, one vertex at a time, that cannot turn a quad over.
//!
//! 1. Newton step on the energy of the corners around the vertex ([`energy::local`]; convex, so the step is a
//!    descent).
//! 2. A short step that cannot bring a corner below the floor is made as it is: the edges of a corner turn by at most
//!    asin(step / length) each.
//! 3. Halve any other until all corners are positive, the energy falls (Armijo) and no corner falls below both the
//!    floor and the worst one before.
//! 4. If no step does that, stay.
//!
//! Guarantees: positive corners stay positive; the smallest scaled Jacobian of the region does not fall, if
//! the floor is not below it. Cost about 0.2 us per visit. Source: handbook 7.3 (b) and 7.4.

use super::{
    energy::{self, Weights},
    region::Region,
};
use csalf_geom::Point2;

/// Share of the predicted decrease that a step must bring (Armijo). Larger: shorter steps; 0: any decrease.
const ARMIJO: f64 = 1e-4;

/// A step that turns the edges of a corner by less than this (radians, in sum) is short: the energy is nearly its
/// quadratic model there, and Newton's step lowers it. Larger: fewer trials, and steps that may miss.
const SHORT_TURN: f64 = 0.15;

/// Most halvings of a step. More find smaller moves that are not worth their cost.
const HALVINGS: usize = 5;

/// Where free vertex `v` goes, or its own place. `floor` as in the Laplace step; steps shorter than `short`
/// target lengths are not worth a trial.
pub(crate) fn step(region: &Region, v: u32, weights: Weights, floor: f64, short: f64) -> Point2 {
    let old = region.points[v as usize];
    let e = energy::local(region, v, old, weights);
    let g = e.gradient;
    let [a, b, c] = e.hessian;
    let det = a * c - b * b;
    if !(e.min_d > 0.0 && det > 0.0) {
        return old;
    }
    let p = -Point2::new(c * g.x - b * g.y, a * g.y - b * g.x) / det;
    let slope = p.dot(g);
    let inverse = region.inverse[(region.star(v)[0] / 4) as usize][0];
    if !(slope < 0.0 && p.is_finite() && p.length() * inverse > short) {
        return old;
    }
    // asin x + asin y <= 1.02 sqrt(2 (x² + y²)) for x² + y² <= SHORT_TURN², and the sine of an angle changes by no more than
    // the angle.
    let turned = 1.02 * (2.0 * e.turn).sqrt() * p.length();
    if turned < SHORT_TURN && (1.0 / e.worst).sqrt() - turned >= floor.sqrt() {
        return old + p;
    }
    let mut before = None;
    let mut alpha = 1.0;
    for _ in 0..=HALVINGS {
        let goal = old + alpha * p;
        let (value, above) = energy::trial(region, v, goal, weights, floor);
        if value <= e.value + ARMIJO * alpha * slope
            && (above
                || energy::worst_corner(region, v, goal)
                    >= *before.get_or_insert_with(|| energy::worst_corner(region, v, old)))
        {
            return goal;
        }
        alpha *= 0.5;
    }
    old
}
