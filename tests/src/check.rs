//! An independent judge: is this mesh what the job asked for?
//!
//! Reads nothing but the job and the mesh; finds input nodes by their coordinates, bit for bit, and not by their
//! numbers. Shares only the exact predicate with the mesher.
//!
//! 1. Elements: indices, finite coordinates, all four corners strictly left turns ([`orient2d`]).
//! 2. Edges: no edge in one direction twice, so none with more than two quads ([`faults`]).
//! 3. Boundary: the edges of one quad are exactly the segments of the loops, material on the left.
//! 4. Every scar segment is an edge, every hard point a used vertex, no vertex unused, no triangle.
//! 5. Area to a relative 1e-9 and Euler's formula V - E + F = 1 - holes.
//!
//! Positive corners, conforming edges and the given boundary leave no room for overlaps or gaps. Cost O(n log n).

use csalf_core::Job;
use csalf_geom::{LoopKind, Point2, predicates::orient2d};
use csalf_mesh::QuadMesh;
use std::collections::BTreeMap;
use std::fmt;

/// Largest relative error of the area, from rounding. (The value of the common judge.)
const AREA: f64 = 1e-9;

/// Faults of one kind that are listed.
const LISTED: usize = 5;

/// One thing that is wrong with a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Kind, one word or two: what `reduce` keeps while it shrinks.
    pub kind: &'static str,
    /// Where and what.
    pub detail: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind, self.detail)
    }
}

/// Collects faults, some of each kind.
#[derive(Default)]
struct Faults(Vec<Fault>);

impl Faults {
    fn add(&mut self, kind: &'static str, detail: impl FnOnce() -> String) {
        if self.0.iter().filter(|f| f.kind == kind).count() < LISTED {
            self.0.push(Fault { kind, detail: detail() });
        }
    }
}

/// Bits of a point; -0.0 and 0.0 are the same place.
fn key(p: Point2) -> (u64, u64) {
    ((p.x + 0.0).to_bits(), (p.y + 0.0).to_bits())
}

/// Signed area of a closed polygon, relative to `origin` against cancellation.
fn area(p: &[Point2], origin: Point2) -> f64 {
    (0..p.len()).map(|i| 0.5 * (p[i] - origin).perp_dot(p[(i + 1) % p.len()] - origin)).sum()
}

/// Everything that is wrong with `mesh`, some of each kind; empty if it is valid. All-quad meshes only; the job must
/// be valid and its scars must meet in equal coordinates.
pub fn faults(job: &Job, mesh: &QuadMesh) -> Vec<Fault> {
    let mut out = Faults::default();
    let n = mesh.points.len();
    if !mesh.triangles.is_empty() {
        out.add("triangle", || format!("{} triangles", mesh.triangles.len()));
    }
    if mesh.quads.iter().flatten().any(|v| v.index() >= n) {
        out.add("bad index", || "a quad names a vertex that does not exist".into());
        return out.0;
    }
    if let Some(v) = mesh.points.iter().position(|p| !p.is_finite()) {
        out.add("not finite", || format!("vertex {v}"));
        return out.0;
    }
    let quads: Vec<[u32; 4]> = mesh.quads.iter().map(|q| q.map(|v| v.index() as u32)).collect();
    let got_area = elements(mesh, &quads, &mut out);
    let edges = edges(&quads, &mut out);
    against_job(job, mesh, &edges, got_area, &mut out);
    used(mesh, &quads, edges.len(), job, &mut out);
    out.0
}

/// Shapes; returns the sum of the areas.
fn elements(mesh: &QuadMesh, quads: &[[u32; 4]], out: &mut Faults) -> f64 {
    let mut sum = 0.0;
    for (i, q) in quads.iter().enumerate() {
        let p = q.map(|v| mesh.points[v as usize]);
        sum += 0.5 * (p[2] - p[0]).perp_dot(p[3] - p[1]);
        if (0..4).any(|k| q[..k].contains(&q[k])) {
            out.add("repeated vertex", || format!("quad {i}: {q:?}"));
        } else if (0..4).any(|k| orient2d(p[k], p[(k + 1) % 4], p[(k + 2) % 4]) <= 0.0) {
            out.add("not convex", || format!("quad {i} at ({}, {}): {q:?}", p[0].x, p[0].y));
        }
    }
    sum
}

/// Edges with the number of quads on their left going up (smaller to larger vertex) and going down.
type Edges = BTreeMap<(u32, u32), [u32; 2]>;

fn edges(quads: &[[u32; 4]], out: &mut Faults) -> Edges {
    let mut edges = Edges::new();
    for q in quads {
        for k in 0..4 {
            let (a, b) = (q[k], q[(k + 1) % 4]);
            edges.entry((a.min(b), a.max(b))).or_default()[usize::from(a > b)] += 1;
        }
    }
    for (e, n) in &edges {
        if n[0] > 1 || n[1] > 1 {
            out.add("edge overused", || format!("edge {e:?} has {n:?} quads"));
        }
    }
    edges
}

/// Boundary, scars, points, area.
fn against_job(job: &Job, mesh: &QuadMesh, edges: &Edges, got_area: f64, out: &mut Faults) {
    let mut vertex = BTreeMap::new();
    for (v, &p) in mesh.points.iter().enumerate() {
        if let Some(u) = vertex.insert(key(p), v as u32) {
            out.add("twin vertices", || format!("vertices {u} and {v} are at ({}, {})", p.x, p.y));
        }
    }
    let mut boundary = 0;
    let mut wanted_area = 0.0;
    let origin = job.domain.loops.first().and_then(|l| l.nodes.first()).copied().unwrap_or_default();
    for l in &job.domain.loops {
        let mut nodes = l.nodes.clone();
        let ccw = area(&nodes, origin) > 0.0;
        if ccw != (l.kind == LoopKind::Outer) {
            nodes.reverse();
        }
        wanted_area += area(&nodes, origin);
        for (i, &a) in nodes.iter().enumerate() {
            let b = nodes[(i + 1) % nodes.len()];
            let (Some(&u), Some(&v)) = (vertex.get(&key(a)), vertex.get(&key(b))) else {
                out.add("boundary moved", || format!("{} has no vertex at ({}, {})", l.name, a.x, a.y));
                continue;
            };
            let n = edges.get(&(u.min(v), u.max(v))).copied().unwrap_or_default();
            let (inside, outside) = if u < v { (n[0], n[1]) } else { (n[1], n[0]) };
            if (inside, outside) != (1, 0) {
                out.add("boundary segment", || format!("{} {u}-{v}: quads {inside}, {outside}", l.name));
            } else {
                boundary += 1;
            }
        }
    }
    let got = edges.values().filter(|n| n[0] + n[1] == 1).count();
    if got != boundary {
        out.add("boundary extra", || format!("{got} edges of one quad, {boundary} of the loops"));
    }
    for s in &job.domain.scars {
        for w in s.nodes.windows(2) {
            let ends = (vertex.get(&key(w[0])), vertex.get(&key(w[1])));
            let found = matches!(ends, (Some(&u), Some(&v)) if edges.contains_key(&(u.min(v), u.max(v))));
            if !found {
                out.add("scar missing", || format!("{} at ({}, {})", s.name, w[0].x, w[0].y));
            }
        }
    }
    for p in &job.domain.points {
        if !vertex.contains_key(&key(p.xy)) {
            out.add("point missing", || format!("{} at ({}, {})", p.name, p.xy.x, p.xy.y));
        }
    }
    if (got_area - wanted_area).abs() > AREA * wanted_area {
        out.add("area", || format!("{got_area} instead of {wanted_area}"));
    }
}

/// Unused vertices and Euler's formula.
fn used(mesh: &QuadMesh, quads: &[[u32; 4]], n_edges: usize, job: &Job, out: &mut Faults) {
    let mut used = vec![false; mesh.points.len()];
    quads.iter().flatten().for_each(|&v| used[v as usize] = true);
    for (v, _) in used.iter().enumerate().filter(|(_, u)| !**u) {
        out.add("unused vertex", || format!("vertex {v}"));
    }
    let n_used = used.iter().filter(|u| **u).count();
    let got = n_used as i64 - n_edges as i64 + quads.len() as i64;
    let wanted = 2 - job.domain.loops.len() as i64;
    if got != wanted {
        out.add("Euler", || format!("V - E + F = {got}, not {wanted}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_geom::{Domain, VertexId};

    /// A 2 x 1 rectangle of two quads.
    fn good() -> (Job, QuadMesh) {
        let p: Vec<_> =
            [(0., 0.), (1., 0.), (2., 0.), (2., 1.), (1., 1.), (0., 1.)].map(Point2::from).to_vec();
        let quads = [[0, 1, 4, 5], [1, 2, 3, 4]].map(|q| q.map(VertexId)).to_vec();
        let domain = Domain::new(p.clone()).with_scar(vec![p[1], p[4]]);
        (Job { domain, ..Job::default() }, QuadMesh { points: p, quads, triangles: Vec::new() })
    }

    fn kinds(job: &Job, mesh: &QuadMesh) -> Vec<&'static str> {
        faults(job, mesh).iter().map(|f| f.kind).collect()
    }

    #[test]
    fn a_good_mesh_has_no_faults() {
        let (mut job, mesh) = good();
        assert_eq!(faults(&job, &mesh), []);
        job.domain.loops[0].nodes.reverse();
        assert_eq!(faults(&job, &mesh), []);
    }

    #[test]
    fn each_fault_is_found() {
        let (job, mesh) = good();
        let broken = |change: &dyn Fn(&mut Job, &mut QuadMesh)| {
            let (mut j, mut m) = (job.clone(), mesh.clone());
            change(&mut j, &mut m);
            kinds(&j, &m)
        };
        assert!(broken(&|_, m| m.quads[0].reverse()).contains(&"not convex"));
        assert!(broken(&|_, m| m.quads[0][0] = VertexId(9)).contains(&"bad index"));
        assert!(broken(&|_, m| m.points[0].x = f64::NAN).contains(&"not finite"));
        assert!(broken(&|_, m| m.points[0].x = 1e-15).contains(&"boundary moved"));
        assert!(broken(&|_, m| m.quads.truncate(1)).contains(&"boundary segment"));
        assert!(broken(&|_, m| m.quads.truncate(1)).contains(&"boundary extra"));
        assert!(broken(&|_, m| m.quads.truncate(1)).contains(&"area"));
        assert!(broken(&|_, m| m.quads.push(m.quads[0])).contains(&"edge overused"));
        assert!(broken(&|_, m| m.points.push(Point2::ONE * 0.5)).contains(&"unused vertex"));
        assert!(broken(&|_, m| m.points.push(m.points[0])).contains(&"twin vertices"));
        assert!(broken(&|j, _| j.domain.scars[0].nodes[0].x = 0.0).contains(&"scar missing"));
        assert!(
            broken(&|j, _| j.domain = j.domain.clone().with_point(Point2::ONE * 0.3))
                .contains(&"point missing")
        );
        // A straight corner: the middle of the long side pulled onto the line of its neighbours.
        let (_, mut flat) = good();
        flat.points[1] = Point2::new(1.0, 1.0);
        flat.points[4] = Point2::new(1.0, 1.0);
        assert!(kinds(&job, &flat).contains(&"not convex"));
    }
}
