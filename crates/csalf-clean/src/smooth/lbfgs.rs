//! Limited-memory BFGS on points of the plane.
//!
//! 1. Direction from the last [`MEMORY`] steps (two-loop recursion).
//! 2. Step length by bisection until the weak Wolfe conditions hold.
//! 3. Stop on a small relative decrease, or when no step brings any.
//!
//! Source: J. Nocedal, S. Wright, *Numerical Optimization*, 2nd ed. (2006), algorithms 7.4 and 7.5; A. Lewis,
//! M. Overton, *Nonsmooth optimization via quasi-Newton methods*, Math. Program. 141 (2013), algorithm 2.6.

use csalf_geom::Point2;
use std::collections::VecDeque;

/// Steps remembered. More: fewer iterations, each dearer. (Handbook 7.3 has 15.)
const MEMORY: usize = 12;
/// Armijo and curvature constants of the line search, the usual ones.
const ARMIJO: f64 = 1e-4;
/// See [`ARMIJO`].
const CURVATURE: f64 = 0.9;
/// Most evaluations in one line search.
const EVALUATIONS: usize = 30;

fn dot(a: &[Point2], b: &[Point2]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// Minimises `f`, which returns the value at its first argument and writes the gradient into its second. The
/// first step moves no point farther than `first`. Ends after `iterations`, or when a step lowers the value
/// by less than `tolerance` of it. Returns the last value; `x` is the best point. Allocates at the start
/// only.
pub(crate) fn minimise(
    x: &mut [Point2],
    iterations: usize,
    first: f64,
    tolerance: f64,
    mut f: impl FnMut(&[Point2], &mut [Point2]) -> f64,
) -> f64 {
    let n = x.len();
    let zero = || vec![Point2::ZERO; n];
    let (mut g, mut direction, mut trial, mut g_trial) = (zero(), zero(), zero(), zero());
    let mut memory: VecDeque<(Vec<Point2>, Vec<Point2>, f64)> = VecDeque::with_capacity(MEMORY);
    let mut weights = [0.0; MEMORY];
    let mut value = f(x, &mut g);
    for _ in 0..iterations {
        for (d, g) in direction.iter_mut().zip(&g) {
            *d = -*g;
        }
        for (i, (s, y, rho)) in memory.iter().enumerate().rev() {
            weights[i] = rho * dot(s, &direction);
            for (d, y) in direction.iter_mut().zip(y) {
                *d -= weights[i] * *y;
            }
        }
        let largest = g.iter().map(|g| g.length()).fold(0.0, f64::max);
        let scale = match memory.back() {
            Some((_, y, rho)) => 1.0 / (rho * dot(y, y)),
            None if largest > 0.0 => first / largest,
            None => break,
        };
        for d in &mut direction {
            *d *= scale;
        }
        for (i, (s, y, rho)) in memory.iter().enumerate() {
            let beta = rho * dot(y, &direction);
            for (d, s) in direction.iter_mut().zip(s) {
                *d += (weights[i] - beta) * *s;
            }
        }
        let slope = dot(&direction, &g);
        if slope.is_nan() || slope >= 0.0 {
            if memory.is_empty() {
                break;
            }
            memory.clear();
            continue;
        }
        let (mut low, mut high, mut t) = (0.0, f64::INFINITY, 1.0);
        let mut v = value;
        let mut at = |t: f64, trial: &mut [Point2], g_trial: &mut [Point2]| {
            for ((z, x), d) in trial.iter_mut().zip(&*x).zip(&direction) {
                *z = *x + t * *d;
            }
            f(trial, g_trial)
        };
        let mut done = false;
        for _ in 0..EVALUATIONS {
            v = at(t, &mut trial, &mut g_trial);
            if v.is_nan() || v > value + ARMIJO * t * slope {
                high = t;
            } else if dot(&g_trial, &direction) >= CURVATURE * slope {
                done = true;
                break;
            } else {
                low = t;
            }
            t = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * t };
        }
        if !done && low > 0.0 {
            // The longest step that lowered the value enough.
            v = at(low, &mut trial, &mut g_trial);
            done = true;
        }
        if !done {
            if memory.is_empty() {
                break;
            }
            memory.clear();
            continue;
        }
        let (mut s, mut y) = match memory.len() {
            MEMORY => memory.pop_front().map_or_else(|| (zero(), zero()), |m| (m.0, m.1)),
            _ => (zero(), zero()),
        };
        for i in 0..n {
            s[i] = trial[i] - x[i];
            y[i] = g_trial[i] - g[i];
        }
        let sy = dot(&s, &y);
        if sy > 0.0 {
            memory.push_back((s, y, 1.0 / sy));
        }
        x.copy_from_slice(&trial);
        std::mem::swap(&mut g, &mut g_trial);
        let decrease = value - v;
        value = v;
        if decrease <= tolerance * value.abs() {
            break;
        }
    }
    value
}
