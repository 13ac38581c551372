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

/// The matrix of the basis functions (columns) at Greville's parameters (rows), factored: row i has entries from column
/// i - 3 to i + 3 only. It is totally positive, so that elimination needs no pivots (C. de Boor, *A Practical Guide to
/// Splines*, ch. 13).
struct Collocation {
    rows: Vec<[f64; 2 * DEGREE + 1]>,
}

impl Collocation {
    /// `None` if the matrix is singular.
    fn new(knots: &Knots, at: &[f64]) -> Option<Self> {
        let n = at.len();
        let mut rows = vec![[0.0; 2 * DEGREE + 1]; n];
        for (i, &t) in at.iter().enumerate() {
            for (k, value) in knots.values(t).filter(|v| v.0.abs_diff(i) <= DEGREE) {
                rows[i][DEGREE + k - i] = value;
            }
        }
        for i in 0..n {
            let pivot = rows[i][DEGREE];
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            for r in i + 1..n.min(i + DEGREE + 1) {
                let share = rows[r][DEGREE + i - r] / pivot;
                for c in i + 1..n.min(i + DEGREE + 1) {
                    rows[r][DEGREE + c - r] -= share * rows[i][DEGREE + c - i];
                }
                rows[r][DEGREE + i - r] = share;
            }
        }
        Some(Self { rows })
    }

    /// Solves in place.
    fn solve(&self, x: &mut [DVec3]) {
        let n = x.len();
        for i in 0..n {
            for k in i.saturating_sub(DEGREE)..i {
                x[i] -= self.rows[i][DEGREE + k - i] * x[k];
            }
        }
        for i in (0..n).rev() {
            for k in i + 1..n.min(i + DEGREE + 1) {
                x[i] -= self.rows[i][DEGREE + k - i] * x[k];
            }
            x[i] /= self.rows[i][DEGREE];
        }
    }
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
            let (along_u, along_v) = (Collocation::new(&ku, &us)?, Collocation::new(&kv, &vs)?);
            points.chunks_mut(vs.len()).for_each(|row| along_v.solve(row));
            let mut column = vec![DVec3::ZERO; us.len()];
            for j in 0..vs.len() {
                column.iter_mut().zip(points[j..].iter().step_by(vs.len())).for_each(|(c, p)| *c = *p);
                along_u.solve(&mut column);
                points[j..].iter_mut().step_by(vs.len()).zip(&column).for_each(|(p, c)| *p = *c);
            }
            let points: Vec<DVec4> = points.iter().map(|p| p.extend(1.0)).collect();
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
