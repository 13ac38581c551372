//! Is this mesh what was asked for? All defects, and a cheap certificate of convexity.
//!
//! Positive elements (exact predicates), conforming edges, exactly the given boundary and exactly the given
//! area together leave no room for overlaps or gaps.

use crate::QuadMesh;
use crate::quality::{Corners, FLAT, edges::HalfEdges, space::laid_flat};
use csalf_geom::{Point2, QuadId, Tolerance, VertexId, predicates::orient2d};

/// What a mesh must contain. All vertices are those of the mesh.
#[derive(Clone, Copy, Debug, Default)]
pub struct Expectation<'a> {
    /// The nodes of the input: vertex i of the mesh must be `nodes[i]`, bit for bit.
    pub nodes: &'a [Point2],
    /// Every boundary segment, material on the left.
    pub boundary: &'a [[VertexId; 2]],
    /// Every scar segment, in any direction.
    pub scars: &'a [[VertexId; 2]],
    /// Vertices that must be used by an element (hard points).
    pub points: &'a [VertexId],
    /// Area of the domain; not looked at if it is not positive.
    pub area: f64,
}

/// One thing that is wrong with a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshDefect {
    /// A quad or triangle names a vertex that does not exist. Nothing else is checked then.
    #[error("element {element} names vertex {vertex}, of {n_vertices}")]
    BadIndex {
        /// Number of the element, quads first.
        element: usize,
        /// What it names.
        vertex: VertexId,
        /// How many vertices there are.
        n_vertices: usize,
    },
    /// A coordinate is not finite.
    #[error("vertex {0} has a coordinate that is not finite")]
    NotFinite(VertexId),
    /// An element names a vertex twice.
    #[error("element {element} names a vertex twice")]
    RepeatedVertex {
        /// Number of the element, quads first.
        element: usize,
    },
    /// A quad of area <= 0, or with two or more corners that turn right.
    #[error("quad {0} is inverted")]
    Inverted(QuadId),
    /// A quad corner that is straight or concave, by an exact predicate.
    #[error("quad {quad} is not convex at corner {corner}")]
    NotConvex {
        /// The quad.
        quad: QuadId,
        /// Its corner, 0 to 3.
        corner: usize,
    },
    /// A quad corner that is convex, but straight up to rounding ([`FLAT`]).
    #[error("quad {quad} is flat at corner {corner}")]
    Flat {
        /// The quad.
        quad: QuadId,
        /// Its corner, 0 to 3.
        corner: usize,
    },
    /// A triangle that does not turn left, by an exact predicate.
    #[error("triangle {0} is inverted")]
    InvertedTriangle(usize),
    /// An edge of more than two elements.
    #[error("edge {0}-{1} belongs to more than two elements")]
    OverShared(VertexId, VertexId),
    /// An edge along which two elements run in the same direction.
    #[error("two elements run along edge {0}-{1} in the same direction")]
    SameDirection(VertexId, VertexId),
    /// A boundary segment of the input is not on the boundary of the mesh.
    #[error("boundary segment {0}-{1} is missing")]
    BoundaryMissing(VertexId, VertexId),
    /// An edge on the boundary of the mesh is none of the input's.
    #[error("edge {0}-{1} is on the boundary, but not of the input")]
    BoundaryExtra(VertexId, VertexId),
    /// The elements do not add up to the area of the domain, to a relative 1e-9.
    #[error("the area is {got}, not {wanted}")]
    Area {
        /// Sum over the elements.
        got: f64,
        /// Area of the domain.
        wanted: f64,
    },
    /// A scar segment is no edge of the mesh.
    #[error("scar segment {0}-{1} is missing")]
    ScarMissing(VertexId, VertexId),
    /// A hard point is not used by any element.
    #[error("hard point {0} is missing")]
    PointMissing(VertexId),
    /// An input node is not at its place, or not there at all.
    #[error("input node {0} has moved")]
    NodeMoved(VertexId),
    /// A vertex that no element uses.
    #[error("vertex {0} is not used")]
    Unused(VertexId),
    /// Two vertices of one element that are the same point up to the merge tolerance.
    #[error("vertices {0} and {1} are one point")]
    Coincident(VertexId, VertexId),
    /// V - E + F is not 2 - (number of boundary loops): the mesh is not connected, or has other holes.
    #[error("the Euler characteristic is {got}, not {wanted}")]
    Euler {
        /// V - E + F of the mesh.
        got: i64,
        /// 2 - number of loops of the expectation.
        wanted: i64,
    },
}

/// Largest relative error of the area, from the rounding of coordinates and of the sum. (The judge's value.)
pub const AREA_TOLERANCE: f64 = 1e-9;

/// Exact: every corner of the quad turns strictly left. Four left turns of less than 180 degrees each make
/// one full turn, so the quad is also simple. Cost about 10 ns: a float filter decides nearly always.
#[inline]
pub fn is_strictly_convex(p: &[Point2; 4]) -> bool {
    (0..4).all(|k| left(p[(k + 3) & 3], p[k], p[(k + 1) & 3]))
}

/// Exact sign of the turn a → b → c, left or not, behind a float filter (Shewchuk 1997, error bound A).
#[inline]
fn left(a: Point2, b: Point2, c: Point2) -> bool {
    /// (3 + 16 e) e with e = 2^-53.
    const BOUND: f64 = (3.0 + 8.0 * f64::EPSILON) * f64::EPSILON / 2.0;
    let (l, r) = ((a.x - c.x) * (b.y - c.y), (a.y - c.y) * (b.x - c.x));
    let det = l - r;
    // Below the smallest normal numbers the bound does not hold; the exact predicate has the same limit.
    if det.abs() > BOUND * (l.abs() + r.abs()) { det > 0.0 } else { orient2d(a, b, c) > 0.0 }
}

/// The certificate: the first quad of `quads` that is not strictly convex, by exact predicates; `None` if all
/// are. Takes any slice of a mesh's quads, so that pieces can be checked in parallel. Cost about 20 ns per
/// quad.
pub fn certify(points: &[Point2], quads: &[[VertexId; 4]]) -> Option<usize> {
    quads.iter().position(|q| !is_strictly_convex(&q.map(|v| points[v.index()])))
}

/// All defects of `mesh`, in a fixed order; empty if it is valid. Cost O(n log n) with small constants.
pub fn validate(mesh: &QuadMesh, expected: &Expectation<'_>) -> Vec<MeshDefect> {
    let mut out = Vec::new();
    check_elements(mesh, &mut out);
    if !out.is_empty() {
        return out;
    }
    let edges = HalfEdges::new(mesh);
    check_shapes(mesh, expected, &mut out);
    check_edges(&edges, expected, &mut out);
    check_nodes(mesh, &edges, expected, &mut out);
    check_euler(mesh, &edges, expected, &mut out);
    out
}

/// What is wrong with a mesh in space, seen from above with the heights of its vertices, of which nothing else is known:
/// its indices, its shapes, each element in its mean plane, and the direction of elements that share a side. Sides of
/// one element, and of three or more, are no defects there. Cost O(n).
pub fn validate_in_space(mesh: &QuadMesh, heights: &[f64]) -> Vec<MeshDefect> {
    let mut out = Vec::new();
    check_elements(mesh, &mut out);
    let wild = heights.iter().enumerate().filter(|(_, z)| !z.is_finite());
    out.extend(wild.map(|(i, _)| MeshDefect::NotFinite(VertexId::new(i))));
    if !out.is_empty() {
        return out;
    }
    let flat = laid_flat(mesh, heights);
    for (i, (vs, own)) in mesh.quads.iter().zip(&flat.quads).enumerate() {
        if names_twice(vs) {
            out.push(MeshDefect::RepeatedVertex { element: i });
            continue;
        }
        let scaled = Corners::new(&own.map(|v| flat.points[v.index()])).scaled;
        // A length of 0 makes a NaN.
        if let Some(corner) = scaled.iter().position(|s| s.is_nan() || *s <= FLAT) {
            out.push(MeshDefect::NotConvex { quad: QuadId::new(i), corner });
        }
    }
    for (i, vs) in mesh.triangles.iter().enumerate() {
        if names_twice(vs) {
            out.push(MeshDefect::RepeatedVertex { element: mesh.n_quads() + i });
        }
    }
    let edges = HalfEdges::new(mesh);
    let ends = |&h: &u32| MeshDefect::SameDirection(VertexId(edges.tail(h)), VertexId(edges.head(h)));
    out.extend(edges.same_direction.iter().map(ends));
    out
}

/// Indices and coordinates: what everything else relies on.
fn check_elements(mesh: &QuadMesh, out: &mut Vec<MeshDefect>) {
    let n_vertices = mesh.n_vertices();
    let elements = mesh.quads.iter().map(|q| &q[..]).chain(mesh.triangles.iter().map(|t| &t[..])).enumerate();
    for (element, vs) in elements {
        for &vertex in vs {
            if vertex.index() >= n_vertices {
                out.push(MeshDefect::BadIndex { element, vertex, n_vertices });
            }
        }
    }
    for (i, p) in mesh.points.iter().enumerate() {
        if !p.is_finite() {
            out.push(MeshDefect::NotFinite(VertexId::new(i)));
        }
    }
}

/// True if an element names a vertex twice.
fn names_twice(vs: &[VertexId]) -> bool {
    (1..vs.len()).any(|k| vs[..k].contains(&vs[k]))
}

fn check_shapes(mesh: &QuadMesh, expected: &Expectation<'_>, out: &mut Vec<MeshDefect>) {
    let merge = Tolerance::of_points(mesh.points.iter().copied()).merge();
    let mut area = 0.0;
    for (i, vs) in mesh.quads.iter().enumerate() {
        let quad = QuadId::new(i);
        let p = vs.map(|v| mesh.points[v.index()]);
        let c = Corners::new(&p);
        area += c.area;
        let repeated = names_twice(vs);
        if repeated {
            out.push(MeshDefect::RepeatedVertex { element: i });
        }
        // A quad well away from every limit is decided here: the filter's bound is far below FLAT.
        if !repeated && c.scaled.iter().all(|&s| s > FLAT) && is_strictly_convex(&p) {
            if c.length.iter().any(|&l| l <= merge) || p[0].distance(p[2]).min(p[1].distance(p[3])) <= merge {
                check_coincident(vs, &p, merge, out);
            }
            continue;
        }
        let turns_left: [bool; 4] = std::array::from_fn(|k| left(p[(k + 3) & 3], p[k], p[(k + 1) & 3]));
        let n_right = (0..4).filter(|&k| left(p[(k + 1) & 3], p[k], p[(k + 3) & 3])).count();
        if c.area <= 0.0 || n_right >= 2 {
            out.push(MeshDefect::Inverted(quad));
        } else {
            for (corner, turns_left) in turns_left.into_iter().enumerate() {
                if !turns_left {
                    out.push(MeshDefect::NotConvex { quad, corner });
                } else if c.scaled[corner] <= FLAT {
                    out.push(MeshDefect::Flat { quad, corner });
                }
            }
        }
        check_coincident(vs, &p, merge, out);
    }
    for (i, vs) in mesh.triangles.iter().enumerate() {
        let p = vs.map(|v| mesh.points[v.index()]);
        area += Corners::new(&p).area;
        if names_twice(vs) {
            out.push(MeshDefect::RepeatedVertex { element: mesh.n_quads() + i });
        }
        if !left(p[0], p[1], p[2]) {
            out.push(MeshDefect::InvertedTriangle(i));
        }
        check_coincident(vs, &p, merge, out);
    }
    if expected.area > 0.0 && (area - expected.area).abs() > AREA_TOLERANCE * expected.area {
        out.push(MeshDefect::Area { got: area, wanted: expected.area });
    }
}

fn check_coincident(vs: &[VertexId], p: &[Point2], merge: f64, out: &mut Vec<MeshDefect>) {
    for i in 0..p.len() {
        for j in 0..i {
            if vs[i] != vs[j] && p[i].distance(p[j]) <= merge {
                let defect = MeshDefect::Coincident(vs[j].min(vs[i]), vs[i].max(vs[j]));
                // The pair is found by every element that has both; elements of one place come close
                // together.
                if !out.iter().rev().take(8).any(|d| *d == defect) {
                    out.push(defect);
                }
            }
        }
    }
}

fn check_edges(edges: &HalfEdges, expected: &Expectation<'_>, out: &mut Vec<MeshDefect>) {
    let ends = |h: u32| (VertexId(edges.tail(h)), VertexId(edges.head(h)));
    for &h in &edges.over_shared {
        let (a, b) = ends(h);
        out.push(MeshDefect::OverShared(a, b));
    }
    for &h in &edges.same_direction {
        let (a, b) = ends(h);
        out.push(MeshDefect::SameDirection(a, b));
    }
    // Boundary: two sorted lists of directed edges must be the same.
    let mut got: Vec<_> = edges.boundary().map(ends).collect();
    let mut wanted: Vec<_> = expected.boundary.iter().map(|s| (s[0], s[1])).collect();
    got.sort_unstable();
    wanted.sort_unstable();
    let (mut i, mut j) = (0, 0);
    while i < got.len() || j < wanted.len() {
        if j == wanted.len() || (i < got.len() && got[i] < wanted[j]) {
            out.push(MeshDefect::BoundaryExtra(got[i].0, got[i].1));
            i += 1;
        } else if i == got.len() || wanted[j] < got[i] {
            out.push(MeshDefect::BoundaryMissing(wanted[j].0, wanted[j].1));
            j += 1;
        } else {
            i += 1;
            j += 1;
        }
    }
}

fn check_nodes(mesh: &QuadMesh, edges: &HalfEdges, expected: &Expectation<'_>, out: &mut Vec<MeshDefect>) {
    let n = mesh.n_vertices();
    let used = |v: VertexId| v.index() < n && edges.n_elements_at(v.0) > 0;
    let along = |a: VertexId, b: VertexId| used(a) && edges.out(a.0).iter().any(|&h| edges.head(h) == b.0);
    for &[a, b] in expected.scars {
        if !along(a, b) && !along(b, a) {
            out.push(MeshDefect::ScarMissing(a, b));
        }
    }
    for &v in expected.points {
        if !used(v) {
            out.push(MeshDefect::PointMissing(v));
        }
    }
    for (i, p) in expected.nodes.iter().enumerate() {
        // -0.0 and 0.0 are the same place.
        if mesh.points.get(i) != Some(p) {
            out.push(MeshDefect::NodeMoved(VertexId::new(i)));
        }
    }
    for i in 0..n {
        if edges.n_elements_at(i as u32) == 0 {
            out.push(MeshDefect::Unused(VertexId::new(i)));
        }
    }
}

/// V - E + F = 2 - L for a connected mesh whose boundary is L simple loops. If the given loops touch in a
/// node they cannot be counted apart, and the check is left out.
fn check_euler(mesh: &QuadMesh, edges: &HalfEdges, expected: &Expectation<'_>, out: &mut Vec<MeshDefect>) {
    let n = mesh.n_vertices();
    let mut next = vec![u32::MAX; n];
    for [a, b] in expected.boundary {
        if a.index() >= n || b.index() >= n || next[a.index()] != u32::MAX {
            return;
        }
        next[a.index()] = b.0;
    }
    let mut n_loops = 0i64;
    for s in 0..n {
        let mut v = s;
        let mut steps = 0usize;
        while next[v] != u32::MAX {
            v = std::mem::replace(&mut next[v], u32::MAX) as usize;
            steps += 1;
        }
        if steps > 0 && v != s {
            return;
        }
        n_loops += i64::from(steps > 0);
    }
    let wanted = 2 - n_loops;
    let n_used = (0..n as u32).filter(|&v| edges.n_elements_at(v) > 0).count();
    let got = n_used as i64 - edges.n_edges as i64 + (mesh.n_quads() + mesh.triangles.len()) as i64;
    if n_loops > 0 && got != wanted {
        out.push(MeshDefect::Euler { got, wanted });
    }
}

#[cfg(test)]
mod tests;
