//! Extremum size gradient: how much the wanted size varies over a region.
//!
//! ```text
//!      ┌───o───o───┐
//!      o · · · · · o      samples: the contour nodes, and a lattice of 3 x 3 to 8 x 8 points inside
//!      │ · · · · · │      ESG = (95 % quantile of h) / (5 % quantile of h)  >= 1
//!      o───o───o───o
//! ```
//!
//! Source: the paper's eq. (20), whose printed form (an area integral over a number of samples) has no consistent
//! dimension; read as in handbook 1.11 (a), the only reading that fits its use, with quantiles for extremes.

use crate::{Hint, SizeField};
use csalf_geom::{Point2, polygon::bounds};

/// The paper forbids transfinite interpolation above this: it would smear a varying size.
pub const PAPER_LIMIT: f64 = 1.2;

/// ESG of the region in the closed `contour` (any orientation; nodes may repeat), >= 1; 1 of a constant field or of no nodes.
/// Cost: n + 64 size queries at most, and O(n) per row of the lattice.
pub fn extremum_size_gradient(contour: &[Point2], field: &dyn SizeField, hint: &mut Hint) -> f64 {
    let Some((low, high)) = bounds(contour.iter().copied()) else { return 1.0 };
    if field.constant().is_some() {
        return 1.0;
    }
    let mut h: Vec<f64> = contour.iter().map(|&p| field.h(p, hint)).collect();
    let k = (contour.len() / 8).clamp(3, 8);
    let mut crossings = Vec::new();
    for j in 0..k {
        let y = low.y + (high.y - low.y) * (j as f64 + 0.5) / k as f64;
        crossings_of_row(contour, y, &mut crossings);
        for i in 0..k {
            let x = low.x + (high.x - low.x) * (i as f64 + 0.5) / k as f64;
            // A sample that rounding puts on the wrong side lies on the contour: it is a fair sample all the same.
            if crossings.partition_point(|&c| c < x) % 2 == 1 {
                h.push(field.h(Point2::new(x, y), hint));
            }
        }
    }
    h.sort_unstable_by(f64::total_cmp);
    let quantile = |q: f64| h[(q * (h.len() - 1) as f64).round() as usize];
    quantile(0.95) / quantile(0.05)
}

/// Where the horizontal line at `y` crosses the contour, ascending.
fn crossings_of_row(contour: &[Point2], y: f64, out: &mut Vec<f64>) {
    out.clear();
    for (i, &a) in contour.iter().enumerate() {
        let b = contour[(i + 1) % contour.len()];
        if (a.y > y) != (b.y > y) {
            out.push(a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)));
        }
    }
    out.sort_unstable_by(f64::total_cmp);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Background, Uniform};

    fn p(x: f64, y: f64) -> Point2 {
        Point2::new(x, y)
    }

    fn ring(n: usize) -> Vec<Point2> {
        let side = |a: Point2, b: Point2| (0..n).map(move |i| a.lerp(b, i as f64 / n as f64));
        let c = [p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)];
        (0..4).flat_map(|k| side(c[k], c[(k + 1) % 4])).collect()
    }

    fn ramp(ratio: f64) -> Background {
        let c = [p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)];
        Background::from_points(&c, &[1.0, ratio, ratio, 1.0], &[vec![0, 1, 2, 3]]).unwrap()
    }

    fn esg(contour: &[Point2], f: &dyn SizeField) -> f64 {
        extremum_size_gradient(contour, f, &mut Hint::default())
    }

    #[test]
    fn constant_fields_have_one() {
        assert_eq!(esg(&ring(4), &Uniform(0.3)), 1.0);
        assert_eq!(esg(&ring(4), &ramp(1.0)), 1.0);
        assert_eq!(esg(&[], &ramp(2.0)), 1.0);
    }

    #[test]
    fn a_ramp_gives_its_ratio_and_scale_does_not_matter() {
        // A quarter of the contour nodes lies on each end side, so that the quantiles reach the extremes.
        assert!((esg(&ring(10), &ramp(8.0)) - 8.0).abs() < 1e-12);
        assert!(esg(&ring(10), &ramp(1.15)) < PAPER_LIMIT);
        assert!(esg(&ring(10), &ramp(1.25)) > PAPER_LIMIT);
        let mut turned = ring(10);
        turned.reverse();
        turned.rotate_left(7);
        assert_eq!(esg(&turned, &ramp(8.0)), esg(&ring(10), &ramp(8.0)));
    }

    #[test]
    fn the_inside_counts() {
        // All contour nodes in the flat part; a spot in the middle that only the lattice sees.
        let spot = crate::Source { xy: p(0.5, 0.5), h: 0.1, radius: 0.2, falloff: 0.2 };
        let f = crate::Sources::new(1.0, &[spot], None).unwrap();
        assert!(esg(&ring(16), &f) > 5.0);
        // The same spot in a notch is outside of the region.
        let mut notched = ring(16);
        notched.splice(32..33, [p(0.99, 0.99), p(0.1, 0.05), p(0.98, 0.99)]);
        assert!(esg(&notched, &f) >= 1.0);
    }

    #[test]
    fn one_outlier_does_not_matter() {
        let spot = crate::Source { xy: p(0.0, 0.0), h: 0.01, radius: 0.0, falloff: 0.01 };
        let f = crate::Sources::new(1.0, &[spot], None).unwrap();
        assert_eq!(esg(&ring(16), &f), 1.0);
    }
}
