//! Relaxing a map without flips: symmetric Dirichlet energy, free boundary, nothing ever turned over.
//!
//! ```text
//!   E = sum of area (s1² + s2² + 1/s1² + 1/s2²)     s: singular values of each facet's map; best 1, 1
//! ```
//!
//! 1. Each facet asks for its nearest rotation, with weights that make the gradient that of E.
//! 2. One sparse solve gives a direction. 3. The step ends before the first facet is turned over, and is
//!    halved until E falls. Again, until E stands still.
//!
//! Source: Rabinovich et al. 2017 (SLIM), as told in handbook 9.2.

use super::Flat;
use super::map::{gradients, jacobian, singular};
use super::sparse::{Order, Symmetric};
use crate::patch::Chart;
use glam::{DMat2, DVec2};

/// Most iterations. (Handbook: 5 to 20.)
const ITERATIONS: usize = 25;
/// Relative fall of E below which the map is done.
const SETTLED: f64 = 1e-3;
/// Weight of staying put, per vertex, as a share of the mean diagonal: makes the system definite.
const STAY: f64 = 1e-4;

/// The relaxed map; `flat` itself if it has a flip.
pub(crate) fn relax(chart: &Chart, order: &Order, mut flat: Flat) -> Flat {
    let shapes: Vec<([DVec2; 3], f64)> =
        chart.triangles.iter().map(|t| gradients(t.map(|v| chart.points[v as usize]))).collect();
    let mut e = energy(chart, &shapes, &flat);
    for _ in 0..ITERATIONS {
        if !e.is_finite() {
            break;
        }
        let Some(target) = solve(chart, order, &shapes, &flat) else { break };
        let step = |t: f64| -> Flat { flat.iter().zip(&target).map(|(a, b)| a.lerp(*b, t)).collect() };
        let mut t = 1f64.min(0.9 * first_flip(chart, &flat, &target));
        let mut better = None;
        for _ in 0..12 {
            let next = step(t);
            let e_next = energy(chart, &shapes, &next);
            if e_next < e {
                better = Some((next, e_next));
                break;
            }
            t *= 0.5;
        }
        let Some((next, e_next)) = better else { break };
        let settled = e_next > (1.0 - SETTLED) * e;
        (flat, e) = (next, e_next);
        if settled {
            break;
        }
    }
    flat
}

fn energy(chart: &Chart, shapes: &[([DVec2; 3], f64)], flat: &Flat) -> f64 {
    let mut sum = 0.0;
    for (t, (g, area)) in chart.triangles.iter().zip(shapes) {
        let (s1, s2) = singular(jacobian(g, t.map(|v| flat[v as usize])));
        if s2 <= 0.0 || s2.is_nan() {
            return f64::INFINITY;
        }
        sum += area * (s1 * s1 + s2 * s2 + 1.0 / (s1 * s1) + 1.0 / (s2 * s2));
    }
    sum
}

/// Singular values so close to 1 take the limit of their weight.
const UNIT: f64 = 1e-6;
/// Singular values whose squares differ by less than this share are one.
const ROUND: f64 = 1e-9;

fn solve(chart: &Chart, order: &Order, shapes: &[([DVec2; 3], f64)], flat: &Flat) -> Option<Flat> {
    let n = flat.len();
    let mut matrix = Symmetric::new(2 * n);
    let mut rhs = vec![0f64; 2 * n];
    let mut diagonal = 0.0;
    for (t, (g, area)) in chart.triangles.iter().zip(shapes) {
        let j = jacobian(g, t.map(|v| flat[v as usize]));
        let (s1, s2) = singular(j);
        let weight = |s: f64| if (s - 1.0).abs() < UNIT { 4.0 } else { (s - s.powi(-3)) / (s - 1.0) };
        let (m1, m2) = (weight(s1), weight(s2));
        // M is the function of J Jᵀ that has the eigenvalues m1, m2.
        let b = j * j.transpose();
        let gap = s1 * s1 - s2 * s2;
        let beta = if gap > ROUND * s1 * s1 { (m1 - m2) / gap } else { 0.0 };
        let m = DMat2::from_diagonal(DVec2::splat(m1 - beta * s1 * s1)) + b * beta;
        let turn = DVec2::new(j.x_axis.x + j.y_axis.y, j.x_axis.y - j.y_axis.x).normalize_or(DVec2::X);
        let r = DMat2::from_cols(turn, turn.perp());
        for i in 0..3 {
            let a = 2 * order.rank[t[i] as usize];
            let f = *area * (m * (r * g[i]));
            rhs[a as usize] += f.x;
            rhs[a as usize + 1] += f.y;
            for k in i..3 {
                let c = 2 * order.rank[t[k] as usize];
                let w = area * g[i].dot(g[k]);
                matrix.add(a, c, w * m.x_axis.x);
                matrix.add(a + 1, c + 1, w * m.y_axis.y);
                if i == k {
                    matrix.add(a, a + 1, w * m.x_axis.y);
                    diagonal += w * (m.x_axis.x + m.y_axis.y);
                } else {
                    matrix.add(a, c + 1, w * m.x_axis.y);
                    matrix.add(a + 1, c, w * m.x_axis.y);
                }
            }
        }
    }
    let stay = STAY * diagonal / (2 * n) as f64;
    for (v, u) in flat.iter().enumerate() {
        let a = 2 * order.rank[v];
        matrix.add(a, a, stay);
        matrix.add(a + 1, a + 1, stay);
        rhs[a as usize] += stay * u.x;
        rhs[a as usize + 1] += stay * u.y;
    }
    matrix.factor()?.solve(&mut rhs);
    let at = |v: usize| 2 * order.rank[v] as usize;
    let out: Flat = (0..n).map(|v| DVec2::new(rhs[at(v)], rhs[at(v) + 1])).collect();
    out.iter().all(|p| p.is_finite()).then_some(out)
}

/// The smallest step at which a facet has no area.
fn first_flip(chart: &Chart, from: &Flat, to: &Flat) -> f64 {
    let mut least = f64::INFINITY;
    for t in &chart.triangles {
        let u = t.map(|v| from[v as usize]);
        let d = t.map(|v| to[v as usize] - from[v as usize]);
        let (e, f) = (u[1] - u[0], u[2] - u[0]);
        let (de, df) = (d[1] - d[0], d[2] - d[0]);
        // c + b t + a t²
        let (c, b, a) = (e.perp_dot(f), e.perp_dot(df) + de.perp_dot(f), de.perp_dot(df));
        let disc = b * b - 4.0 * a * c;
        if disc < 0.0 {
            continue;
        }
        // The smaller positive root, without cancellation.
        let q = -0.5 * (b + disc.sqrt().copysign(b));
        for r in [q / a, c / q] {
            if r > 0.0 {
                least = least.min(r);
            }
        }
    }
    least
}
