//! The triangles inside a weakly simple contour, each corner assigned to an occurrence.
//!
//! ```text
//!            third                the fan of occurrence i: from its outgoing segment e_i
//!           ╱     ╲               counter-clockwise through the triangles to the incoming one.
//!   b_{i-1} ── b_i ── b_{i+1}     A wide occurrence has two inner points, `a` for the first
//!     e_{i-1}      e_i            triangles of its fan and `b` for the rest.
//! ```
//!
//! 1. [`weld`]: occurrences to distinct nodes.
//! 2. [`load`]: constrained Delaunay triangulation.
//! 3. [`insert_inner_points`], if wanted.
//! 4. [`flood`]: the triangles inside.
//! 5. [`walk_fans`]: corners to occurrences.
//! 6. [`collect`]: the triangles in names of inner points.
//!
//! Cost O(n log n).

use super::FallbackError;
use csalf_geom::{Point2, predicates::is_left};
use csalf_mesh::Contour;
use csalf_sizemap::cdt::{Cdt, Constrained, Node, constrained};
use spade::handles::{FixedDirectedEdgeHandle, FixedVertexHandle};
use spade::{PositionInTriangulation, Triangulation};

const NONE: u32 = u32::MAX;

/// The triangulation in names of inner points: `first[i]` is point `a` of occurrence i, and `first[i] + 1` its point
/// `b` if it has two; the free inner points come after all of them.
#[derive(Debug)]
pub(super) struct Inner {
    /// One entry more than occurrences: the last is the name of the first free point.
    pub(super) first: Vec<u32>,
    /// Free inner points.
    pub(super) free: Vec<Point2>,
    /// Triangles of inner points, counter-clockwise.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Twice the area of the same triangle with its corners still on the contour; 0 for those of the wedges.
    pub(super) area: Vec<f64>,
}

/// Triangulates the inside of `contour`. `wide[i]`: occurrence i has two inner points; `bisector[i]` points to the
/// middle of its angle (read for wide ones only).
pub(super) fn triangulate(
    contour: &Contour,
    wide: &[bool],
    bisector: &[Point2],
    inner_points: bool,
) -> Result<Inner, FallbackError> {
    let n = contour.len();
    let (mut vertex, points) = weld(contour)?;
    let n_nodes = points.len();
    let mut cdt = load(&mut vertex, points)?;
    let mut segment = segments(&cdt, &vertex)?;
    if inner_points {
        let inside = flood(&cdt, &segment)?;
        insert_inner_points(&mut cdt, contour, &vertex, &inside);
        segment = segments(&cdt, &vertex)?;
    }
    let inside = flood(&cdt, &segment)?;
    let n_free = cdt.num_vertices() - n_nodes;
    let n_triangles = inside.iter().filter(|&&f| f).count();
    if n_triangles + 2 != n + 2 * n_free {
        return Err(FallbackError::NotSimple { at: 0 });
    }
    let mut first = Vec::with_capacity(n + 1);
    let mut next = 0;
    for &w in wide {
        first.push(next);
        next += 1 + u32::from(w);
    }
    first.push(next);
    let mut name = vec![NONE; cdt.num_directed_edges()];
    walk_fans(&cdt, contour, &segment, wide, bisector, &first, &mut name)?;
    let mut free = Vec::with_capacity(n_free);
    for v in cdt.vertices().skip(n_nodes) {
        for e in v.out_edges() {
            name[e.fix().index()] = next + free.len() as u32;
        }
        free.push(Point2::new(v.position().x, v.position().y));
    }
    let (triangles, area) = collect(&cdt, &inside, &name)?;
    Ok(Inner { first, free, triangles, area })
}

/// Occurrences to distinct nodes: `(node of each occurrence, place of each node)`.
fn weld(contour: &Contour) -> Result<(Vec<u32>, Vec<Point2>), FallbackError> {
    let n = contour.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by_key(|&i| (contour.ids[i], i));
    let mut owner = vec![0usize; n];
    for w in 0..n {
        let i = order[w];
        let same = w > 0 && contour.ids[order[w - 1]] == contour.ids[i];
        owner[i] = if same { owner[order[w - 1]] } else { i };
        if contour.points[owner[i]] != contour.points[i] {
            return Err(FallbackError::Coincident { a: owner[i], b: i });
        }
    }
    // Nodes are numbered in order of their first occurrence.
    let mut vertex = vec![NONE; n];
    let mut points = Vec::with_capacity(n);
    for i in 0..n {
        if owner[i] == i {
            vertex[i] = points.len() as u32;
            points.push(contour.points[i]);
        } else {
            vertex[i] = vertex[owner[i]];
        }
    }
    // Two nodes in one place.
    let mut at: Vec<usize> = (0..n).filter(|&i| owner[i] == i).collect();
    let key = |i: usize| contour.points[i];
    at.sort_by(|&a, &b| key(a).x.total_cmp(&key(b).x).then(key(a).y.total_cmp(&key(b).y)).then(a.cmp(&b)));
    match at.windows(2).find(|w| key(w[0]) == key(w[1])) {
        Some(w) => Err(FallbackError::Coincident { a: w[0], b: w[1] }),
        None => Ok((vertex, points)),
    }
}

/// The constrained Delaunay triangulation of the nodes. Coordinates that differ from 0 by less than the library
/// accepts are taken as 0; the final checks use the true ones. `vertex`: nodes come in, vertices go out.
fn load(vertex: &mut [u32], points: Vec<Point2>) -> Result<Cdt, FallbackError> {
    let n = vertex.len();
    let n_nodes = points.len();
    let mut edges = Vec::with_capacity(n);
    for i in 0..n {
        let (a, b) = (vertex[i], vertex[(i + 1) % n]);
        if a == b {
            return Err(FallbackError::Coincident { a: i, b: (i + 1) % n });
        }
        edges.push([a.min(b), a.max(b)]);
    }
    edges.sort_unstable();
    edges.dedup();
    let made = constrained(points, edges).map_err(|_| FallbackError::NotFinite { at: 0 })?;
    let Constrained { cdt, vertex: handle, conflict, .. } = made;
    if let Some([a, b]) = conflict {
        let is = |i: usize| {
            let (u, v) = (vertex[i], vertex[(i + 1) % n]);
            [u.min(v), u.max(v)] == [a, b]
        };
        return Err(FallbackError::Crossing { segment: (0..n).find(|&i| is(i)).unwrap_or(0) });
    }
    if cdt.num_vertices() != n_nodes {
        return Err(FallbackError::Coincident { a: 0, b: 0 });
    }
    vertex.iter_mut().for_each(|v| *v = handle[*v as usize].index() as u32);
    Ok(cdt)
}

/// The contour segment that each directed edge is, or `NONE`.
fn segments(cdt: &Cdt, vertex: &[u32]) -> Result<Vec<u32>, FallbackError> {
    let n = vertex.len();
    let mut segment = vec![NONE; cdt.num_directed_edges()];
    for i in 0..n {
        let (a, b) = (vertex[i] as usize, vertex[(i + 1) % n] as usize);
        let e = cdt
            .get_edge_from_neighbors(FixedVertexHandle::from_index(a), FixedVertexHandle::from_index(b))
            .filter(|e| e.is_constraint_edge())
            .ok_or(FallbackError::Crossing { segment: i })?;
        let s = &mut segment[e.fix().index()];
        if *s != NONE {
            return Err(FallbackError::Crossing { segment: i });
        }
        *s = i as u32;
    }
    Ok(segment)
}

/// Marks the faces that are reached from the left sides of the contour segments without crossing a segment.
fn flood(cdt: &Cdt, segment: &[u32]) -> Result<Vec<bool>, FallbackError> {
    let mut inside = vec![false; cdt.num_all_faces()];
    let mut stack = Vec::new();
    for e in cdt.directed_edges() {
        let s = segment[e.fix().index()];
        if s == NONE {
            continue;
        }
        if e.face().is_outer() {
            return Err(FallbackError::NotSimple { at: s as usize });
        }
        stack.push(e.fix());
        while let Some(e) = stack.pop() {
            let e = cdt.directed_edge(e);
            let Some(face) = e.face().as_inner() else {
                return Err(FallbackError::NotSimple { at: s as usize });
            };
            if std::mem::replace(&mut inside[face.fix().index()], true) {
                continue;
            }
            for side in face.adjacent_edges() {
                if !side.is_constraint_edge() {
                    stack.push(side.rev().fix());
                }
            }
        }
    }
    Ok(inside)
}

/// Names the corner at the start of each directed edge of the fans.
fn walk_fans(
    cdt: &Cdt,
    contour: &Contour,
    segment: &[u32],
    wide: &[bool],
    bisector: &[Point2],
    first: &[u32],
    name: &mut [u32],
) -> Result<(), FallbackError> {
    let n = contour.len();
    let mut fan: Vec<FixedDirectedEdgeHandle> = Vec::new();
    for start in cdt.directed_edges() {
        let s = segment[start.fix().index()];
        if s == NONE {
            continue;
        }
        let i = s as usize;
        let wrong = FallbackError::NotSimple { at: i };
        fan.clear();
        let mut e = start;
        loop {
            if e.face().is_outer() || fan.len() > name.len() {
                return Err(wrong);
            }
            fan.push(e.fix());
            let last = e.prev();
            if last.is_constraint_edge() {
                if segment[last.fix().index()] as usize != (i + n - 1) % n {
                    return Err(wrong);
                }
                break;
            }
            e = last.rev();
        }
        // Where a wide fan changes from point a to point b: at the spoke closest to the bisector.
        let mut change = fan.len();
        if wide[i] {
            let mut best = f64::NEG_INFINITY;
            for (k, &e) in fan.iter().enumerate().skip(1) {
                let to = cdt.directed_edge(e).to().position();
                let d = (Point2::new(to.x, to.y) - contour.points[i]).normalize_or_zero().dot(bisector[i]);
                if d > best {
                    (best, change) = (d, k);
                }
            }
            if change == fan.len() {
                return Err(wrong);
            }
        }
        for (k, e) in fan.iter().enumerate() {
            let slot = &mut name[e.index()];
            if *slot != NONE {
                return Err(wrong);
            }
            *slot = first[i] + u32::from(k >= change);
        }
    }
    Ok(())
}

/// The triangles in names, then those that fill the gaps where a wide occurrence changes its point.
fn collect(cdt: &Cdt, inside: &[bool], name: &[u32]) -> Result<(Vec<[u32; 3]>, Vec<f64>), FallbackError> {
    let mut triangles = Vec::with_capacity(inside.len());
    let mut area = Vec::with_capacity(inside.len());
    for face in cdt.inner_faces().filter(|f| inside[f.fix().index()]) {
        let corners = face.adjacent_edges().map(|e| name[e.fix().index()]);
        if corners.contains(&NONE) {
            return Err(FallbackError::NotSimple { at: 0 });
        }
        triangles.push(corners);
        area.push(2.0 * face.area());
    }
    for edge in cdt.undirected_edges().filter(|e| !e.is_constraint_edge()) {
        let e = edge.as_directed();
        let at = |h: FixedDirectedEdgeHandle| name[h.index()];
        let r = e.rev();
        if !inside[e.face().fix().index()] || !inside[r.face().fix().index()] {
            continue;
        }
        let (u_left, v_left) = (at(e.fix()), at(e.next().fix()));
        let (v_right, u_right) = (at(r.fix()), at(r.next().fix()));
        if u_left != u_right {
            triangles.push([v_left, u_left, u_right]);
            area.push(0.0);
        }
        if v_left != v_right {
            triangles.push([v_left, u_right, v_right]);
            area.push(0.0);
        }
    }
    Ok((triangles, area))
}

/// How much the size grows from a triangle to a point put into it. Larger: fewer points inside.
const GROWTH: f64 = 1.15;
/// A new point keeps this share of the local size from the corners of its triangle ...
const CORNER_DISTANCE: f64 = 0.75;
/// ... and this one from its sides.
const SIDE_DISTANCE: f64 = 0.35;
/// At most this many rounds of insertion, and this many points per contour node.
const MAX_ROUNDS: usize = 24;
const MAX_POINTS_PER_NODE: usize = 6;

/// Puts points into triangles that are large for the segments around, so that the quads of a large contour are not
/// slivers from side to side.
fn insert_inner_points(cdt: &mut Cdt, contour: &Contour, vertex: &[u32], inside: &[bool]) {
    let n = contour.len();
    let p = &contour.points;
    let mut size = vec![f64::INFINITY; cdt.num_vertices()];
    for i in 0..n {
        let l = p[i].distance(p[(i + 1) % n]).min(p[i].distance(p[(i + n - 1) % n]));
        let s = &mut size[vertex[i] as usize];
        *s = s.min(l);
    }
    let limit = cdt.num_vertices() + MAX_POINTS_PER_NODE * n;
    let mut todo: Vec<_> = cdt.inner_faces().filter(|f| inside[f.fix().index()]).map(|f| f.fix()).collect();
    for _ in 0..MAX_ROUNDS {
        let candidates: Vec<_> = todo.iter().filter_map(|&f| place(cdt, f, &size)).collect();
        todo.clear();
        for (q, h, near) in candidates {
            if cdt.num_vertices() >= limit {
                return;
            }
            // An earlier point of this round may have come too close.
            let PositionInTriangulation::OnFace(face) =
                cdt.locate_with_hint(spade::Point2::new(q.x, q.y), near)
            else {
                continue;
            };
            let corners = cdt.face(face).positions().map(|c| Point2::new(c.x, c.y));
            if corners.iter().any(|c| c.distance(q) < CORNER_DISTANCE * h) {
                continue;
            }
            let Ok(v) = cdt.insert_with_hint(Node::new(q), near) else { continue };
            if v.index() == size.len() {
                size.push(GROWTH * h);
            }
            let around = cdt.vertex(v).out_edges().filter_map(|e| e.face().as_inner());
            todo.extend(around.map(|f| f.fix()));
        }
        if todo.is_empty() {
            return;
        }
        todo.sort_unstable();
        todo.dedup();
    }
}

type Face = spade::handles::FixedFaceHandle<spade::handles::InnerTag>;

/// Where a point goes into a face: the circumcentre if it lies inside, else the middle. `None` if there is no room.
fn place(cdt: &Cdt, face: Face, size: &[f64]) -> Option<(Point2, f64, FixedVertexHandle)> {
    let f = cdt.face(face);
    let [a, b, c] = f.positions().map(|c| Point2::new(c.x, c.y));
    let h = f.vertices().map(|v| size[v.fix().index()]).iter().sum::<f64>() / 3.0;
    let o = f.circumcenter();
    let fits = |q: Point2| {
        let side = |a: Point2, b: Point2| {
            is_left(a, b, q) && (b - a).perp_dot(q - a) >= SIDE_DISTANCE * h * a.distance(b)
        };
        [a, b, c].iter().all(|v| v.distance(q) >= CORNER_DISTANCE * h)
            && side(a, b)
            && side(b, c)
            && side(c, a)
    };
    [Point2::new(o.x, o.y), (a + b + c) / 3.0]
        .into_iter()
        .find(|&q| fits(q))
        .map(|q| (q, h, f.vertices()[0].fix()))
}
