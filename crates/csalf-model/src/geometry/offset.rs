//! Surfaces at a constant distance from free-form ones, as B-splines through points of them.
//!
//! ```text
//!      ×───×───×───×    offset: S + distance · normal        × points at Greville's parameters of cubic splines
//!      │   │   │   │
//!      ●───●───●───●    S, its knots ●                       more pieces between knots until it fits
//! ```
//!
//! An offset of a rational surface is not rational, so it is fitted: interpolated in all points of a grid (two banded
//! systems, one per direction), compared with the exact offset between them, and refined by halves. At the surface's own
//! knots the splines are only continuous, since the offset of a smooth surface may bend there. Source: Piegl and Tiller,
//! *The NURBS Book*, 9.2 (interpolation), 10.7 (offsets by fitting).

use super::nurbs::{Knots, NurbsSurface};
use glam::{DVec2, DVec3, DVec4};
use nalgebra::DMatrix;

/// Degree of the splines.
const DEGREE: usize = 3;
/// Most control points along one direction.
const MOST: usize = 400;

/// Knots of cubic splines with `pieces` pieces between neighbouring knots of `of`, and Greville's parameters.
fn knots(of: &Knots, pieces: usize) -> Option<(Knots, Vec<f64>)> {
    let breaks = of.breaks();
    let mut t = vec![breaks[0]; DEGREE + 1];
    for w in breaks.windows(2) {
        t.extend((1..pieces).map(|k| w[0] + (w[1] - w[0]) * k as f64 / pieces as f64));
        t.extend([w[1]; DEGREE]);
    }
    t.extend(breaks.last());
    let n = t.len() - DEGREE - 1;
    let greville = (0..n).map(|i| t[i + 1..=i + DEGREE].iter().sum::<f64>() / DEGREE as f64).collect();
    Some((Knots::new(DEGREE, t, n)?, greville))
}

/// The matrix of basis functions (columns) at parameters (rows).
fn collocation(knots: &Knots, at: &[f64]) -> DMatrix<f64> {
    let mut a = DMatrix::zeros(at.len(), knots.n());
    for (i, &t) in at.iter().enumerate() {
        for (k, value) in knots.values(t) {
            a[(i, k)] = value;
        }
    }
    a
}

impl NurbsSurface {
    /// The surface at `distance` along the normal, to `tolerance`; `None` if it has no normal somewhere, or bends so much
    /// that no fit of 400 by 400 points comes so near.
    pub fn offset(&self, distance: f64, tolerance: f64) -> Option<Self> {
        let exact = |u: f64, v: f64| {
            let s = self.eval(DVec2::new(u, v));
            let n = s.du.cross(s.dv).try_normalize()?;
            Some(s.point + n * distance)
        };
        let mut pieces = 2;
        loop {
            let (ku, us) = knots(&self.knots[0], pieces)?;
            let (kv, vs) = knots(&self.knots[1], pieces)?;
            if us.len().max(vs.len()) > MOST {
                return None;
            }
            let mut points = Vec::with_capacity(us.len() * vs.len());
            for &u in &us {
                for &v in &vs {
                    points.push(exact(u, v)?);
                }
            }
            let (along_u, along_v) = (collocation(&ku, &us).lu(), collocation(&kv, &vs).lu());
            let mut control = vec![DVec3::ZERO; points.len()];
            for axis in 0..3 {
                let grid = DMatrix::from_fn(us.len(), vs.len(), |i, j| points[i * vs.len() + j][axis]);
                let half = along_u.solve(&grid)?;
                let full = along_v.solve(&half.transpose())?;
                for (k, c) in control.iter_mut().enumerate() {
                    c[axis] = full[(k % vs.len(), k / vs.len())];
                }
            }
            let points: Vec<DVec4> = control.iter().map(|p| p.extend(1.0)).collect();
            let fit = Self { knots: [ku, kv], points, periods: self.periods };
            let mut off = 0.0f64;
            for u in us.windows(2).map(|w| 0.5 * (w[0] + w[1])) {
                for v in vs.windows(2).map(|w| 0.5 * (w[0] + w[1])) {
                    off = off.max(fit.eval(DVec2::new(u, v)).point.distance(exact(u, v)?));
                }
            }
            if off <= tolerance {
                return Some(fit);
            }
            pieces *= 2;
        }
    }
}
