//! Smoothing on the surface: each vertex in the tangent plane at it, the move carried over to the facets.
//!
//! ```text
//!      ╲ | ╱        corners round v are seen in the tangent plane; E = sum F^p, F = (|e1|² + |e2|²) / (2 e1 × e2)
//!     ── v ──       one Newton step; walked along the facets, put on the surface, kept if E falls and the worst
//!      ╱ | ╲        corner does not fall below the floor
//! ```
//!
//! Vertex by vertex in ascending order: the result depends on nothing else. Source: handbook 9.6 and 7.3.

use crate::quality::corners;
use crate::sheet::{Ground, Sheet};
use csalf_geom::VertexId;
use csalf_mesh::QuadTopology;
use glam::{DVec2, DVec3};

/// Quads with a scaled Jacobian below this are worked on, with two rings around.
const THRESHOLD: f64 = 0.9;
/// Most sweeps.
const SWEEPS: usize = 12;
/// A corner may lose scaled Jacobian down to this, where E falls.
const FLOOR: f64 = 0.7;
/// Power of the corner energy: the larger, the more the worst corners count.
const POWER: i32 = 4;
/// A move below this share of the shortest edge is none.
const SETTLED: f64 = 4e-3;

/// Smooths the free vertices near poor quads and near the vertices of `seeds`. Returns how many were free.
pub(crate) fn smooth(
    sheet: &mut Sheet,
    ground: &Ground<'_>,
    topology: &QuadTopology,
    seeds: &[u32],
) -> usize {
    let n = sheet.points.len();
    let mut active = vec![false; n];
    seeds.iter().for_each(|&v| active[v as usize] = true);
    for q in &sheet.quads {
        let (_, s) = corners(q.map(|v| sheet.points[v as usize]), q.map(|v| sheet.normals[v as usize]));
        if s.iter().any(|&s| s < THRESHOLD) {
            q.iter().for_each(|&v| active[v as usize] = true);
        }
    }
    for _ in 0..2 {
        let old = active.clone();
        for q in &sheet.quads {
            if q.iter().any(|&v| old[v as usize]) {
                q.iter().for_each(|&v| active[v as usize] = true);
            }
        }
    }
    let free: Vec<u32> = (0..n as u32).filter(|&v| active[v as usize] && !sheet.fixed[v as usize]).collect();
    let mut moving = vec![true; n];
    for _ in 0..SWEEPS {
        let mut n_moved = 0;
        for &v in &free {
            if moving[v as usize] {
                let moved = step(sheet, ground, topology.star(VertexId(v)), v);
                moving[v as usize] = moved;
                n_moved += usize::from(moved);
                if moved {
                    for &h in topology.star(VertexId(v)) {
                        sheet.quads[h as usize / 4].iter().for_each(|&w| moving[w as usize] = true);
                    }
                }
            }
        }
        if n_moved == 0 {
            break;
        }
    }
    free.len()
}

/// The quads round a vertex in its tangent plane: next, opposite, previous corner of each.
struct Star {
    origin: DVec3,
    axes: [DVec3; 2],
    quads: Vec<[DVec2; 3]>,
}

impl Star {
    fn flat(&self, p: DVec3) -> DVec2 {
        let d = p - self.origin;
        DVec2::new(d.dot(self.axes[0]), d.dot(self.axes[1]))
    }

    /// Energy (infinite if a corner is not positive) and worst scaled Jacobian with the vertex at `x`.
    fn value(&self, x: DVec2) -> (f64, f64) {
        let (mut e, mut worst) = (0.0, f64::INFINITY);
        for &[n, o, p] in &self.quads {
            for (a, b) in [(n - x, p - x), (o - n, x - n), (x - p, o - p)] {
                let d = a.perp_dot(b);
                let (la, lb) = (a.length_squared(), b.length_squared());
                let l = (la * lb).sqrt();
                worst = worst.min(if l > 0.0 { d / l } else { -1.0 });
                e += if d > 0.0 { (0.5 * (la + lb) / d).powi(POWER) } else { f64::INFINITY };
            }
        }
        (e, worst)
    }

    /// The Newton step from `x` = 0.
    fn newton(&self) -> Option<DVec2> {
        let mut g = DVec2::ZERO;
        let (mut hxx, mut hxy, mut hyy) = (0.0, 0.0, 0.0);
        for &[n, o, p] in &self.quads {
            let corners = [
                (n, p, DVec2::new(n.y - p.y, p.x - n.x), -2.0 * (n + p), 4.0),
                (o - n, -n, DVec2::new(n.y - o.y, o.x - n.x), -2.0 * n, 2.0),
                (-p, o - p, DVec2::new(o.y - p.y, p.x - o.x), -2.0 * p, 2.0),
            ];
            for (a, b, dd, dt, k) in corners {
                let d = a.perp_dot(b);
                let t = a.length_squared() + b.length_squared();
                let f = 0.5 * t / d;
                let df = 0.5 * dt / d - f / d * dd;
                let (x, y) = (-0.5 / (d * d), t / (d * d * d));
                let w = f64::from(POWER) * f.powi(POWER - 2);
                let m = f64::from(POWER - 1);
                let h = |i: usize, j: usize| {
                    let own = if i == j { 0.5 * k / d } else { 0.0 };
                    let hf = own + x * (dt[i] * dd[j] + dd[i] * dt[j]) + y * dd[i] * dd[j];
                    w * (f * hf + m * df[i] * df[j])
                };
                g += w * f * df;
                hxx += h(0, 0);
                hxy += h(0, 1);
                hyy += h(1, 1);
            }
        }
        let det = hxx * hyy - hxy * hxy;
        let d = DVec2::new(hxy * g.y - hyy * g.x, hxy * g.x - hxx * g.y) / det;
        (det > 0.0 && d.is_finite()).then_some(d)
    }
}

/// The area vectors of the quads round a vertex: steadier than the surface's normal where the mesh is coarse.
fn mean_normal(sheet: &Sheet, around: &[u32]) -> DVec3 {
    let area = |h: &u32| {
        let [a, b, c, d] = sheet.quads[*h as usize / 4].map(|v| sheet.points[v as usize]);
        (c - a).cross(d - b)
    };
    around.iter().map(area).sum()
}

/// Tries to better one vertex.
fn step(sheet: &mut Sheet, ground: &Ground<'_>, around: &[u32], v: u32) -> bool {
    let origin = sheet.points[v as usize];
    let n = mean_normal(sheet, around).normalize_or(sheet.normals[v as usize]);
    let (a, b) = n.any_orthonormal_pair();
    // (a, b, n) must be right-handed.
    let b = if a.cross(b).dot(n) < 0.0 { -b } else { b };
    let mut star = Star { origin, axes: [a, b], quads: Vec::with_capacity(around.len()) };
    for &h in around {
        let q = sheet.quads[h as usize / 4];
        let p = |i: u32| sheet.points[q[((h + i) & 3) as usize] as usize];
        star.quads.push([star.flat(p(1)), star.flat(p(2)), star.flat(p(3))]);
    }
    let (e, worst) = star.value(DVec2::ZERO);
    let shortest = star.quads.iter().map(|q| q[0].length().min(q[2].length())).fold(f64::INFINITY, f64::min);
    let newton = if e.is_finite() { star.newton() } else { None };
    let target = newton.unwrap_or_else(|| {
        // Tangled: towards the middle of the neighbours.
        star.quads.iter().map(|q| q[0] + q[2]).sum::<DVec2>() / (2 * star.quads.len().max(1)) as f64
    });
    let target = target.clamp_length_max(if e.is_finite() { 0.5 * shortest } else { f64::INFINITY });
    if target.length() <= SETTLED * shortest || !target.is_finite() {
        return false;
    }
    let mut t = 1.0;
    for _ in 0..4 {
        let d = t * target;
        let anchor = ground.nearest(sheet.anchors[v as usize], origin + d.x * a + d.y * b);
        let (p, normal, _) = ground.at(anchor);
        let (e_new, worst_new) = star.value(star.flat(p));
        let better = if e.is_finite() {
            e_new < e && worst_new >= worst.min(FLOOR)
        } else {
            worst_new > worst + 1e-3 || (e_new.is_finite() && worst_new > worst)
        };
        if better {
            sheet.points[v as usize] = p;
            sheet.normals[v as usize] = normal;
            sheet.anchors[v as usize] = anchor;
            return true;
        }
        t *= 0.5;
    }
    false
}
