//! How many quads a size field asks for: the integral of dA / h² over the domain (handbook 8.5).
//!
//! 1. [`Background::expected_quads`] is exact for a field that is linear on triangles.
//! 2. [`expected_quads`] takes any field: the domain is triangulated, and triangles are split into four until the
//!    three-point rule agrees with itself.
//!
//! A mesher makes a few per cent more (about 5 %), because quads cannot be everywhere as large as asked.

use crate::build::loop_indices;
use crate::{Background, Hint, SizeError, SizeField};
use csalf_geom::{Point2, polygon::signed_area};

/// Most halvings of a triangle in [`expected_quads`]: 4^8 cells.
const MAX_DEPTH: u32 = 8;
/// A triangle is done if one more halving changes its share by less than this part of the share, ...
const ACCURACY: f64 = 1e-3;
/// ... or by less than this many quads.
const SMALL: f64 = 1e-3;

/// Corner values whose relative difference is at most this take the mean: the next term of the series is below 1e-6
/// of it, while divided differences lose digits.
const NEARLY_EQUAL: f64 = 1e-3;
/// Below this ln(1 + x) / x is 1 to the last digits.
const TINY: f64 = 1e-12;

impl Background {
    /// Integral of dA / h² over the triangles of the domain, without dimension. Exact up to rounding. O(n).
    pub fn expected_quads(&self) -> f64 {
        let at: Vec<Point2> = self.points().collect();
        let h: Vec<f64> = self.values().collect();
        self.triangles()
            .map(|t| {
                let [a, b, c] = t.map(|v| at[v as usize]);
                (b - a).perp_dot(c - a) * mean_inverse_square(t.map(|v| h[v as usize]))
            })
            .sum()
    }
}

/// Half the mean of 1 / h² over a triangle with these corner values: the second divided difference of -ln h, since
/// the second derivative of -ln h is 1 / h² (Hermite-Genocchi formula).
fn mean_inverse_square(mut h: [f64; 3]) -> f64 {
    h.sort_unstable_by(f64::total_cmp);
    let [a, b, c] = h;
    if c - a <= NEARLY_EQUAL * a {
        let mean = (a + b + c) / 3.0;
        return 0.5 / (mean * mean);
    }
    let first = |u: f64, v: f64| {
        let x = (v - u) / u;
        // ln(1 + x) / x goes to 1 - x / 2.
        -(if x < TINY { 1.0 } else { x.ln_1p() / x }) / u
    };
    (first(b, c) - first(a, b)) / (c - a)
}

/// Integral of dA / h² over the domain in the closed `loops` (any order and orientation), without dimension, to
/// about half a per cent (kinks of the field inside a triangle cost the most). Cost: a triangulation of the loop nodes, and queries by the variation of the field.
///
/// # Errors
/// [`SizeError`] of loops that bound no area or have bad coordinates.
pub fn expected_quads(field: &dyn SizeField, loops: &[Vec<Point2>]) -> Result<f64, SizeError> {
    if let Some(h) = field.constant() {
        let areas = loops.iter().map(|l| signed_area(l).abs());
        // The outer loop has the largest area, the others are holes.
        let (sum, largest) = areas.fold((0.0, 0.0f64), |(s, m), a| (s + a, m.max(a)));
        return Ok((2.0 * largest - sum) / (h * h));
    }
    let points: Vec<Point2> = loops.iter().flatten().copied().collect();
    let mesh = Background::from_points(&points, &vec![1.0; points.len()], &loop_indices(loops))?;
    let at: Vec<Point2> = mesh.points().collect();
    let mut hint = Hint::default();
    let mut rate = |p: Point2| field.h(p, &mut hint).powi(-2);
    Ok(mesh
        .triangles()
        .map(|t| {
            let t = t.map(|v| at[v as usize]);
            let coarse = three_points(t, &mut rate);
            adapt(t, coarse, 0, &mut rate)
        })
        .sum())
}

/// The rule of the three side middles of a triangle, exact for quadratic functions.
fn three_points([a, b, c]: [Point2; 3], rate: &mut impl FnMut(Point2) -> f64) -> f64 {
    let area = 0.5 * (b - a).perp_dot(c - a);
    area * (rate(a.midpoint(b)) + rate(b.midpoint(c)) + rate(c.midpoint(a))) / 3.0
}

fn adapt(t: [Point2; 3], coarse: f64, depth: u32, rate: &mut impl FnMut(Point2) -> f64) -> f64 {
    let [a, b, c] = t;
    let [ab, bc, ca] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
    let children = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
    let parts = children.map(|t| three_points(t, rate));
    let fine: f64 = parts.iter().sum();
    // The first halvings are always made where there are many quads: a spot may hide between the samples.
    let done = (fine - coarse).abs() <= (ACCURACY * fine).max(SMALL) && (depth >= 2 || fine < 64.0);
    if done || depth == MAX_DEPTH {
        return fine;
    }
    children.into_iter().zip(parts).map(|(t, part)| adapt(t, part, depth + 1, rate)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Source, Sources, Uniform};

    fn p(x: f64, y: f64) -> Point2 {
        Point2::new(x, y)
    }

    fn square() -> Vec<Point2> {
        vec![p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)]
    }

    #[test]
    fn a_ramp_has_a_closed_form() {
        // h from 0.1 to 0.4: the integral of dx / h² is (1/0.1 - 1/0.4) / 0.3 = 25.
        let b = Background::from_points(&square(), &[0.1, 0.4, 0.4, 0.1], &[vec![0, 1, 2, 3]]).unwrap();
        assert!((b.expected_quads() - 25.0).abs() < 1e-12);
        assert!((expected_quads(&b, &[square()]).unwrap() - 25.0).abs() < 0.03);
    }

    #[test]
    fn nearly_equal_values_keep_their_digits() {
        for e in [0.0, 1e-15, 1e-9, 1e-4, 0.9e-3, 1.1e-3, 1e-2] {
            let b = Background::from_points(
                &square(),
                &[0.5, 0.5 * (1.0 + e), 0.5 * (1.0 + e), 0.5],
                &[vec![0, 1, 2, 3]],
            )
            .unwrap();
            let exact = 4.0 / (1.0 + e);
            assert!((b.expected_quads() / exact - 1.0).abs() < 1e-6, "{e}");
        }
    }

    #[test]
    fn constant_fields_and_holes() {
        let hole = vec![p(0.25, 0.25), p(0.25, 0.75), p(0.75, 0.75), p(0.75, 0.25)];
        assert_eq!(expected_quads(&Uniform(0.1), &[hole.clone(), square()]).unwrap().round(), 75.0);
        let far = Source { xy: p(9., 9.), h: 0.05, radius: 0.0, falloff: 1.0 };
        let f = Sources::new(0.1, &[far], None).unwrap();
        assert!((expected_quads(&f, &[square(), hole]).unwrap() - 75.0).abs() < 1e-9);
        assert_eq!(expected_quads(&f, &[]).unwrap_err(), SizeError::NoArea);
    }

    #[test]
    fn a_spot_is_integrated() {
        let s = Source { xy: p(0.5, 0.5), h: 0.01, radius: 0.1, falloff: 0.2 };
        let f = Sources::new(0.05, &[s], None).unwrap();
        // Disc, cone (exact: 2π ∫ r dr / h² with h = 0.01 + 0.2 (r - 0.1)), and the rest.
        let pi = std::f64::consts::PI;
        // r = h / 0.2 + 0.05: ∫ r dh / (0.2 h²) = (5 ln(h) - 0.05 / h) / 0.2.
        let stem = |h: f64| (5.0 * h.ln() - 0.05 / h) / 0.2;
        let exact = pi * 0.01 / 1e-4 + 2.0 * pi * (stem(0.05) - stem(0.01)) + (1.0 - pi * 0.09) / 0.0025;
        let got = expected_quads(&f, &[square()]).unwrap();
        assert!((got / exact - 1.0).abs() < 5e-3, "{got} {exact}");
    }
}
