//! Patches of a triangulation, and the edges between them.
//!
//! ```text
//!   1. sides that are sharp, or have not exactly two triangles that run along them in opposite ways, are features
//!   2. triangles that are connected without crossing a feature are a patch = a face
//!   3. sides between different patches, or with one, are the edges' segments; vertices stand where the patches beside
//!      them change, where they branch, and at corners
//!   4. each patch's loops: from side to side round the boundary, through the triangles of the patch
//! ```

use super::weld::{Welded, agreeing_neighbours};
use super::{FacetOptions, Patch};
use crate::brep::{Body, Edge, EdgeUse, Face, FaceShape, Loop, Model};
use crate::geometry::{Curve, Polyline};
use glam::DVec3;
use std::collections::BTreeMap;

pub(super) fn segment(mesh: &Welded, options: &FacetOptions, model: &mut Model) {
    let across = agreeing_neighbours(&mesh.triangles);
    let (patch, n_patches) = patches(mesh, &across, options);
    let same = |i: usize, k: usize| across[i][k].filter(|j| patch[*j as usize] == patch[i]);
    // Half sides on the boundary of a patch: triangle and side.
    let boundary: Vec<(usize, usize)> = (0..mesh.triangles.len())
        .flat_map(|i| (0..3).map(move |k| (i, k)))
        .filter(|&(i, k)| same(i, k).is_none())
        .collect();
    let corners = corners(mesh, &patch, &boundary, options);
    let mut builder = Builder { mesh, corners, vertices: BTreeMap::new(), edges: BTreeMap::new() };
    let mut done = vec![[false; 3]; mesh.triangles.len()];
    let mut loops: Vec<Vec<Vec<u32>>> = vec![Vec::new(); n_patches];
    for &(i, k) in &boundary {
        if !done[i][k] {
            loops[patch[i]].push(trace(mesh, &same, i, k, &mut done));
        }
    }
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); n_patches];
    for (i, &p) in patch.iter().enumerate() {
        members[p].push(i);
    }
    let mut body = Body { name: "facets".into(), ..Body::default() };
    for (triangles, loops) in members.iter().zip(loops) {
        body.faces.push(builder.face(model, triangles, &loops));
    }
    body.solid = across.iter().flatten().all(Option::is_some);
    model.bodies.push(body);
}

/// The patch of each triangle, and how many there are.
fn patches(mesh: &Welded, across: &[[Option<u32>; 3]], options: &FacetOptions) -> (Vec<usize>, usize) {
    let normal = |i: usize| {
        let [a, b, c] = mesh.triangles[i].map(|v| mesh.points[v as usize]);
        (b - a).cross(c - a)
    };
    let limit = options.feature_angle.to_radians();
    let smooth = |i: usize, j: usize| {
        let (m, n) = (normal(i), normal(j));
        // A triangle without area has no normal: it belongs to its neighbours.
        let flat = m.length_squared() == 0.0 || n.length_squared() == 0.0;
        flat || m.cross(n).length().atan2(m.dot(n)) <= limit
    };
    let mut patch = vec![usize::MAX; mesh.triangles.len()];
    let mut n = 0;
    for start in 0..patch.len() {
        if patch[start] != usize::MAX {
            continue;
        }
        patch[start] = n;
        let mut stack = vec![start];
        while let Some(i) = stack.pop() {
            for j in across[i].iter().flatten().map(|j| *j as usize) {
                if patch[j] == usize::MAX && smooth(i, j) {
                    patch[j] = n;
                    stack.push(j);
                }
            }
        }
        n += 1;
    }
    (patch, n)
}

/// Which points are ends of edges.
fn corners(mesh: &Welded, patch: &[usize], boundary: &[(usize, usize)], options: &FacetOptions) -> Vec<bool> {
    // Patches beside each side on a boundary.
    let mut beside: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for &(i, k) in boundary {
        let t = mesh.triangles[i];
        let (a, b) = (t[k], t[(k + 1) % 3]);
        beside.entry([a.min(b), a.max(b)]).or_default().push(patch[i]);
    }
    beside.values_mut().for_each(|p| p.sort_unstable());
    let mut at: BTreeMap<u32, Vec<(u32, &Vec<usize>)>> = BTreeMap::new();
    for (&[a, b], p) in &beside {
        at.entry(a).or_default().push((b, p));
        at.entry(b).or_default().push((a, p));
    }
    let turn = options.corner_angle.to_radians();
    let mut corner = vec![false; mesh.points.len()];
    for (v, sides) in at {
        corner[v as usize] = match &sides[..] {
            [(a, p), (b, q)] => {
                let here = mesh.points[v as usize];
                let (d, e) = (here - mesh.points[*a as usize], mesh.points[*b as usize] - here);
                p != q || d.cross(e).length().atan2(d.dot(e)) > turn
            }
            _ => true,
        };
    }
    corner
}

/// The loop that begins with side `k` of triangle `i`, as points.
fn trace(
    mesh: &Welded,
    same: &dyn Fn(usize, usize) -> Option<u32>,
    i: usize,
    k: usize,
    done: &mut [[bool; 3]],
) -> Vec<u32> {
    let mut points = Vec::new();
    let (mut i, mut k) = (i, k);
    while !done[i][k] {
        done[i][k] = true;
        points.push(mesh.triangles[i][k]);
        // Round the side's end through the patch, to the next side on the boundary.
        let v = mesh.triangles[i][(k + 1) % 3];
        k = (k + 1) % 3;
        while let Some(j) = same(i, k) {
            i = j as usize;
            let Some(at) = (0..3).find(|&c| mesh.triangles[i][c] == v) else { return points };
            k = at;
        }
    }
    points
}

struct Builder<'a> {
    mesh: &'a Welded,
    corners: Vec<bool>,
    vertices: BTreeMap<u32, usize>,
    /// Edges by their first two points, both ways round: edge, and whether along it.
    edges: BTreeMap<[u32; 2], EdgeUse>,
}

impl Builder<'_> {
    fn vertex(&mut self, model: &mut Model, p: u32) -> usize {
        let points = &self.mesh.points;
        *self.vertices.entry(p).or_insert_with(|| model.add_vertex(points[p as usize]))
    }

    fn face(&mut self, model: &mut Model, triangles: &[usize], loops: &[Vec<u32>]) -> usize {
        let mut local: BTreeMap<u32, u32> = BTreeMap::new();
        let mut patch = Patch::default();
        for &i in triangles {
            let t = self.mesh.triangles[i].map(|v| {
                *local.entry(v).or_insert_with(|| {
                    patch.points.push(self.mesh.points[v as usize]);
                    patch.points.len() as u32 - 1
                })
            });
            patch.triangles.push(t);
        }
        let mut face = Face {
            name: String::new(),
            shape: FaceShape::Facets(Patch::default()),
            loops: Vec::new(),
            color: None,
        };
        for l in loops {
            let n = l.len();
            // The first corner, or else the lowest point, which the loop on the other side begins with as well.
            let start = (0..n)
                .find(|&i| self.corners[l[i] as usize])
                .or_else(|| (0..n).min_by_key(|&i| l[i]))
                .unwrap_or(0);
            let (mut uses, mut chains) = (Vec::new(), Vec::new());
            let mut chain = vec![l[start]];
            for i in 1..=n {
                let p = l[(start + i) % n];
                chain.push(p);
                if i == n || self.corners[p as usize] {
                    if let Some(u) = self.edge(model, &chain) {
                        uses.push(u);
                        chains.push(chain.iter().filter_map(|v| local.get(v).copied()).collect());
                    }
                    chain = vec![p];
                }
            }
            face.loops.push(Loop { uses, vertex: None });
            patch.chains.push(chains);
        }
        face.shape = FaceShape::Facets(patch);
        model.add_face(face)
    }

    /// The edge along these points, made if it is new.
    fn edge(&mut self, model: &mut Model, chain: &[u32]) -> Option<EdgeUse> {
        let n = chain.len();
        let (first, last) = ([chain[0], chain[1]], [chain[n - 1], chain[n - 2]]);
        if let Some(u) = self.edges.get(&first) {
            return Some(*u);
        }
        let points: Vec<DVec3> = chain.iter().map(|&v| self.mesh.points[v as usize]).collect();
        let line = Polyline::new(points)?;
        let range = [0.0, line.length()];
        let ends = [self.vertex(model, chain[0]), self.vertex(model, chain[n - 1])];
        let edge = model.add_edge(Edge {
            name: String::new(),
            curve: Curve::Polyline(line),
            range,
            ends,
            tolerance: 0.0,
        });
        self.edges.insert(first, EdgeUse { edge, forward: true });
        self.edges.insert(last, EdgeUse { edge, forward: false });
        Some(EdgeUse { edge, forward: true })
    }
}
