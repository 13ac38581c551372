//! Boundary singlet: a boundary node with one quad and an angle near 180 degrees gets a second quad.
//!
//! ```text
//!   rotate:                               insert a piece of a row:
//!      e────b                                 f────b────e          f───────b───────e
//!      │   ╱│╲          e────b                │   ╱ ╲   │          │ ╲     │     ╱ │
//!      │  R │ ╲   ──▶   │ ╲   ╲               │ S╱ Q ╲R │   ──▶    │  mc───m───ma  │
//!      │    │Q ╲        │   ╲  ╲              │ ╱     ╲ │          │  │    │    │  │
//!      d────a─v─c       d──a──v─c             g─c──v──a─d          g──c────v────a──d
//! ```
//!
//! 1. The node v has the quad Q = (v,a,b,c) and an angle of at least 150 degrees.
//! 2. If a neighbour on the boundary can spare a quad, the edge between Q and the quad beyond (a-b or b-c) is
//!    rotated to end in v.
//! 3. Otherwise Q, R and S make room for three new nodes; all of c, v, a then have two quads. If b has but
//!    the edges to a, c and e, then e = f and b is dropped.
//!
//! An edge that must stay (a scar) is neither rotated nor replaced.
//!
//! Near 180 degrees Q cannot be valid: the change is mandatory from [`FLAT_ANGLE`] on. Source: handbook 6.3.

use super::{CleanOp, Edit, Site};
use csalf_geom::{VertexId, angle::interior_angle};
use csalf_mesh::QuadTopology;

/// A single quad is not accepted at a node with this angle or more (150 degrees in radians; the judge's and
/// the handbook's bound). Larger: corners with a scaled Jacobian below 0.5 remain.
const WIDEST: f64 = 150.0 / 180.0 * std::f64::consts::PI;

/// From here on the quad counts as impossible (178 degrees in radians): its scaled Jacobian is at most 0.035.
/// Larger: slivers stay where the change does not succeed at once. Arbitrary.
const FLAT_ANGLE: f64 = 178.0 / 180.0 * std::f64::consts::PI;

/// See the file's head.
#[derive(Clone, Copy, Debug)]
pub struct Singlet;

impl CleanOp for Singlet {
    fn name(&self) -> &'static str {
        "singlet"
    }

    fn find(&self, site: &Site<'_>) -> Vec<Edit> {
        let n = site.mesh.n_vertices();
        (0..n)
            .filter(|&v| site.topology.on_boundary[v] && site.topology.n_quads_at(VertexId::new(v)) == 1)
            .filter_map(|v| open(site, v))
            .collect()
    }
}

/// Interior angle of the boundary at `v`, from the boundary half-edges there; `None` if the boundary passes
/// twice.
fn boundary_angle(site: &Site<'_>, v: u32) -> Option<f64> {
    let Site { mesh, topology, .. } = *site;
    let [before, after] = topology.boundary_neighbours(VertexId(v), &mesh.quads)?;
    let p = |v: VertexId| mesh.points[v.index()];
    Some(interior_angle(p(before), p(VertexId(v)), p(after)))
}

/// True if `v` can do with one quad less.
fn can_spare(site: &Site<'_>, v: u32) -> bool {
    let d = site.topology.n_quads_at(VertexId(v));
    if !site.topology.on_boundary[v as usize] {
        return d >= 4;
    }
    boundary_angle(site, v).is_some_and(|t| {
        // One quad up to 150 degrees, then one more for every started right angle.
        let least =
            if t < WIDEST { 1 } else { ((t - WIDEST) / std::f64::consts::FRAC_PI_2).floor() as usize + 2 };
        d > least
    })
}

/// The change at boundary node `v`, which has one quad.
fn open(site: &Site<'_>, v: usize) -> Option<Edit> {
    let Site { mesh, topology, fixed, .. } = *site;
    let h = topology.star(VertexId::new(v))[0];
    let q = h / 4;
    let side = |k: u32| 4 * q + ((h + k) & 3);
    let corner = |h: u32| mesh.quads[(h / 4) as usize][(h & 3) as usize].0;
    let (v, a, b, c) = (corner(side(0)), corner(side(1)), corner(side(2)), corner(side(3)));
    let p = |v: u32| mesh.points[v as usize];
    let angle = interior_angle(p(c), p(v), p(a));
    if angle < WIDEST {
        return None;
    }
    let mandatory = angle >= FLAT_ANGLE;
    // The quads beyond a-b and b-c, as the half-edges b → a and c → b.
    let twin = |k: u32| Some(topology.twin[side(k) as usize]).filter(|&t| t != QuadTopology::NONE);
    // A scar along one of these edges stays.
    let (r, s) = (twin(1).filter(|_| !site.keeps(a, b)), twin(2).filter(|_| !site.keeps(b, c)));
    let around = |t: u32, k: u32| corner((t & !3) | ((t + k) & 3));
    if can_spare(site, b) {
        if let Some(t) = r.filter(|_| can_spare(site, a)) {
            let (d, e) = (around(t, 2), around(t, 3));
            let add = vec![[v, a, d, e], [v, e, b, c]];
            return distinct(&[v, a, d, e, b, c]).then(|| Edit {
                remove: vec![q, t / 4],
                add,
                mandatory,
                ..Edit::default()
            });
        }
        if let Some(t) = s.filter(|_| can_spare(site, c)) {
            let (f, g) = (around(t, 2), around(t, 3));
            let add = vec![[v, a, b, f], [v, f, g, c]];
            return distinct(&[v, a, b, f, g, c]).then(|| Edit {
                remove: vec![q, t / 4],
                add,
                mandatory,
                ..Edit::default()
            });
        }
    }
    let (r, s) = (r?, s?);
    let (d, e) = (around(r, 2), around(r, 3));
    let (f, g) = (around(s, 2), around(s, 3));
    let remove = vec![q, r / 4, s / 4];
    let n = mesh.n_vertices() as u32;
    let (m, ma, mc) = (n, n + 1, n + 2);
    let mut points = vec![p(v).lerp(p(b), 0.5), p(a).lerp(p(e), 0.5), p(c).lerp(p(f), 0.5)];
    let row = [[c, v, m, mc], [v, a, ma, m], [a, d, e, ma], [g, c, mc, f]];
    let inner = !topology.on_boundary[b as usize];
    if e == f {
        let b_fixed = fixed.get(b as usize).copied().unwrap_or(false);
        let closes =
            inner && !b_fixed && topology.n_quads_at(VertexId(b)) == 3 && distinct(&[v, a, d, e, g, c]);
        points[0] = p(v).lerp(p(b), 0.7);
        let add = row.into_iter().chain([[m, ma, e, mc]]).collect();
        return closes.then_some(Edit { remove, add, points, mandatory });
    }
    let add = row.into_iter().chain([[m, ma, e, b], [m, b, f, mc]]).collect();
    let sound = can_spare(site, b) && distinct(&[v, a, d, e, b, f, g, c]);
    sound.then_some(Edit { remove, add, points, mandatory })
}

fn distinct(v: &[u32]) -> bool {
    (0..v.len()).all(|i| !v[..i].contains(&v[i]))
}
