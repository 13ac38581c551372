//! From a point in space to the parameters of the nearest point on a surface.
//!
//! ```text
//!   closed form            plane, cylinder, cone, sphere, torus
//!   hint given             Newton from the hint; good if it comes as near as the tolerance
//!   else                   nearest of a grid of samples, Newton from the best few, the nearest wins
//! ```
//!
//! Newton wraps round closed directions and is clamped in open ones.

use super::Surface;
use glam::{DVec2, DVec3};

/// Samples per direction of the grid, at most.
const MAX_GRID: usize = 64;
/// Samples per knot span.
const PER_SPAN: usize = 5;
/// Grid points from which Newton is started.
const STARTS: usize = 4;

/// Inverts one surface; holds its grid of samples.
#[derive(Clone, Debug)]
pub struct Inverter<'a> {
    surface: &'a Surface,
    grid: Vec<(DVec2, DVec3)>,
}

impl<'a> Inverter<'a> {
    /// Prepares the inversion of points that lie within `region` (low and high parameters), if it is known.
    /// Cost: at most 64 × 64 evaluations for NURBS, none for the others.
    pub fn new(surface: &'a Surface) -> Self {
        let mut grid = Vec::new();
        if let Surface::Nurbs(n) = surface {
            let samples = |k: usize| -> Vec<f64> {
                let breaks = n.knots[k].breaks();
                let per = (MAX_GRID / breaks.len().max(1)).clamp(1, PER_SPAN);
                let mut s: Vec<f64> = breaks
                    .windows(2)
                    .flat_map(|w| (0..per).map(move |i| w[0] + (w[1] - w[0]) * i as f64 / per as f64))
                    .collect();
                s.extend(breaks.last());
                let stride = s.len().div_ceil(4 * MAX_GRID).max(1);
                s.into_iter().step_by(stride).collect()
            };
            let (us, vs) = (samples(0), samples(1));
            for &u in &us {
                for &v in &vs {
                    let uv = DVec2::new(u, v);
                    grid.push((uv, n.eval(uv).point));
                }
            }
        }
        Self { surface, grid }
    }

    /// The surface.
    pub const fn surface(&self) -> &'a Surface {
        self.surface
    }

    /// Parameters of the point of the surface nearest to `p`, and how far it is. Near `hint`, if one is given and a
    /// point within `good` of `p` is found from it; angles and closed directions come as near the hint as they can.
    pub fn invert(&self, p: DVec3, hint: Option<DVec2>, good: f64) -> (DVec2, f64) {
        let uv = match self.surface.closed_form_parameters(p) {
            Some(uv) => uv,
            None => self.search(p, hint, good),
        };
        let uv = hint.map_or(uv, |h| self.near(uv, h));
        (uv, self.surface.eval(uv).point.distance(p))
    }

    /// `uv` shifted by whole periods to come nearest to `hint`.
    pub fn near(&self, uv: DVec2, hint: DVec2) -> DVec2 {
        let one = |t: f64, h: f64, period: Option<f64>| period.map_or(t, |p| t + ((h - t) / p).round() * p);
        let [pu, pv] = self.surface.periods();
        DVec2::new(one(uv.x, hint.x, pu), one(uv.y, hint.y, pv))
    }

    fn search(&self, p: DVec3, hint: Option<DVec2>, good: f64) -> DVec2 {
        if let Some(h) = hint {
            let (uv, d) = self.newton(p, h);
            if d <= good {
                return uv;
            }
        }
        let mut starts: Vec<(f64, usize)> = Vec::with_capacity(STARTS + 1);
        for (i, (_, q)) in self.grid.iter().enumerate() {
            let d = q.distance_squared(p);
            if starts.len() < STARTS || starts.last().is_some_and(|l| d < l.0) {
                let at = starts.partition_point(|s| s.0 <= d);
                starts.insert(at, (d, i));
                starts.truncate(STARTS);
            }
        }
        let from_grid = starts.iter().map(|&(_, i)| self.newton(p, self.grid[i].0));
        let from_hint = hint.map(|h| self.newton(p, h));
        let best = from_hint.into_iter().chain(from_grid).min_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or(DVec2::ZERO, |b| b.0)
    }

    /// Gauss and Newton with damping, from `uv`: the end and its distance. A parameter at the end of an open direction
    /// stays there while the point pulls it further.
    fn newton(&self, p: DVec3, uv: DVec2) -> (DVec2, f64) {
        const STEPS: usize = 40;
        /// Moves below this share of the coordinates are rounding.
        const STILL: f64 = 1e-14;
        let Surface::Nurbs(n) = self.surface else { return (uv, self.surface.eval(uv).point.distance(p)) };
        let range = [0, 1].map(|k| if n.periods[k].is_some() { None } else { Some(n.knots[k].range()) });
        let held =
            |t: f64, g: f64, k: usize| range[k].is_some_and(|[a, b]| t <= a && g > 0.0 || t >= b && g < 0.0);
        let mut uv = n.wrap(uv);
        let mut at = n.eval(uv);
        let mut f = at.point.distance_squared(p);
        // Levenberg's damping, relative to the size of the matrix.
        let mut damping = 0.0;
        for _ in 0..STEPS {
            let r = at.point - p;
            let g = DVec2::new(r.dot(at.du), r.dot(at.dv));
            let (mut a, b, mut c) = (
                at.du.length_squared() + r.dot(at.duu).max(0.0),
                at.du.dot(at.dv) + r.dot(at.duv),
                at.dv.length_squared() + r.dot(at.dvv).max(0.0),
            );
            let trace = a + c;
            if trace <= 0.0 {
                break;
            }
            a += damping * trace;
            c += damping * trace;
            let det = a * c - b * b;
            let step = match [held(uv.x, g.x, 0), held(uv.y, g.y, 1)] {
                [true, true] => break,
                [true, false] => DVec2::new(0.0, -g.y / if c > 0.0 { c } else { trace }),
                [false, true] => DVec2::new(-g.x / if a > 0.0 { a } else { trace }, 0.0),
                _ if det > f64::EPSILON * a * c => DVec2::new(b * g.y - c * g.x, b * g.x - a * g.y) / det,
                _ => -g / trace,
            };
            let next = n.wrap(uv + step);
            let there = n.eval(next);
            let d = there.point.distance_squared(p);
            let still = there.point.distance_squared(at.point) <= STILL * STILL * p.length_squared().max(f);
            if d < f {
                (uv, at, f) = (next, there, d);
                damping *= 0.25;
            } else {
                if damping > 1e6 {
                    break;
                }
                damping = if damping == 0.0 { 1e-3 } else { damping * 8.0 };
            }
            if still {
                break;
            }
        }
        (uv, f.sqrt())
    }
}
