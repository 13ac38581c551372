//! Holes, scars and hard points in a domain that has its outer loop.

use super::Draft;
use super::outline::{Outline, SHAPES, Shape};
use super::sample::{Spacing, line, sample};
use crate::Rng;
use csalf_geom::polygon::{Side, bounds, locate};
use csalf_geom::{Domain, HardPoint, Point2};

/// A random point inside the material, and its distance to the nearest loop or scar; `None` if none was found.
fn inside(domain: &Domain, rng: &mut Rng) -> Option<(Point2, f64)> {
    let outer = &domain.loops[0].nodes;
    let (lo, hi) = bounds(outer.iter().copied())?;
    for _ in 0..30 {
        let p = Point2::new(rng.real(lo.x, hi.x), rng.real(lo.y, hi.y));
        let free = locate(outer, p) == Side::Inside
            && domain.loops[1..].iter().all(|l| locate(&l.nodes, p) == Side::Outside);
        if free {
            return Some((p, nearest(domain, p).0));
        }
    }
    None
}

/// Distance from `p` to the nearest loop or scar segment, and the nearest point.
fn nearest(domain: &Domain, p: Point2) -> (f64, Point2) {
    let loops = domain
        .loops
        .iter()
        .flat_map(|l| (0..l.nodes.len()).map(|i| (l.nodes[i], l.nodes[(i + 1) % l.nodes.len()])));
    let scars = domain.scars.iter().flat_map(|s| s.nodes.windows(2).map(|w| (w[0], w[1])));
    let mut best = (f64::INFINITY, p);
    for (a, b) in loops.chain(scars) {
        let f = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        let q = a.lerp(b, f);
        if p.distance(q) < best.0 {
            best = (p.distance(q), q);
        }
    }
    best
}

/// Adds 1 to 40 holes, as far as they fit; `room`: how many nodes may be added.
pub fn holes(draft: &mut Draft, rng: &mut Rng, room: usize) {
    let n = if rng.chance(0.6) { rng.int(1, 4) } else { rng.int(1, 40) };
    let mut room = room;
    for _ in 0..n {
        let Some((centre, clear)) = inside(&draft.domain, rng) else { continue };
        // The gap to the nearest curve, in parts of the base length.
        let tight = rng.chance(if draft.nasty { 0.4 } else { 0.05 });
        let share = if tight { 1.0 } else { rng.real(0.1, 0.85) };
        let gap = if tight { draft.h * rng.log(1e-3, 0.5) } else { 0.0 };
        let r = share * clear - gap.min(0.5 * clear);
        let towards = (nearest(&draft.domain, centre).1 - centre).normalize_or(Point2::X);
        let Some(outline) = hole_outline(r, centre, towards, rng, draft.nasty) else { continue };
        let ratio = if rng.chance(0.6) { 1.0 } else { rng.log(1.0, if draft.nasty { 300.0 } else { 10.0 }) };
        let spacing = Spacing::random(rng, ratio);
        let least = rng.int(3, 16) as f64;
        let perimeter = csalf_geom::polygon::perimeter(&outline.points);
        let h = (draft.h * rng.log(0.1, 1.5)).min(perimeter / least);
        let Some(nodes) = sample(&outline, h, &spacing, room.min(800), rng) else { continue };
        let count = nodes.len();
        if draft.keep_if_valid(|d| *d = std::mem::take(d).with_hole(nodes)) {
            room -= count;
        }
    }
}

/// An outline of radius `r` round `centre` that reaches out `towards` a direction.
fn hole_outline(r: f64, centre: Point2, towards: Point2, rng: &mut Rng, nasty: bool) -> Option<Outline> {
    let mut out = match rng.int(0, 5) {
        0 | 1 => Outline::random(Shape::Circle, rng, nasty),
        2 | 3 => Outline::random(Shape::Regular, rng, nasty),
        4 => slot(rng),
        _ => Outline::random(*rng.pick(&SHAPES), rng, nasty),
    };
    // Into the unit circle, its farthest point in the wanted direction.
    let (lo, hi) = bounds(out.points.iter().copied())?;
    let middle = lo.midpoint(hi);
    let far = out.points.iter().copied().max_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle)))?;
    let scale = (far - middle).length();
    let turn = ((far - middle) / scale).conjugate_turn(towards);
    for p in &mut out.points {
        *p = centre + turn.rotate(*p - middle) * (r / scale);
    }
    Some(out)
}

/// A long hole with round ends.
fn slot(rng: &mut Rng) -> Outline {
    let r = rng.log(0.01, 0.5);
    let mut out = Outline::default();
    for (x, from) in [(1.0, -90.0f64), (-1.0, 90.0)] {
        for i in 0..=16 {
            let a = (from + 180.0 * f64::from(i) / 16.0).to_radians();
            out.points.push(Point2::new(x + r * a.cos(), r * a.sin()));
            out.corner.push(i == 0 || i == 16);
        }
    }
    out
}

/// Rotations by complex numbers.
trait Turn {
    /// The unit vector that turns `self` into `to`, both of length 1.
    fn conjugate_turn(self, to: Self) -> Self;
}

impl Turn for Point2 {
    fn conjugate_turn(self, to: Self) -> Self {
        Self::new(self.x, -self.y).rotate(to)
    }
}

/// Adds 1 to 8 scars of all kinds, as far as they are valid.
pub fn scars(draft: &mut Draft, rng: &mut Rng) {
    for _ in 0..rng.int(1, 8) {
        match rng.int(0, 4) {
            0 => floating(draft, rng),
            1 => hanging(draft, rng),
            2 => connecting(draft, rng, false),
            3 => connecting(draft, rng, true),
            _ => crossing(draft, rng),
        }
    }
}

fn scar_h(draft: &Draft, rng: &mut Rng) -> f64 {
    draft.h * rng.log(if draft.nasty { 0.05 } else { 0.4 }, 1.5)
}

/// A walk of `n` steps of length `h`.
fn walk(from: Point2, mut direction: Point2, h: f64, n: usize, bend: f64, rng: &mut Rng) -> Vec<Point2> {
    let mut out = vec![from];
    for _ in 0..n {
        out.push(out[out.len() - 1] + direction * h);
        direction = Point2::from_angle(rng.real(-bend, bend)).rotate(direction);
    }
    out
}

fn floating(draft: &mut Draft, rng: &mut Rng) {
    let Some((p, clear)) = inside(&draft.domain, rng) else { return };
    let n = rng.int(1, 12);
    let h = scar_h(draft, rng).min(2.0 * clear / n as f64);
    let nodes = walk(p, Point2::from_angle(rng.angle()), h, n, 0.8, rng);
    draft.keep_if_valid(|d| *d = std::mem::take(d).with_scar(nodes));
}

/// A random node of a random loop, with the direction into the material.
fn loop_node(domain: &Domain, rng: &mut Rng) -> (usize, usize, Point2, Point2) {
    let k = rng.int(0, domain.loops.len() - 1);
    let nodes = &domain.loops[k].nodes;
    let n = nodes.len();
    let i = rng.int(0, n - 1);
    let along = nodes[(i + 1) % n] - nodes[(i + n - 1) % n];
    let left = csalf_geom::polygon::signed_area(nodes) > 0.0;
    let inward = if left == (k == 0) { along.perp() } else { -along.perp() };
    (k, i, nodes[i], inward.normalize_or(Point2::X))
}

fn hanging(draft: &mut Draft, rng: &mut Rng) {
    let (_, _, p, inward) = loop_node(&draft.domain, rng);
    let (h, n) = (scar_h(draft, rng), rng.int(1, 10));
    let nodes = walk(p, Point2::from_angle(rng.real(-0.7, 0.7)).rotate(inward), h, n, 0.5, rng);
    draft.keep_if_valid(|d| *d = std::mem::take(d).with_scar(nodes));
}

/// A scar from a node of a loop to a node of the same or another one, or to a scar.
fn connecting(draft: &mut Draft, rng: &mut Rng, same: bool) {
    let (k, i, a, _) = loop_node(&draft.domain, rng);
    let b = if same {
        let nodes = &draft.domain.loops[k].nodes;
        nodes[(i + rng.int(2, nodes.len().max(3) - 1)) % nodes.len()]
    } else if !draft.domain.scars.is_empty() && rng.chance(0.3) {
        let nodes = &draft.domain.scars[rng.int(0, draft.domain.scars.len() - 1)].nodes;
        nodes[rng.int(0, nodes.len() - 1)]
    } else {
        loop_node(&draft.domain, rng).2
    };
    if a == b {
        return;
    }
    let n = ((a.distance(b) / scar_h(draft, rng)).round() as usize).clamp(1, 200);
    // One of two neighbouring counts has the right parity if the scar cuts off a region.
    for n in [n, n + 1] {
        if draft.keep_if_valid(|d| *d = std::mem::take(d).with_scar(line(a, b, n))) {
            return;
        }
    }
}

/// A scar through a node of another one.
fn crossing(draft: &mut Draft, rng: &mut Rng) {
    let inner: Vec<Point2> =
        draft.domain.scars.iter().flat_map(|s| s.nodes[1..s.nodes.len() - 1].iter().copied()).collect();
    if inner.is_empty() {
        return floating(draft, rng);
    }
    let (p, h) = (*rng.pick(&inner), scar_h(draft, rng));
    let d = Point2::from_angle(rng.angle());
    let (n, m) = (rng.int(1, 5), rng.int(0, 5));
    let mut nodes = walk(p, -d, h, m, 0.4, rng);
    nodes.reverse();
    nodes.extend(walk(p, d, h, n, 0.4, rng).into_iter().skip(1));
    draft.keep_if_valid(|d| *d = std::mem::take(d).with_scar(nodes));
}

/// Adds 1 to 12 hard points: anywhere, near walls, near each other.
pub fn points(draft: &mut Draft, rng: &mut Rng) {
    for _ in 0..if rng.chance(0.7) { rng.int(1, 4) } else { rng.int(1, 12) } {
        let Some((mut p, _)) = inside(&draft.domain, rng) else { continue };
        let near = draft.h * rng.log(if draft.nasty { 0.01 } else { 0.5 }, 1.5);
        match rng.int(0, 3) {
            0 => {
                let (d, q) = nearest(&draft.domain, p);
                p = q + (p - q) / d * near.min(d);
            }
            1 => {
                if let Some(other) = draft.domain.points.last() {
                    p = other.xy + Point2::from_angle(rng.angle()) * near;
                }
            }
            _ => {}
        }
        let size = rng.chance(0.3).then(|| draft.h * rng.log(0.1, 1.0));
        let name = format!("point{}", draft.domain.points.len());
        draft.keep_if_valid(|d| d.points.push(HardPoint { name, xy: p, size }));
    }
}
