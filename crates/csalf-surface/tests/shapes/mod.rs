//! Faces made by code: structured triangulations of parametric surfaces.

#![allow(dead_code, unreachable_pub, reason = "each test uses a part")]

use csalf_surface::{DVec3, FaceLoop, Facets};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A face: facets and loops.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    pub facets: Facets,
    pub loops: Vec<FaceLoop>,
}

/// A grid of m x n cells over (s, t) in the unit square, mapped; `wrap`: the first and last columns (rows)
/// are one. The normal is d/ds x d/dt.
pub fn grid(m: u32, n: u32, wrap: (bool, bool), f: impl Fn(f64, f64) -> DVec3) -> Facets {
    let (cm, cn) = (m + u32::from(!wrap.0), n + u32::from(!wrap.1));
    let at = |i: u32, j: u32| (j % cn) * cm + i % cm;
    let mut out = Facets::default();
    for j in 0..cn {
        for i in 0..cm {
            out.points.push(f(f64::from(i) / f64::from(m), f64::from(j) / f64::from(n)));
        }
    }
    for j in 0..n {
        for i in 0..m {
            out.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            out.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    out
}

/// The boundary loops of facets, with every k-th vertex a node.
pub fn boundary(facets: &Facets, every: usize) -> Vec<FaceLoop> {
    let mut next = BTreeMap::new();
    let mut sides = BTreeMap::new();
    for t in &facets.triangles {
        for k in 0..3 {
            sides.insert((t[k], t[(k + 1) % 3]), ());
        }
    }
    for &(a, b) in sides.keys() {
        if !sides.contains_key(&(b, a)) {
            next.insert(a, b);
        }
    }
    let mut out = Vec::new();
    while let Some((&start, _)) = next.first_key_value() {
        let mut list = vec![start];
        let mut at = next.remove(&start);
        while let Some(v) = at {
            if v == start {
                break;
            }
            list.push(v);
            at = next.remove(&v);
        }
        let nodes = list.into_iter().step_by(every).collect();
        out.push(FaceLoop { nodes, layers: None });
    }
    out
}

fn with_loops(facets: Facets, every: usize) -> Shape {
    let loops = boundary(&facets, every);
    Shape { facets, loops }
}

/// A dome (spherical cap of radius 1 up to polar angle `open`) with a hole round the pole of polar angle
/// `hole`, seen from outside; facets graded from the hole to the rim; nodes: `n_hole` and `n_rim`.
pub fn dome(hole: f64, open: f64, n_hole: u32, n_rim: u32) -> Shape {
    let m = (1..).map(|k| k * n_rim).find(|m| m % n_hole == 0).unwrap_or(n_rim);
    let rows = 48;
    let f = |s: f64, t: f64| {
        let polar = hole * (open / hole).powf(t);
        let a = TAU * s;
        DVec3::new(polar.sin() * a.cos(), polar.sin() * a.sin(), polar.cos())
    };
    // (azimuth, polar) is left-handed seen from outside: run the azimuth backwards.
    let facets = grid(m, rows, (true, false), |s, t| f(-s, t));
    let loop_at =
        |row: u32, n: u32| FaceLoop { nodes: (0..n).map(|k| row * m + k * (m / n)).collect(), layers: None };
    Shape { loops: vec![loop_at(0, n_hole), loop_at(rows, n_rim)], facets }
}

/// A hemisphere without hole, from a disc.
pub fn cap(open: f64, n: u32, every: usize) -> Shape {
    let facets = disc(n, |x, y| {
        let r = x.hypot(y);
        let polar = open * r;
        let (c, s) = if r > 0.0 { (x / r, y / r) } else { (1.0, 0.0) };
        DVec3::new(polar.sin() * c, polar.sin() * s, polar.cos())
    });
    with_loops(facets, every)
}

/// Triangulated unit disc of n rings, mapped. Ring k has 6 k vertices.
pub fn disc(n: u32, f: impl Fn(f64, f64) -> DVec3) -> Facets {
    let mut out = Facets { points: vec![f(0.0, 0.0)], ..Facets::default() };
    let first = |k: u32| if k == 0 { 0 } else { 1 + 3 * k * (k - 1) };
    for k in 1..=n {
        for i in 0..6 * k {
            let a = TAU * f64::from(i) / f64::from(6 * k);
            let r = f64::from(k) / f64::from(n);
            out.points.push(f(r * a.cos(), r * a.sin()));
        }
    }
    for k in 1..=n {
        let inner = |i: u32| if k == 1 { 0 } else { first(k - 1) + i % (6 * (k - 1)) };
        let outer = |i: u32| first(k) + i % (6 * k);
        for side in 0..6 {
            for i in 0..k {
                out.triangles.push([inner(side * (k - 1) + i), outer(side * k + i), outer(side * k + i + 1)]);
                if i + 1 < k {
                    out.triangles.push([
                        inner(side * (k - 1) + i),
                        outer(side * k + i + 1),
                        inner(side * (k - 1) + i + 1),
                    ]);
                }
            }
        }
    }
    out
}

/// An open cylinder of radius 1, all round.
pub fn tube(height: f64, m: u32, n: u32, every: usize) -> Shape {
    let f = |s: f64, t: f64| DVec3::new((TAU * s).cos(), (TAU * s).sin(), height * t);
    with_loops(grid(m, n, (true, false), f), every)
}

/// Part of a cylinder of radius 1.
pub fn gutter(angle: f64, height: f64, m: u32, n: u32) -> Shape {
    let f = |s: f64, t: f64| DVec3::new((angle * s).cos(), (angle * s).sin(), height * t);
    with_loops(grid(m, n, (false, false), f), 1)
}

/// Part of a cone, apex cut off.
pub fn cone(angle: f64, m: u32, n: u32) -> Shape {
    let f = |s: f64, t: f64| {
        let r = 1.0 - 0.7 * t;
        DVec3::new(r * (angle * s).cos(), r * (angle * s).sin(), 1.5 * t)
    };
    with_loops(grid(m, n, (false, false), f), 1)
}

/// z = a (x² - y²) over the square of side 2.
pub fn saddle(a: f64, n: u32) -> Shape {
    let f = |s: f64, t: f64| {
        let (x, y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        DVec3::new(x, y, a * (x * x - y * y))
    };
    with_loops(grid(n, n, (false, false), f), 1)
}

/// A torus.
pub fn torus(big: f64, small: f64, m: u32, n: u32) -> Shape {
    let f = |s: f64, t: f64| {
        let (a, b) = (TAU * s, TAU * t);
        let r = big + small * b.cos();
        DVec3::new(r * a.cos(), r * a.sin(), small * b.sin())
    };
    with_loops(grid(m, n, (true, true), f), 1)
}

/// A closed surface of the topology of a sphere: a cube, each side n x n, blown up and shaped by `f` of the
/// direction.
pub fn ball(n: u32, f: impl Fn(DVec3) -> DVec3) -> Shape {
    let mut ids: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let mut out = Facets::default();
    let m = i64::from(n);
    for (axis, sign) in [(0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1)] {
        let mut id = |i: i64, j: i64| {
            let mut c = [0i64; 3];
            c[axis] = sign * m;
            c[(axis + 1) % 3] = sign * (2 * i - m);
            c[(axis + 2) % 3] = 2 * j - m;
            let next = ids.len() as u32;
            *ids.entry(c).or_insert_with(|| {
                let t = c.map(|x| (0.25 * PI * x as f64 / m as f64).tan());
                out.points.push(f(DVec3::from(t).normalize()));
                next
            })
        };
        let mut list = Vec::new();
        for j in 0..m {
            for i in 0..m {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                list.push([a, b, c]);
                list.push([a, c, d]);
            }
        }
        out.triangles.extend(list);
    }
    Shape { facets: out, loops: Vec::new() }
}

/// A body with four legs and a head, in one piece.
pub fn beast(n: u32) -> Shape {
    let bumps = [
        (DVec3::new(0.7, 0.5, -0.7), 0.9, 0.33),
        (DVec3::new(0.7, -0.5, -0.7), 0.9, 0.33),
        (DVec3::new(-0.7, 0.5, -0.7), 0.9, 0.33),
        (DVec3::new(-0.7, -0.5, -0.7), 0.9, 0.33),
        (DVec3::new(0.9, 0.0, 0.6), 0.8, 0.4),
    ];
    ball(n, |d| {
        let mut r = 1.0;
        for (at, height, width) in bumps {
            let x = d.distance(at.normalize()) / width;
            r += height * (-x * x).exp();
        }
        r * d * DVec3::new(1.4, 0.9, 0.8)
    })
}
