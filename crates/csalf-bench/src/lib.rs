//! Inputs of the benchmarks: made by formula, the same on every machine. Run with `cargo bench -p csalf-bench`.

use csalf_core::Job;
use csalf_geom::{Domain, Point2, VertexId};
use csalf_mesh::QuadMesh;
use csalf_pave::{LayerLaw, LayerSpec};
use csalf_sizemap::{Background, SizeSpec, Source};
use serde_json::Value;

/// Xorshift, uniform in [0, 1).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// The next number.
    pub fn number(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A wavy closed curve of `n` nodes about the origin, radius 0.9 to 1.1, counter-clockwise.
pub fn wavy_loop(n: usize) -> Vec<Point2> {
    let at = |i: usize| {
        let a = std::f64::consts::TAU * i as f64 / n as f64;
        Point2::from_angle(a) * (1.0 + 0.1 * (7.0 * a).sin())
    };
    (0..n).map(at).collect()
}

/// A grid of `n` x `n` unit quads whose inner vertices are moved by up to `by`.
pub fn shaken_grid(n: usize, by: f64) -> QuadMesh {
    let mut rnd = Random(5);
    let mut mesh = QuadMesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let inner = i > 0 && j > 0 && i < n && j < n;
            let shift =
                Point2::new(rnd.number() - 0.5, rnd.number() - 0.5) * if inner { 2.0 * by } else { 0.0 };
            mesh.points.push(Point2::new(i as f64, j as f64) + shift);
        }
    }
    let at = |i: usize, j: usize| VertexId::new(j * (n + 1) + i);
    for j in 0..n {
        for i in 0..n {
            mesh.quads.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh
}

/// A square plate with `k` x `k` round holes of 16 nodes, radius 2, ten apart, all edges about 1: the outer loop, then
/// the holes. 70 quads for each hole.
pub fn perforated(k: usize) -> Vec<Vec<Point2>> {
    const PITCH: f64 = 10.0;
    let n = PITCH as usize * k;
    let l = PITCH * k as f64;
    let corner = [(0., 0.), (l, 0.), (l, l), (0., l)].map(Point2::from);
    let outer = (0..4 * n).map(|i| corner[i / n].lerp(corner[(i / n + 1) % 4], (i % n) as f64 / n as f64));
    let mut loops = vec![outer.collect()];
    for i in 0..k * k {
        let c = Point2::new((i % k) as f64 + 0.5, (i / k) as f64 + 0.5) * PITCH;
        let node = |a: usize| c + Point2::from_angle(-std::f64::consts::TAU * a as f64 / 16.0) * 2.0;
        loops.push((0..16).map(node).collect());
    }
    loops
}

/// A square from -1 to 1 with `k` x `k` jittered nodes: about 2 k² triangles.
///
/// # Panics
/// Never for k >= 2.
#[allow(clippy::expect_used, reason = "an input that cannot fail")]
pub fn jittered_background(k: usize) -> Background {
    let mut rnd = Random(1);
    let mut points = Vec::with_capacity(k * k);
    for i in 0..k {
        for j in 0..k {
            let rim = i == 0 || j == 0 || i == k - 1 || j == k - 1;
            let jitter = if rim { 0.0 } else { 0.6 };
            let d = Point2::new(rnd.number() - 0.5, rnd.number() - 0.5) * jitter;
            points.push((Point2::new(i as f64, j as f64) + d) / (k - 1) as f64 * 2.0 - Point2::ONE);
        }
    }
    let values: Vec<f64> = points.iter().map(|p| 0.01 + 0.001 * p.length()).collect();
    let m = k - 1;
    let side = |f: &dyn Fn(usize) -> usize| (0..m).map(|i| f(i) as u32).collect::<Vec<_>>();
    let rim = [side(&|i| i * k), side(&|j| m * k + j), side(&|i| (m - i) * k + m), side(&|j| m - j)].concat();
    Background::from_points(&points, &values, &[rim]).expect("a square")
}

/// A job from the JSON job format, as far as benchmarks need it: loops, scars, points, sizes of all kinds but
/// backgrounds, layers by count and the simple laws. `None` if it is not one.
pub fn job_of_json(text: &str) -> Option<Job> {
    let v: Value = serde_json::from_str(text).ok()?;
    let point = |p: &Value| Some(Point2::new(p.get(0)?.as_f64()?, p.get(1)?.as_f64()?));
    let list = |v: &Value| v["nodes"].as_array()?.iter().map(point).collect::<Option<Vec<_>>>();
    let entries = |key: &str| v[key].as_array().into_iter().flatten();
    let outer = entries("loops").find(|l| l["kind"] == "outer")?;
    let mut domain = Domain::new(list(outer)?);
    for l in entries("loops").filter(|l| l["kind"] == "hole") {
        domain = domain.with_hole(list(l)?);
    }
    for s in entries("scars") {
        domain = domain.with_scar(list(s)?);
    }
    for p in entries("points") {
        domain = domain.with_point(point(&p["xy"])?);
    }
    let size = match v["size"]["kind"].as_str()? {
        "boundary" => SizeSpec::Boundary,
        "uniform" => SizeSpec::Uniform { h: v["size"]["h"].as_f64()? },
        "sources" => {
            let source = |s: &Value| {
                let get = |key: &str| s[key].as_f64();
                Some(Source {
                    xy: point(&s["xy"])?,
                    h: get("h")?,
                    radius: get("radius")?,
                    falloff: get("falloff")?,
                })
            };
            let sources = v["size"]["sources"].as_array()?.iter().map(source).collect::<Option<_>>()?;
            SizeSpec::Sources { far: v["size"]["far"].as_f64()?, sources }
        }
        _ => return None,
    };
    let law = |l: &Value| match l.as_str() {
        Some("ramp") => LayerLaw::Ramp,
        Some("fibonacci") => LayerLaw::Fibonacci,
        Some("constant") => LayerLaw::Constant,
        _ => LayerLaw::Auto,
    };
    let layers = v["layers"].as_object().into_iter().flatten();
    let layers = layers
        .map(|(name, l)| {
            let count = l["count"].as_u64()? as usize;
            Some((name.clone(), LayerSpec { count, law: law(&l["law"]), first: None }))
        })
        .collect::<Option<Vec<_>>>()?;
    let name = v["name"].as_str().unwrap_or_default().to_owned();
    Some(Job { name, domain, size, layers, ..Job::default() })
}
