//! Connects all loops, scars and hard points of a region into one contour by bridges.
//!
//! ```text
//!    +-----------------+        outer ... a ─ bridge ─ b (all of the hole) b ─ bridge reversed ─ a ...
//!    |      +---+      |
//!    a======b   |      |        a, b and the bridge nodes occur twice in the contour
//!    |      +---+      |
//!    +-----------------+
//! ```
//!
//! 1. Constrained Delaunay triangulation of all walks ([`spade`]): its edges are visible by construction, do not
//!    cross each other and connect all walks.
//! 2. Every triangulation edge between two walks is a candidate of cost l (1 + φ), φ the angle deviation of the
//!    paper's split lines at its two ends (eq. 9): a good bridge is a good split line, since it stays in the mesh.
//! 3. A minimum spanning tree over the walks (Kruskal) chooses the bridges.
//! 4. Bridge nodes by equidistribution; parity plays no part (a bridge adds an even number of segments).
//! 5. One traversal of the walks and both sides of every bridge writes the contour.
//!
//! Cost O(n log n). Source: paper 5.1 (after Cabello), handbook 4.2; the paper's background grid is replaced by
//! the triangulation, which cannot miss a connection.

use csalf_geom::{Point2, angle, cone::in_cone};
use csalf_mesh::{Contour, NodeFlags};
use csalf_sizemap::cdt::{Constrained, constrained};
use csalf_sizemap::{Hint, SizeField, line::LineSizes};
use spade::Triangulation;

/// The parts of one region: cyclic walks of node ids, material on the left. A walk of one node is a hard point.
#[derive(Clone, Copy, Debug)]
pub struct Walks<'a> {
    /// All walks, the outer one first.
    pub walks: &'a [Vec<u32>],
    /// Coordinates by node id.
    pub points: &'a [Point2],
    /// Flags by node id.
    pub flags: &'a [NodeFlags],
}

/// The contour of a region and the bridge nodes that had to be created for it.
#[derive(Clone, Debug, Default)]
pub struct Bridged {
    /// The contour. Ids are those of the walks, then `first_new_id + k` for bridge node k.
    pub contour: Contour,
    /// Coordinates of the bridge nodes.
    pub new_points: Vec<Point2>,
}

/// Why a region could not be connected.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum BridgeError {
    /// The triangulation of the region failed: coordinates out of range.
    #[error("the triangulation of the region failed: {0}")]
    Triangulation(String),
    /// A walk could not be reached: the walks are not those of one region.
    #[error("walk {walk} cannot be reached from the others")]
    Unreachable {
        /// Its index.
        walk: usize,
    },
}

/// One occurrence of a node in a walk.
#[derive(Clone, Copy)]
struct Place {
    walk: u32,
    at: u32,
}

struct Bridge {
    from: usize,
    to: usize,
    /// Bridge nodes from `from` to `to`: range in `new_points`.
    first: usize,
    count: usize,
}

/// Occurrences flattened: walk w holds occurrences `start[w]..start[w + 1]`.
struct Occurrences<'a> {
    input: Walks<'a>,
    start: Vec<usize>,
    place: Vec<Place>,
    /// Occurrences of each node id, as a CSR list.
    of_node_start: Vec<u32>,
    of_node: Vec<u32>,
}

impl<'a> Occurrences<'a> {
    fn new(input: Walks<'a>) -> Self {
        let mut start = vec![0];
        let mut place = Vec::new();
        for (w, walk) in input.walks.iter().enumerate() {
            for at in 0..walk.len() {
                place.push(Place { walk: w as u32, at: at as u32 });
            }
            start.push(place.len());
        }
        let mut of_node_start = vec![0u32; input.points.len() + 1];
        for &v in input.walks.iter().flatten() {
            of_node_start[v as usize + 1] += 1;
        }
        for i in 0..input.points.len() {
            of_node_start[i + 1] += of_node_start[i];
        }
        let mut fill = of_node_start.clone();
        let mut of_node = vec![0u32; place.len()];
        for (o, &v) in input.walks.iter().flatten().enumerate() {
            let f = &mut fill[v as usize];
            of_node[*f as usize] = o as u32;
            *f += 1;
        }
        Self { input, start, place, of_node_start, of_node }
    }

    fn node(&self, o: usize) -> u32 {
        let p = self.place[o];
        self.input.walks[p.walk as usize][p.at as usize]
    }
    fn point(&self, o: usize) -> Point2 {
        self.input.points[self.node(o) as usize]
    }
    fn walk(&self, o: usize) -> usize {
        self.place[o].walk as usize
    }
    fn len_of(&self, o: usize) -> usize {
        self.input.walks[self.walk(o)].len()
    }
    fn step(&self, o: usize, by: usize) -> usize {
        let w = self.walk(o);
        self.start[w] + (o - self.start[w] + by) % self.len_of(o)
    }
    fn next(&self, o: usize) -> usize {
        self.step(o, 1)
    }
    fn prev(&self, o: usize) -> usize {
        self.step(o, self.len_of(o) - 1)
    }
    /// The occurrence of `node` whose material cone holds the direction to `q`.
    fn facing(&self, node: u32, q: Point2) -> Option<usize> {
        let range =
            self.of_node_start[node as usize] as usize..self.of_node_start[node as usize + 1] as usize;
        self.of_node[range].iter().map(|&o| o as usize).find(|&o| {
            self.len_of(o) == 1
                || in_cone(self.point(self.prev(o)), self.point(o), self.point(self.next(o)), q)
        })
    }
    /// Angle from the outgoing segment of `o` counter-clockwise to the direction of `q`.
    fn exit_angle(&self, o: usize, q: Point2) -> f64 {
        let b = self.point(o);
        let u = if self.len_of(o) == 1 { Point2::X } else { self.point(self.next(o)) - b };
        angle::turn(u, q - b)
    }
    /// Deviation of a line leaving `o` towards `q` from a good split: 0 if it divides the angle into multiples of
    /// 90 degrees, in radians over two angles.
    fn deviation(&self, o: usize, q: Point2) -> f64 {
        if self.len_of(o) == 1 {
            return 0.0;
        }
        let (a, b, c) = (self.point(self.prev(o)), self.point(o), self.point(self.next(o)));
        let tip = self.node(self.prev(o)) == self.node(self.next(o));
        let theta = if tip { std::f64::consts::TAU } else { angle::interior_angle(a, b, c) };
        let one = self.exit_angle(o, q);
        crate::functional::angle_deviation(one) + crate::functional::angle_deviation(theta - one)
    }
}

/// Connects the walks of one region into one contour. New bridge nodes get ids from `first_new_id` on.
///
/// # Errors
/// [`BridgeError`] if the walks do not bound one region.
pub fn bridge(input: Walks<'_>, size: &dyn SizeField, first_new_id: u32) -> Result<Bridged, BridgeError> {
    let occ = Occurrences::new(input);
    let mut out = Bridged::default();
    let bridges = if input.walks.len() > 1 { choose(&occ, size, &mut out.new_points)? } else { Vec::new() };
    write_contour(&occ, &bridges, size, first_new_id, &mut out);
    Ok(out)
}

/// Steps 1 to 4.
fn choose(
    occ: &Occurrences<'_>,
    size: &dyn SizeField,
    new_points: &mut Vec<Point2>,
) -> Result<Vec<Bridge>, BridgeError> {
    let input = occ.input;
    let mut local_of = vec![u32::MAX; input.points.len()];
    let mut nodes = Vec::new();
    let mut vertices = Vec::new();
    for &v in input.walks.iter().flatten() {
        if local_of[v as usize] == u32::MAX {
            local_of[v as usize] = nodes.len() as u32;
            nodes.push(v);
            vertices.push(input.points[v as usize]);
        }
    }
    let mut edges = Vec::new();
    for walk in input.walks.iter().filter(|w| w.len() > 1) {
        for (i, &v) in walk.iter().enumerate() {
            let w = walk[(i + 1) % walk.len()];
            edges.push([local_of[v as usize], local_of[w as usize]]);
        }
    }
    let Constrained { cdt, conflict, .. } =
        constrained(vertices, edges).map_err(|e| BridgeError::Triangulation(e.to_string()))?;
    if conflict.is_some() || cdt.num_vertices() != nodes.len() {
        return Err(BridgeError::Triangulation("crossing or coincident walks".into()));
    }
    let mut candidates = Vec::new();
    for e in cdt.undirected_edges() {
        if e.is_constraint_edge() {
            continue;
        }
        let [a, b] = e.vertices().map(|v| nodes[v.data().index as usize]);
        let (pa, pb) = (input.points[a as usize], input.points[b as usize]);
        let (Some(i), Some(j)) = (occ.facing(a, pb), occ.facing(b, pa)) else { continue };
        if occ.walk(i) == occ.walk(j) {
            continue;
        }
        let phi = (occ.deviation(i, pb) + occ.deviation(j, pa)) / std::f64::consts::TAU;
        candidates.push((pa.distance(pb) * (1.0 + phi), i.min(j), i.max(j)));
    }
    candidates.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)).then(x.2.cmp(&y.2)));
    let mut sets = DisjointSets::new(input.walks.len());
    let mut bridges = Vec::with_capacity(input.walks.len() - 1);
    let mut hint = Hint::default();
    for (_, from, to) in candidates {
        if !sets.join(occ.walk(from), occ.walk(to)) {
            continue;
        }
        let (a, b) = (occ.point(from), occ.point(to));
        let line = LineSizes::new(a, b, size, &mut hint);
        let count = (line.wanted_segments().round() as usize).max(1) - 1;
        let first = new_points.len();
        for k in 1..=count {
            new_points.push(a.lerp(b, line.parameter(k, count)));
        }
        bridges.push(Bridge { from, to, first, count });
    }
    let root = sets.find(0);
    match (0..input.walks.len()).find(|&w| sets.find(w) != root) {
        Some(walk) => Err(BridgeError::Unreachable { walk }),
        None => Ok(bridges),
    }
}

/// Step 5.
fn write_contour(
    occ: &Occurrences<'_>,
    bridges: &[Bridge],
    size: &dyn SizeField,
    first_new_id: u32,
    out: &mut Bridged,
) {
    // Exits of each occurrence in the order in which the contour takes them: from the incoming segment clockwise.
    let mut exits: Vec<(usize, f64, usize)> = Vec::with_capacity(2 * bridges.len());
    for (k, b) in bridges.iter().enumerate() {
        let towards = |o: usize, far: Point2| occ.exit_angle(o, far);
        exits.push((b.from, towards(b.from, occ.point(b.to)), 2 * k));
        exits.push((b.to, towards(b.to, occ.point(b.from)), 2 * k + 1));
    }
    exits.sort_by(|x, y| x.0.cmp(&y.0).then(y.1.total_cmp(&x.1)));
    let n_occ = occ.place.len();
    let mut exit_start = vec![0usize; n_occ + 1];
    for e in &exits {
        exit_start[e.0 + 1] += 1;
    }
    for o in 0..n_occ {
        exit_start[o + 1] += exit_start[o];
    }
    let mut rank = vec![0usize; exits.len()];
    for (r, e) in exits.iter().enumerate() {
        rank[e.2] = r;
    }
    let mut hint = Hint::default();
    let mut push = |contour: &mut Contour, p: Point2, id: u32, flags: NodeFlags| {
        contour.push(p, id, size.h(p, &mut hint), flags);
    };
    let total = n_occ + exits.len() + bridges.iter().map(|b| 2 * b.count).sum::<usize>();
    let (mut o, mut exit) = (0usize, exit_start[0]);
    // Every exit is taken once and every walk segment once: `total` bounds the traversal.
    for _ in 0..total {
        let node = occ.node(o);
        push(&mut out.contour, occ.point(o), node, occ.input.flags[node as usize]);
        if exit < exit_start[o + 1] {
            let half = exits[exit].2;
            let b = &bridges[half / 2];
            let forward = half.is_multiple_of(2);
            for k in 0..b.count {
                let k = b.first + if forward { k } else { b.count - 1 - k };
                push(&mut out.contour, out.new_points[k], first_new_id + k as u32, NodeFlags::default());
            }
            o = if forward { b.to } else { b.from };
            exit = rank[half ^ 1] + 1;
            if occ.len_of(o) == 1 && exit == exit_start[o + 1] {
                exit = exit_start[o];
            }
        } else {
            o = occ.next(o);
            exit = exit_start[o];
        }
        if (o, exit) == (0, exit_start[0]) {
            break;
        }
    }
}

/// Union-find.
struct DisjointSets(Vec<u32>);

impl DisjointSets {
    fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }
    fn find(&mut self, mut a: usize) -> usize {
        while self.0[a] as usize != a {
            self.0[a] = self.0[self.0[a] as usize];
            a = self.0[a] as usize;
        }
        a
    }
    /// Joins two sets; false if they were one already.
    fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b)] = a.min(b) as u32;
        a != b
    }
}

#[cfg(test)]
mod tests;
