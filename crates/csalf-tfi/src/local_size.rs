//! The size field over one contour as a parabola: what the forecasts need, at the price of a few products.
//!
//! ```text
//!      o---o---o        h(p) ≈ a + b x + c y + d x² + e x y + f y², least squares over the contour nodes and a few
//!      | · · · |        points · inside, clamped to their range; taken unless it misses some of them by far
//!      o---o---o
//! ```
//!
//! A query of a background mesh costs 20 to 100 ns, and the forecasts of one contour would ask hundreds of times.

use csalf_geom::Point2;
use csalf_mesh::Contour;
use csalf_sizemap::{Hint, SizeField};

/// Largest root mean square of the relative misfit at the nodes. Larger: more contours take the fast way, and their
/// size errors are forecast wrong by as much. A forecast ranks; finished patches are measured by the field itself.
const MISFIT: f64 = 0.2;
/// Largest relative misfit at a point inside.
const MISFIT_INSIDE: f64 = 0.4;
/// The same at the centre of a contour whose nodes all have one size.
const MISFIT_FLAT: f64 = 0.08;
/// Points inside: the mean of the nodes, and points between it and so many nodes.
const INSIDE: usize = 6;
/// Sizes that differ by less than this factor count as constant.
const CONSTANT: f64 = 1.03;
/// Coefficients.
const M: usize = 6;

/// See the [module](self).
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalSize {
    centre: Point2,
    /// One over the radius of the contour: arguments are of order one.
    scale: f64,
    c: [f64; M],
    low: f64,
    high: f64,
    mean: f64,
}

fn basis(d: Point2) -> [f64; M] {
    [1.0, d.x, d.y, d.x * d.x, d.x * d.y, d.y * d.y]
}

impl LocalSize {
    /// The parabola through the sizes of the contour, if it fits. Cost: O(n) and seven queries, one if the sizes at
    /// the nodes are all the same.
    pub(crate) fn of(contour: &Contour, size: &dyn SizeField) -> Option<Self> {
        let n = contour.len();
        let centre = contour.points.iter().sum::<Point2>() / n as f64;
        let radius2 = contour.points.iter().map(|p| p.distance_squared(centre)).fold(0.0, f64::max);
        // Not of a point, nor of NaN.
        if radius2 <= 0.0 || !radius2.is_finite() {
            return None;
        }
        let scale = 1.0 / radius2.sqrt();
        let mean = contour.sizes.iter().sum::<f64>() / n as f64;
        let low = contour.sizes.iter().copied().fold(f64::INFINITY, f64::min);
        let high = contour.sizes.iter().copied().fold(0.0, f64::max);
        let mut hint = Hint::default();
        let at_centre = size.h(centre, &mut hint);
        let mut out = Self { centre, scale, c: [0.0; M], low, high, mean };
        if high <= CONSTANT * low {
            out.c[0] = mean;
            return ((at_centre / mean - 1.0).abs() <= MISFIT_FLAT).then_some(out);
        }
        let mut inside = [(centre, at_centre); INSIDE + 1];
        for (k, slot) in inside.iter_mut().enumerate().skip(1) {
            let p = centre.midpoint(contour.points[k * n / (INSIDE + 1)]);
            *slot = (p, size.h(p, &mut hint));
        }
        // A point inside counts as much as some nodes.
        let weight = (n as f64 / 12.0).max(1.0);
        let mut m = [[0.0; M + 1]; M];
        let mut add = |p: Point2, h: f64, w: f64| {
            let f = basis((p - centre) * scale);
            for i in 0..M {
                for j in i..M {
                    m[i][j] += w * f[i] * f[j];
                }
                m[i][M] += w * f[i] * h;
            }
        };
        contour.points.iter().zip(&contour.sizes).for_each(|(&p, &h)| add(p, h, 1.0));
        for &(p, h) in &inside {
            add(p, h, weight);
            (out.low, out.high) = (out.low.min(h), out.high.max(h));
        }
        out.c = solve(m)?;
        let misfit = |p: Point2, h: f64| out.at(p) / h - 1.0;
        let pairs = contour.points.iter().zip(&contour.sizes);
        let sum: f64 = pairs.map(|(&p, &h)| misfit(p, h).powi(2)).sum();
        let good = sum <= MISFIT * MISFIT * n as f64
            && inside.iter().all(|&(p, h)| misfit(p, h).abs() <= MISFIT_INSIDE);
        good.then_some(out)
    }

    #[inline]
    fn at(&self, p: Point2) -> f64 {
        let d = (p - self.centre) * self.scale;
        let c = &self.c;
        let h = c[0] + d.x * (c[1] + c[3] * d.x + c[4] * d.y) + d.y * (c[2] + c[5] * d.y);
        h.max(self.low).min(self.high)
    }
}

/// Solves the symmetric system whose upper half and right-hand side are given, by Cholesky's elimination with a small
/// ridge: of nodes on one line the terms across it stay near 0.
fn solve(mut m: [[f64; M + 1]; M]) -> Option<[f64; M]> {
    /// The ridge as a part of the first pivot. Larger: falsifies good fits; smaller: lost in rounding. *Arbitrary.*
    const RIDGE: f64 = 1e-9;
    let ridge = RIDGE * m[0][0];
    for (i, row) in m.iter_mut().enumerate() {
        row[i] += ridge;
    }
    for i in 0..M {
        if m[i][i] <= 0.0 || m[i][i].is_nan() {
            return None;
        }
        for j in i + 1..M {
            let f = m[i][j] / m[i][i];
            let row = m[i];
            for k in j..=M {
                m[j][k] -= f * row[k];
            }
        }
    }
    let mut x = [0.0; M];
    for i in (0..M).rev() {
        let s: f64 = (i + 1..M).map(|k| m[i][k] * x[k]).sum();
        x[i] = (m[i][M] - s) / m[i][i];
    }
    Some(x)
}

impl SizeField for LocalSize {
    fn h(&self, p: Point2, _: &mut Hint) -> f64 {
        self.at(p)
    }
    fn constant(&self) -> Option<f64> {
        (self.high <= CONSTANT * self.low).then_some(self.mean)
    }
    fn range(&self) -> (f64, f64) {
        (self.low, self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_sizemap::{Source, Sources, Uniform};

    /// The parabola that the tests ask for.
    #[derive(Debug)]
    struct Bowl;
    impl SizeField for Bowl {
        fn h(&self, p: Point2, _: &mut Hint) -> f64 {
            let d = p - Point2::new(5.0, 3.0);
            0.3 + 0.02 * d.x - 0.01 * d.y + 0.05 * d.x * d.x + 0.02 * d.x * d.y + 0.04 * d.y * d.y
        }
        fn range(&self) -> (f64, f64) {
            (0.2, 1.0)
        }
    }

    fn ring(h: impl Fn(Point2) -> f64) -> Contour {
        let p: Vec<Point2> =
            (0..24).map(|i| Point2::new(5.0, 3.0) + Point2::from_angle(f64::from(i) * 0.2618)).collect();
        let mut c = Contour::from_ring(&p, 1.0);
        c.sizes = p.iter().map(|&p| h(p)).collect();
        c
    }

    #[test]
    fn parabolas_are_exact() {
        let a = LocalSize::of(&ring(|p| Bowl.h(p, &mut Hint::default())), &Bowl).unwrap();
        for q in [Point2::new(5.3, 2.9), Point2::new(4.4, 3.2)] {
            let want = Bowl.h(q, &mut Hint::default());
            assert!((a.h(q, &mut Hint::default()) - want).abs() < 1e-6);
        }
        assert_eq!(a.constant(), None);
        assert!(LocalSize::of(&ring(|_| 0.4), &Uniform(0.4)).unwrap().constant().is_some());
    }

    #[test]
    fn ridges_and_spots_are_refused() {
        let steep = |p: Point2| if p.x > 5.3 { 0.4 } else { 0.1 };
        assert!(LocalSize::of(&ring(steep), &Uniform(0.1)).is_none());
        let spot = Source { xy: Point2::new(5.0, 3.0), h: 0.1, radius: 0.2, falloff: 0.2 };
        assert!(LocalSize::of(&ring(|_| 1.0), &Sources::new(1.0, &[spot], None).unwrap()).is_none());
    }
}
