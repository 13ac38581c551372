//! Structure at the boundary: how well the quads follow it, row by row and ring by ring.
//!
//! ```text
//!   ─o───o───o───o─   third row         A boundary segment is "served" by its row if its quad has four good
//!    │   │   │   │                      nodes: inner ones with four edges, boundary ones with the number of
//!   ─o───o───o───o─   second row        quads that their angle asks for.
//!    │   │   │   │
//!   ─o───o───o───o─   first row         A closed ring serves every node of the front so, and its inner
//!   ─────────────────── boundary        side is again one simple closed cycle of inner nodes.
//! ```
//!
//! Steps of the rings around one loop ([`rings`]): 1. the quads at the nodes of the front, without those of
//! the last ring; 2. each front node must have as many of them as its angle asks for; 3. their sides without
//! front nodes must form one cycle of new inner nodes; 4. this is the next front.
//!
//! Definitions: the judge of the public cases (its README, "Structure at the boundary"). Cost O(n) for the
//! rows, O(quads within [`RING_CAP`] rings) for the rings.

use super::edges::{HalfEdges, NONE};
use crate::QuadMesh;
use csalf_geom::{Point2, angle::interior_angle};
use serde::Serialize;

/// Most rings counted around a loop.
pub const RING_CAP: usize = 40;

/// Structure figures of a mesh. Shares are 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Structure {
    /// Of the boundary nodes with an interior angle of 150 to 210 degrees, those with exactly two quads;
    /// `None` if there is no such node.
    pub flat2_share: Option<f64>,
    /// Of the boundary nodes, those with the number of quads that their angle asks for.
    pub ideal_corner_share: f64,
    /// Of the boundary segments, those whose element is a quad with four good nodes.
    pub row1_share: f64,
    /// Of the boundary segments, those from which 1, 2, 3 further quads follow inward across edges with good
    /// ends.
    pub column_share: [f64; 3],
    /// Per boundary loop, ordered by smallest vertex (the order of the input): rings that close.
    pub closed_rings_per_loop: Vec<usize>,
    /// Likewise: rings, from the loop on, whose inner fronts have only nodes with four edges.
    pub rings_per_loop: Vec<usize>,
}

/// True if `n` quads at a boundary node of interior angle `degrees` are what the angle asks for.
pub fn serves(degrees: f64, n: usize) -> bool {
    match degrees {
        a if a < 105.0 => n == 1,
        a if a < 150.0 => n == 1 || n == 2,
        a if a < 210.0001 => n == 2,
        a if a < 255.0 => n == 2 || n == 3,
        a if a < 300.0 => n == 3,
        a if a < 345.0 => n == 3 || n == 4,
        a if a < 361.0 => (3..=5).contains(&n),
        _ => false,
    }
}

/// Interior angle at node `i` of the cycle `c`, in degrees.
fn angle_at(points: &[Point2], c: &[u32], i: usize) -> f64 {
    let at = |k: usize| points[c[k % c.len()] as usize];
    interior_angle(at(i + c.len() - 1), at(i), at(i + 1)).to_degrees()
}

/// The boundary loops, material on the left, ordered by smallest vertex, each from it; `None` if the boundary
/// passes through a node twice.
pub(crate) fn boundary_loops(edges: &HalfEdges, n: usize) -> Option<Vec<Vec<u32>>> {
    let mut next = vec![NONE; n];
    let mut n_in = vec![false; n];
    for h in edges.boundary() {
        let (a, b) = (edges.tail(h) as usize, edges.head(h) as usize);
        if next[a] != NONE || n_in[b] {
            return None;
        }
        next[a] = b as u32;
        n_in[b] = true;
    }
    let mut out = Vec::new();
    for s in 0..n as u32 {
        if next[s as usize] == NONE {
            continue;
        }
        let mut l = vec![s];
        let mut c = std::mem::replace(&mut next[s as usize], NONE);
        while c != s {
            l.push(c);
            c = std::mem::replace(&mut next[c as usize], NONE);
            if c == NONE {
                return None;
            }
        }
        out.push(l);
    }
    Some(out)
}

/// Measures the structure; `None` if the boundary passes through a node twice or there is none.
pub(crate) fn measure(mesh: &QuadMesh, edges: &HalfEdges) -> Option<Structure> {
    let n = mesh.n_vertices();
    let loops = boundary_loops(edges, n)?;
    if loops.is_empty() {
        return None;
    }
    let mut good: Vec<bool> = edges.valence.iter().map(|&v| v == 4).collect();
    let (mut n_nodes, mut n_good, mut n_flat, mut n_flat2) = (0usize, 0usize, 0usize, 0usize);
    for l in &loops {
        for (i, &v) in l.iter().enumerate() {
            let a = angle_at(&mesh.points, l, i);
            let (n_el, all_quads) = (edges.n_elements_at(v), edges.n_triangles_at[v as usize] == 0);
            let ok = all_quads && serves(a, n_el);
            good[v as usize] = ok;
            n_nodes += 1;
            n_good += usize::from(ok);
            if (150.0..=210.0).contains(&a) {
                n_flat += 1;
                n_flat2 += usize::from(all_quads && n_el == 2);
            }
        }
    }
    let ends = |h: u32| good[edges.tail(h) as usize] && good[edges.head(h) as usize];
    let (mut n_segments, mut row1, mut columns) = (0usize, 0usize, [0usize; 3]);
    for h in edges.boundary() {
        n_segments += 1;
        if !edges.is_quad(h) {
            continue;
        }
        row1 += usize::from(ends(h) && ends(HalfEdges::opposite(h)));
        let mut current = h;
        for count in &mut columns {
            let o = HalfEdges::opposite(current);
            let t = edges.twin[o as usize];
            if t >= NONE || !edges.is_quad(t) || !ends(o) {
                break;
            }
            *count += 1;
            current = t;
        }
    }
    let share = |k: usize, of: usize| k as f64 / of as f64;
    let mut stamp =
        Stamps { front: vec![0; n], seen: vec![0; n], quad: vec![0; mesh.n_quads()], count: vec![0; n] };
    let mut next = vec![NONE; n];
    let mut time = 0;
    let mut found = Vec::with_capacity(loops.len());
    for (id, l) in loops.iter().enumerate() {
        found.push(rings(mesh, edges, l, id as u32 + 1, &mut stamp, &mut next, &mut time));
    }
    Some(Structure {
        flat2_share: (n_flat > 0).then(|| share(n_flat2, n_flat)),
        ideal_corner_share: share(n_good, n_nodes),
        row1_share: share(row1, n_segments),
        column_share: columns.map(|c| share(c, n_segments)),
        closed_rings_per_loop: found.iter().map(|f| f.0).collect(),
        rings_per_loop: found.iter().map(|f| f.1).collect(),
    })
}

/// Marks that need no clearing: an entry is set if it equals the current id or time.
struct Stamps {
    /// Id of the loop whose fronts the vertex belongs to.
    front: Vec<u32>,
    seen: Vec<u32>,
    quad: Vec<u32>,
    count: Vec<u32>,
}

/// (closed rings, rings with only four-edge nodes on the new fronts) around one boundary loop.
fn rings(
    mesh: &QuadMesh,
    edges: &HalfEdges,
    start: &[u32],
    id: u32,
    stamp: &mut Stamps,
    next: &mut [u32],
    time: &mut u32,
) -> (usize, usize) {
    let (mut closed, mut regular, mut still) = (0, 0, true);
    let mut front = start.to_vec();
    for &v in &front {
        stamp.front[v as usize] = id;
    }
    let mut quads: Vec<u32> = Vec::new();
    let mut far: Vec<u32> = Vec::new();
    while closed < RING_CAP {
        // `now` marks what this ring touches, `now - 2` what the last one did.
        *time += 2;
        let now = *time;
        quads.clear();
        let mut quads_only = true;
        for &v in &front {
            stamp.count[v as usize] = 0;
        }
        for &v in &front {
            for &h in edges.out(v) {
                quads_only &= edges.is_quad(h);
                let q = (h / 4) as usize;
                if edges.is_quad(h) && stamp.quad[q] != now && !(closed > 0 && stamp.quad[q] == now - 2) {
                    stamp.quad[q] = now;
                    quads.push(q as u32);
                }
            }
        }
        // A quad of an older ring does not touch the front, so the last ring is all that must be left out.
        for &q in &quads {
            for v in mesh.quads[q as usize] {
                stamp.count[v.index()] += u32::from(stamp.front[v.index()] == id);
            }
        }
        let served =
            |i: usize| serves(angle_at(&mesh.points, &front, i), stamp.count[front[i] as usize] as usize);
        if quads.is_empty() || !quads_only || !(0..front.len()).all(served) {
            break;
        }
        far.clear();
        let (mut n_new, mut touches) = (0, false);
        for &q in &quads {
            for k in 0..4 {
                let h = 4 * q + k;
                let (a, b) = (edges.tail(h) as usize, edges.head(h) as usize);
                if stamp.front[a] == id {
                    continue;
                }
                if stamp.seen[a] != now {
                    stamp.seen[a] = now;
                    next[a] = NONE;
                    n_new += 1;
                    touches |= edges.on_boundary[a];
                }
                if stamp.front[b] != id {
                    far.push(h);
                }
            }
        }
        if far.is_empty() || n_new != far.len() || touches {
            break;
        }
        // Reversed, so that the side not yet ringed is on the left. Each new node must have one successor.
        let mut simple = true;
        for &h in &far {
            let (a, b) = (edges.tail(h), edges.head(h));
            simple &= next[b as usize] == NONE && next[a as usize] != b;
            next[b as usize] = a;
        }
        let first = edges.head(far[0]);
        front.clear();
        front.push(first);
        let mut c = next[first as usize];
        while simple && c != NONE && c != first && front.len() <= far.len() {
            front.push(c);
            c = next[c as usize];
        }
        if !simple || c != first || front.len() != far.len() {
            break;
        }
        for &v in &front {
            stamp.front[v as usize] = id;
            still &= edges.valence[v as usize] == 4;
        }
        closed += 1;
        regular += usize::from(still);
    }
    (closed, regular)
}
