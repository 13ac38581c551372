//! Random closed curves: finely drawn, with their corners marked, about 2 across, counter-clockwise, mostly simple
//! (what is not is thrown away later by `Domain::check`).

use crate::Rng;
use csalf_geom::{Point2, polygon::signed_area, predicates};
use std::f64::consts::TAU;

/// A closed curve as a polygon.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// Its points; the first is not repeated.
    pub points: Vec<Point2>,
    /// Which of them are corners, which must become nodes; as long as `points`.
    pub corner: Vec<bool>,
}

/// A kind of outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Random radius by angle, all points corners.
    Star,
    /// Random points joined by 2-opt: any simple polygon.
    TwoOpt,
    /// Smooth, by a few harmonics.
    Blob,
    /// A band wound up.
    Spiral,
    /// Teeth on a bar.
    Comb,
    /// Right angles only, with slots cut in.
    Rectilinear,
    /// Midpoint displacement, as a coast.
    Coast,
    /// A triangle with an angle of a few degrees.
    Wedge,
    /// A regular polygon, of 3 corners or more.
    Regular,
    /// A circle.
    Circle,
    /// A long thin rectangle.
    Strip,
    /// Teeth round a circle.
    Gear,
}

/// All shapes.
pub const SHAPES: [Shape; 12] = [
    Shape::Star,
    Shape::TwoOpt,
    Shape::Blob,
    Shape::Spiral,
    Shape::Comb,
    Shape::Rectilinear,
    Shape::Coast,
    Shape::Wedge,
    Shape::Regular,
    Shape::Circle,
    Shape::Strip,
    Shape::Gear,
];

fn polar(r: f64, a: f64) -> Point2 {
    Point2::new(r * a.cos(), r * a.sin())
}

impl Outline {
    /// A polygon all of whose points are corners.
    pub fn polygon(points: Vec<Point2>) -> Self {
        Self { corner: vec![true; points.len()], points }
    }

    /// A curve without corners.
    pub fn smooth(points: Vec<Point2>) -> Self {
        Self { corner: vec![false; points.len()], points }
    }

    /// A random outline of a shape.
    pub fn random(shape: Shape, rng: &mut Rng, nasty: bool) -> Self {
        let mut out = match shape {
            Shape::Star => star(rng, nasty),
            Shape::TwoOpt => two_opt(rng),
            Shape::Blob => blob(rng),
            Shape::Spiral => spiral(rng, nasty),
            Shape::Comb => comb(rng, nasty),
            Shape::Rectilinear => rectilinear(rng),
            Shape::Coast => coast(rng),
            Shape::Wedge => {
                let a = if nasty { rng.real(0.06, 0.2) } else { rng.real(0.2, 0.6) };
                Self::polygon(vec![polar(2.0, -a / 2.0), polar(rng.real(1.0, 2.0), a / 2.0), Point2::ZERO])
            }
            Shape::Regular => {
                let n = rng.int(3, 8);
                Self::polygon((0..n).map(|i| polar(1.0, TAU * i as f64 / n as f64)).collect())
            }
            Shape::Circle => Self::smooth((0..180).map(|i| polar(1.0, TAU * f64::from(i) / 180.0)).collect()),
            Shape::Strip => {
                let b = if nasty { rng.log(0.005, 0.1) } else { rng.log(0.1, 0.8) };
                Self::polygon([(0., 0.), (2., 0.), (2., b), (0., b)].map(Point2::from).to_vec())
            }
            Shape::Gear => gear(rng),
        };
        if signed_area(&out.points) < 0.0 {
            out.points.reverse();
            out.corner.reverse();
        }
        out
    }

    /// Cuts a thin notch into a random edge, or puts a thin spike on it; `depth`: share of 2.
    pub fn with_needle(mut self, rng: &mut Rng) -> Self {
        let n = self.points.len();
        let i = rng.int(0, n - 1);
        let (a, b) = (self.points[i], self.points[(i + 1) % n]);
        let (d, length) = ((b - a).normalize_or_zero(), a.distance(b));
        let outward = if rng.chance(0.4) { 1.0 } else { -1.0 };
        let depth = rng.log(0.05, 0.8);
        let half = (depth * rng.log(0.002, 0.06)).min(0.3 * length);
        let foot = a.lerp(b, rng.real(0.3, 0.7));
        let tip = foot - d.perp() * depth * outward;
        let mut new = vec![foot - d * half, tip, foot + d * half];
        if rng.chance(0.4) {
            // A blunt end of the same width.
            new.splice(1..2, [tip - d * half, tip + d * half]);
        }
        self.corner.splice(i + 1..i + 1, vec![true; new.len()]);
        self.points.splice(i + 1..i + 1, new);
        self
    }
}

fn star(rng: &mut Rng, nasty: bool) -> Outline {
    let n = rng.int(4, 24);
    let low = if nasty { 0.08 } else { 0.5 };
    Outline::polygon(
        (0..n).map(|i| polar(rng.real(low, 1.0), TAU * (i as f64 + rng.real(0.0, 0.7)) / n as f64)).collect(),
    )
}

/// Random points; as long as two edges cross, the tour between them is reversed. Ends: each step shortens the tour.
fn two_opt(rng: &mut Rng) -> Outline {
    let n = rng.int(5, 22);
    let mut p: Vec<Point2> = (0..n).map(|_| Point2::new(rng.real(-1.0, 1.0), rng.real(-1.0, 1.0))).collect();
    let mut again = true;
    while again {
        again = false;
        for i in 0..n - 1 {
            for j in i + 2..n {
                let (a, b, c, d) = (p[i], p[i + 1], p[j], p[(j + 1) % n]);
                if (j + 1) % n != i && predicates::meeting(a, b, c, d) == predicates::Meeting::Cross {
                    p[i + 1..=j].reverse();
                    again = true;
                }
            }
        }
    }
    Outline::polygon(p)
}

fn blob(rng: &mut Rng) -> Outline {
    let waves: Vec<_> = (1..=rng.int(1, 6))
        .map(|k| (k as f64, rng.real(0.0, 0.6) / (k as f64).powf(0.8), rng.angle()))
        .collect();
    let r = |a: f64| waves.iter().map(|&(k, c, s)| c * (k * a + s).sin()).sum::<f64>().exp();
    Outline::smooth((0..400).map(|i| TAU * f64::from(i) / 400.0).map(|a| polar(r(a), a)).collect())
}

fn spiral(rng: &mut Rng, nasty: bool) -> Outline {
    let turns = rng.real(1.0, if nasty { 4.0 } else { 2.5 });
    let width = rng.real(0.3, if nasty { 0.97 } else { 0.8 }) / turns;
    let steps = (turns * 48.0) as usize;
    let side = |w: f64| {
        (0..=steps).map(move |i| {
            let a = TAU * turns * i as f64 / steps as f64;
            polar(0.15 + a / (TAU * turns) + w, a)
        })
    };
    let mut points: Vec<_> = side(0.0).collect();
    points.extend(side(width).rev());
    let mut out = Outline::smooth(points);
    for i in [0, steps, steps + 1, 2 * steps + 1] {
        out.corner[i] = true;
    }
    out
}

fn comb(rng: &mut Rng, nasty: bool) -> Outline {
    let n = rng.int(2, 9);
    let fill = if nasty { rng.real(0.1, 0.98) } else { rng.real(0.4, 0.7) };
    let mut p = vec![Point2::new(2.0, -rng.real(0.05, 0.4)), Point2::new(2.0, 0.0)];
    for i in (0..n).rev() {
        let (x0, x1) = (2.0 * i as f64 / n as f64, 2.0 * (i as f64 + fill) / n as f64);
        let y = rng.real(0.2, 1.2);
        p.extend([(x1, 0.0), (x1, y), (x0, y), (x0, 0.0)].map(Point2::from));
    }
    p.pop();
    let y = p[0].y;
    p.push(Point2::new(0.0, y));
    Outline::polygon(p)
}

/// A staircase outline with slots.
fn rectilinear(rng: &mut Rng) -> Outline {
    let n = rng.int(1, 6);
    let mut x: Vec<f64> = (0..=n).map(|i| (i as f64 + rng.real(0.0, 0.6)) * 2.0 / n as f64).collect();
    x[0] = 0.0;
    let mut p = Vec::new();
    for i in 0..n {
        let y = -rng.real(0.2, 1.0);
        p.extend([(x[i], y), (x[i + 1], y)].map(Point2::from));
    }
    for i in (0..n).rev() {
        let y = rng.real(0.2, 1.0);
        p.push(Point2::new(x[i + 1], y));
        if rng.chance(0.5) {
            let m = 0.5 * (x[i] + x[i + 1]);
            let (w, d) = (rng.log(0.004, 0.3) * (x[i + 1] - x[i]), rng.real(0.2, 0.9) * y);
            p.extend([(m + w, y), (m + w, y - d), (m - w, y - d), (m - w, y)].map(Point2::from));
        }
        p.push(Point2::new(x[i], y));
    }
    Outline::polygon(p)
}

fn coast(rng: &mut Rng) -> Outline {
    let n = rng.int(3, 6);
    let mut p: Vec<Point2> = (0..n).map(|i| polar(1.0, TAU * i as f64 / n as f64)).collect();
    let rough = rng.real(0.1, 0.3);
    for _ in 0..rng.int(2, 5) {
        let m = p.len();
        p = (0..m)
            .flat_map(|i| {
                let (a, b) = (p[i], p[(i + 1) % m]);
                [a, a.midpoint(b) + (b - a).perp() * rng.real(-rough, rough)]
            })
            .collect();
    }
    Outline::polygon(p)
}

fn gear(rng: &mut Rng) -> Outline {
    let n = rng.int(5, 24);
    let depth = rng.real(0.05, 0.5);
    let mut out = Outline::default();
    for i in 0..n {
        for (at, r) in [(0.0, 1.0 - depth), (0.3, 1.0 - depth), (0.5, 1.0), (0.8, 1.0)] {
            out.points.push(polar(r, TAU * (i as f64 + at) / n as f64));
            out.corner.push(true);
        }
    }
    out
}
