//! Where the new nodes of a front go.
//!
//! ```text
//!          Q                     R-----S                  all rays at perpendicular distance t from the edge
//!         /  \  t                |     |                  they lie beside; diagonal nodes complete parallelograms
//!   A ---B--- C            A ----B-----Q
//!        theta                   |
//!                                C
//! ```
//!
//! - Flat: on the bisector, at t / sin(theta/2) (paper eq. 1).
//! - Right reversal: rays at 2/3 and 1/3 of theta from BC, at t / sin(theta/3); S = R + Q - B.
//! - Reversal: rays at 3/4, 2/4, 1/4 of theta, at t / sin(theta/4); S = R + T - B, U = T + Q - B.
//! - Corner (E): the kite point, whose three free angles are equal, or the mitre point on the bisector.
//!
//! [`PavingRules::Paper`] keeps the printed form: diagonal nodes at √2 times the ray length on the mid direction,
//! and thickness by the harmonic mean of the size map (eq. 2). Source: paper Table I; handbook 1.1, 1.2, 2.3.

use csalf_geom::Point2;
use csalf_geom::angle::{interior_angle, rotated};
use std::f64::consts::{SQRT_2, TAU};

/// Which formulas place the nodes.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum PavingRules {
    /// Parallelogram diagonals, kite corners, local thickness.
    #[default]
    Corrected,
    /// Table I and eqs. (1), (2) letter for letter.
    Paper,
}

/// A front seen from its node: where A, B and C lie, the angle and the wanted perpendicular thickness.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    /// The node before.
    pub a: Point2,
    /// The node itself.
    pub b: Point2,
    /// The node after.
    pub c: Point2,
    /// Interior angle at b in radians, (0, 2π].
    pub theta: f64,
    /// Thickness t, model units, > 0.
    pub t: f64,
}

impl Site {
    /// The site at `b`, its angle measured (a slit tip gives 2π).
    pub fn new(a: Point2, b: Point2, c: Point2, t: f64) -> Self {
        Self { a, b, c, theta: interior_angle(a, b, c), t }
    }

    /// Unit direction that lies at `angle` counter-clockwise from BC.
    #[inline]
    fn direction(&self, angle: f64) -> Point2 {
        rotated((self.c - self.b).normalize_or_zero(), angle)
    }

    /// Q of a flat front; also the mitre point of a corner.
    #[inline]
    pub fn flat(&self) -> Point2 {
        let u = (self.c - self.b).normalize_or_zero();
        let v = (self.b - self.a).normalize_or_zero();
        // Mitre without angles where the turn is mild: (n_ab + n_bc) t / (1 + n_ab · n_bc).
        let d = 1.0 + u.dot(v);
        if d > 0.5 {
            return self.b + (u.perp() + v.perp()) * (self.t / d);
        }
        let half = 0.5 * self.theta;
        self.b + self.direction(half) * (self.t / half.sin())
    }

    /// R, S, Q of a right reversal.
    pub fn right_reversal(&self, rules: PavingRules) -> [Point2; 3] {
        let l = self.t / (self.theta / 3.0).sin();
        let r = self.direction(self.theta * 2.0 / 3.0) * l;
        let q = self.direction(self.theta / 3.0) * l;
        let s = match rules {
            PavingRules::Corrected => r + q,
            PavingRules::Paper => self.direction(self.theta / 2.0) * (SQRT_2 * l),
        };
        [self.b + r, self.b + s, self.b + q]
    }

    /// R, S, T, U, Q of a reversal.
    pub fn reversal(&self, rules: PavingRules) -> [Point2; 5] {
        let l = self.t / (self.theta / 4.0).sin();
        let at = |share: f64| self.direction(self.theta * share) * l;
        let (r, t, q) = (at(0.75), at(0.5), at(0.25));
        let (s, u) = match rules {
            PavingRules::Corrected => (r + t, t + q),
            PavingRules::Paper => (at(0.625) * SQRT_2, at(0.375) * SQRT_2),
        };
        [r, s, t, u, q].map(|v| self.b + v)
    }

    /// The kite point of a corner: the rays from A and C that make the angle β = (2π - theta)/3 with the edges,
    /// so that the angles at A, C and P are all β. `None` if they do not meet in front.
    pub fn kite(&self) -> Option<Point2> {
        let beta = (TAU - self.theta) / 3.0;
        let u = rotated((self.b - self.a).normalize_or_zero(), beta);
        let v = rotated((self.b - self.c).normalize_or_zero(), -beta);
        let det = u.perp_dot(v);
        let along = (self.c - self.a).perp_dot(v) / det;
        (along.is_finite() && along > 0.0).then(|| self.a + u * along)
    }

    /// P of a corner: the kite point where the thickness is near the edge length (ratio 0.7 to 1.4), otherwise the
    /// mitre point.
    pub fn corner(&self) -> Point2 {
        let rho = 2.0 * self.t / (self.a.distance(self.b) + self.b.distance(self.c));
        if (0.7..=1.4).contains(&rho) { self.kite().unwrap_or_else(|| self.flat()) } else { self.flat() }
    }

    /// The end of a chain whose covered edge is B → C: perpendicular to it.
    pub fn start(&self) -> Point2 {
        self.b + (self.c - self.b).normalize_or_zero().perp() * self.t
    }

    /// The end of a chain whose covered edge is A → B: perpendicular to it.
    pub fn end(&self) -> Point2 {
        self.b + (self.b - self.a).normalize_or_zero().perp() * self.t
    }
}

/// Harmonic mean of three sizes: 3 / (1/ga + 1/gb + 1/gc) (paper eq. 2 without the sine).
#[inline]
pub fn harmonic(ga: f64, gb: f64, gc: f64) -> f64 {
    3.0 / (1.0 / ga + 1.0 / gb + 1.0 / gc)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(x: f64, y: f64) -> Point2 {
        Point2::new(x, y)
    }

    fn close(a: Point2, b: Point2) {
        assert!(a.distance(b) < 1e-12, "{a} against {b}");
    }

    /// Handbook A.1 to A.3.
    #[test]
    fn worked_fronts() {
        close(Site::new(p(-1., 0.), p(0., 0.), p(1., 0.), 1.0).flat(), p(0., 1.));
        let c = Site::new(p(-1., 0.), p(0., 0.), p(0., -1.), 1.0);
        for rules in [PavingRules::Corrected, PavingRules::Paper] {
            for (got, want) in c.right_reversal(rules).into_iter().zip([p(0., 1.), p(1., 1.), p(1., 0.)]) {
                close(got, want);
            }
            let r = Site::new(p(-1., 0.), p(0., 0.), p(-1., 0.), 1.0).reversal(rules);
            let want = [p(0., 1.), p(1., 1.), p(1., 0.), p(1., -1.), p(0., -1.)];
            for (got, want) in r.into_iter().zip(want) {
                close(got, want);
            }
        }
    }

    /// Handbook A.4.
    #[test]
    fn worked_corners() {
        let e = Site::new(p(0., 1.), p(0., 0.), p(1., 0.), 1.0);
        close(e.kite().expect("the rays meet"), p(1., 1.));
        close(e.flat(), p(1., 1.));
        let a = Point2::from_angle(60f64.to_radians());
        let e = Site::new(a, p(0., 0.), p(1., 0.), 1.0);
        let kite = e.kite().expect("the rays meet");
        assert!((kite.length() - 1.286).abs() < 5e-4);
        assert!((kite.to_angle().to_degrees() - 30.0).abs() < 1e-9);
    }

    /// Handbook A.5 and A.6.
    #[test]
    fn worked_sizes() {
        assert!((harmonic(1.0, 2.0, 4.0) - 1.714).abs() < 5e-4);
        let a = Point2::from_angle(240f64.to_radians());
        let s = Site::new(a, p(0., 0.), p(1., 0.), 1.0);
        let [r, d, q] = s.right_reversal(PavingRules::Corrected);
        assert!((r.length() - 1.015).abs() < 5e-4 && (q.length() - 1.015).abs() < 5e-4);
        assert!((d.length() - 1.555).abs() < 1e-3);
        assert!((s.right_reversal(PavingRules::Paper)[1].length() - 1.436).abs() < 5e-4);
    }

    #[test]
    fn flat_nodes_keep_their_distance_from_both_edges() {
        for deg in [80.0f64, 100.0, 150.0, 180.0, 210.0, 250.0] {
            let (a, c) = (Point2::from_angle(deg.to_radians()) * 1.3, p(0.7, 0.));
            let q = Site::new(a, p(0., 0.), c, 0.4).flat();
            assert!((q.y - 0.4).abs() < 1e-12);
            let left = (p(0., 0.) - a).normalize().perp_dot(q - a);
            assert!((left - 0.4).abs() < 1e-12, "{deg}: {left}");
        }
    }
}
