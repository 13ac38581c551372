//! Closed surfaces without any edge, in closed form: a sphere as a cube blown up, a torus as a grid.
//!
//! ```text
//!   sphere: six sides of n × n quads, points at equal angles       torus: n_u × n_v quads
//! ```

use super::NodeName;
use super::mesh::{Context, MeshedFace};
use crate::brep::Face;
use crate::geometry::Surface;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// Most quads along one direction.
const MOST: f64 = 2000.0;

pub(super) fn mesh_closed(
    cx: &Context<'_>,
    face: &Face,
    surface: &Surface,
    forward: bool,
) -> Result<MeshedFace, String> {
    let most = cx.rules.of_face(&face.name);
    let mut out = match surface {
        Surface::Sphere { radius, .. } => {
            let h = cx.rules.for_curvature(1.0 / radius, most);
            let n = (FRAC_PI_2 * radius / h).round().clamp(2.0, MOST) as i64;
            sphere(surface, n)
        }
        Surface::Torus { major, minor, .. } if major > minor => {
            let h = cx.rules.for_curvature(1.0 / minor, most);
            let count = |length: f64| (length / h).round().clamp(4.0, MOST) as u32;
            torus(surface, count(TAU * major), count(TAU * minor))
        }
        _ => return Err(format!("it is a closed {} without edges, which is not meshed yet", surface.kind())),
    };
    if !forward {
        out.quads.iter_mut().for_each(|q| q.reverse());
    }
    Ok(out)
}

/// A cube's surface, n by n quads per side, blown up to the sphere.
fn sphere(surface: &Surface, n: i64) -> MeshedFace {
    let Surface::Sphere { frame, radius } = surface else { return MeshedFace::default() };
    let mut out = MeshedFace::default();
    let mut known: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    // Lattice points of the cube's surface, coordinates -n..=n in steps of 2.
    let mut node = |c: [i64; 3]| {
        *known.entry(c).or_insert_with(|| {
            let d = DVec3::from_array(c.map(|k| (k as f64 / n as f64 * FRAC_PI_4).tan()));
            let d = d.normalize_or_zero() * *radius;
            out.own.push(frame.point(d.x, d.y, d.z));
            out.own.len() as u32 - 1
        })
    };
    let mut quads = Vec::new();
    for axis in 0..3 {
        for side in [-1, 1] {
            let at = |i: i64, j: i64| {
                let mut c = [0; 3];
                c[axis] = side * n;
                c[(axis + 1) % 3] = 2 * i - n;
                c[(axis + 2) % 3] = 2 * j - n;
                c
            };
            for i in 0..n {
                for j in 0..n {
                    let mut q = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    if side < 0 {
                        q.reverse();
                    }
                    quads.push(q.map(|c| NodeName::Own(node(c))));
                }
            }
        }
    }
    out.quads = quads;
    out
}

fn torus(surface: &Surface, nu: u32, nv: u32) -> MeshedFace {
    let mut out = MeshedFace::default();
    for i in 0..nu {
        for j in 0..nv {
            let share = |k: u32, n: u32| TAU * f64::from(k) / f64::from(n);
            out.own.push(surface.eval(DVec2::new(share(i, nu), share(j, nv))).point);
            let at = |a: u32, b: u32| NodeName::Own((a % nu) * nv + b % nv);
            out.quads.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    out
}
