//! A mesh that can be edited in place, at a cost that depends on the edit alone.
//!
//! ```text
//!   quads   [q0][q1][ - ][q3] ...      removed quads and vertices leave free places, which new ones take
//!   stars   of the topology, until a vertex is touched; from then on a small list of its own
//! ```
//!
//! Source: handbook 6.1, with lists of quads at vertices in place of half-edges: a cavity is replaced as a
//! whole, and most vertices are never touched.

use crate::driver::REMOVED;
use csalf_geom::{Point2, VertexId};
use csalf_mesh::{QuadMesh, QuadTopology};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

const NONE: u32 = u32::MAX;

/// A quad mesh under edit. Borrowed topology is that of the mesh before the first edit.
#[derive(Debug)]
pub struct EditMesh<'a> {
    mesh: &'a mut QuadMesh,
    topology: &'a QuadTopology,
    n_before: (usize, usize),
    /// Per vertex: index into `lists`, or none while its star is that of the topology.
    slot: Vec<u32>,
    /// Per vertex: number of its quads, at most 255.
    degree: Vec<u8>,
    /// Per side 4 q + k: the side beyond, or none.
    twin: Vec<u32>,
    lists: Vec<Vec<u32>>,
    /// The lowest numbers are given first.
    free_quads: BinaryHeap<Reverse<u32>>,
    free_vertices: Vec<u32>,
    /// Vertices and quads of the mesh before that were removed, though their places may be taken again.
    gone: (Vec<u32>, Vec<u32>),
}

impl<'a> EditMesh<'a> {
    /// Starts editing. Cost: some words per vertex.
    pub fn new(mesh: &'a mut QuadMesh, topology: &'a QuadTopology) -> Self {
        let n_before = (mesh.n_vertices(), mesh.n_quads());
        Self {
            slot: vec![NONE; n_before.0],
            degree: topology.star_start.windows(2).map(|w| (w[1] - w[0]).min(255) as u8).collect(),
            twin: topology.twin.clone(),
            mesh,
            topology,
            n_before,
            lists: Vec::new(),
            free_quads: BinaryHeap::new(),
            free_vertices: Vec::new(),
            gone: Default::default(),
        }
    }

    /// The quads at `v` with its corner in them, `4 q + k`; empty for a removed vertex.
    #[inline]
    pub fn star(&self, v: u32) -> &[u32] {
        match self.slot[v as usize] {
            NONE => self.topology.star(VertexId(v)),
            s => &self.lists[s as usize],
        }
    }

    /// Number of quads at `v`; more than 255 count as 255.
    #[inline]
    pub fn valence(&self, v: u32) -> usize {
        usize::from(self.degree[v as usize])
    }

    /// True for vertices on the boundary; edits keep them.
    #[inline]
    pub fn on_boundary(&self, v: u32) -> bool {
        self.topology.on_boundary.get(v as usize).copied().unwrap_or(false)
    }

    /// Corners of quad `q`.
    #[inline]
    pub fn quad(&self, q: u32) -> [u32; 4] {
        self.mesh.quads[q as usize].map(|v| v.0)
    }

    /// Where `v` lies.
    #[inline]
    pub fn point(&self, v: u32) -> Point2 {
        self.mesh.points[v as usize]
    }

    /// Moves `v`.
    pub fn set_point(&mut self, v: u32, p: Point2) {
        self.mesh.points[v as usize] = p;
    }

    /// Number of vertex names in use or free.
    pub fn n_vertices(&self) -> usize {
        self.mesh.n_vertices()
    }

    /// Number of quad names in use or free.
    pub fn n_quads(&self) -> usize {
        self.mesh.n_quads()
    }

    /// True if quad `q` was removed.
    pub fn is_removed(&self, q: u32) -> bool {
        self.mesh.quads[q as usize][0].0 == NONE
    }

    /// The quad beyond side k of quad q, as its own side `4 q' + k'`; `None` on the boundary.
    #[inline]
    pub fn across(&self, q: u32, k: u32) -> Option<u32> {
        let h = self.twin[(4 * q + (k & 3)) as usize];
        (h != NONE).then_some(h)
    }

    /// The side that runs back along `h`, found at its head.
    fn beyond(&self, h: u32) -> u32 {
        let vs = self.quad(h / 4);
        let (a, b) = (vs[(h & 3) as usize], vs[((h + 1) & 3) as usize]);
        let back = |g: &u32| self.mesh.quads[(g / 4) as usize][((g + 1) & 3) as usize].0 == a;
        self.star(b).iter().copied().find(back).unwrap_or(NONE)
    }

    /// Replaces the quads `old` by `new`, in which names from `n_vertices()` on are new points in order.
    /// Vertices that lose their last quad are removed. Returns the names given to the new points.
    pub fn replace(&mut self, old: &[u32], new: &[[u32; 4]], points: &[Point2]) -> Vec<u32> {
        let first = self.n_vertices() as u32;
        let mut touched: Vec<u32> = Vec::with_capacity(4 * old.len());
        for &q in old {
            for (k, v) in self.quad(q).into_iter().enumerate() {
                touched.push(v);
                self.own(v).retain(|&h| h / 4 != q);
                let side = &mut self.twin[4 * q as usize + k];
                let beyond = std::mem::replace(side, NONE);
                if let Some(t) = self.twin.get_mut(beyond as usize) {
                    *t = NONE;
                }
            }
            self.mesh.quads[q as usize] = [VertexId(NONE); 4];
            self.free_quads.push(Reverse(q));
        }
        self.gone.1.extend(old);
        let mut names = Vec::with_capacity(points.len());
        for &p in points {
            names.push(match self.free_vertices.pop() {
                Some(v) => {
                    self.mesh.points[v as usize] = p;
                    v
                }
                None => {
                    self.mesh.points.push(p);
                    self.slot.push(self.lists.len() as u32);
                    self.degree.push(0);
                    self.lists.push(Vec::with_capacity(5));
                    self.slot.len() as u32 - 1
                }
            });
        }
        let mut placed = Vec::with_capacity(new.len());
        for q in new {
            let vs = q.map(|v| if v < first { v } else { names[(v - first) as usize] });
            let at = self.free_quads.pop().map_or(self.mesh.quads.len() as u32, |q| q.0);
            if at as usize == self.mesh.quads.len() {
                self.mesh.quads.push([VertexId(NONE); 4]);
                self.twin.extend([NONE; 4]);
            }
            placed.push(at);
            self.mesh.quads[at as usize] = vs.map(VertexId);
            for (k, v) in vs.into_iter().enumerate() {
                self.own(v).push(4 * at + k as u32);
                touched.push(v);
            }
        }
        for h in placed.into_iter().flat_map(|q| 4 * q..4 * q + 4) {
            let g = self.beyond(h);
            self.twin[h as usize] = g;
            if let Some(t) = self.twin.get_mut(g as usize) {
                *t = h;
            }
        }
        touched.sort_unstable();
        touched.dedup();
        for &v in &touched {
            self.degree[v as usize] = self.star(v).len().min(255) as u8;
        }
        // Descending, so that the lowest names are given first.
        let lone: Vec<u32> = touched.into_iter().rev().filter(|&v| self.star(v).is_empty()).collect();
        self.gone.0.extend(&lone);
        self.free_vertices.extend(lone);
        names
    }

    /// The list of `v`, made its own.
    fn own(&mut self, v: u32) -> &mut Vec<u32> {
        let s = &mut self.slot[v as usize];
        if *s == NONE {
            *s = self.lists.len() as u32;
            self.lists.push(self.topology.star(VertexId(v)).to_vec());
        }
        &mut self.lists[*s as usize]
    }

    /// Ends editing: closes the gaps, keeping the order. Returns the new number of each old vertex and quad,
    /// or [`REMOVED`]; empty if no number changed. Cost O(n) if something was removed.
    pub fn finish(self) -> (Vec<u32>, Vec<u32>) {
        let Self { mesh, n_before, free_vertices, gone, .. } = self;
        let mut maps = (Vec::new(), Vec::new());
        if !gone.0.is_empty() {
            let mut free = vec![false; mesh.n_vertices()];
            free_vertices.iter().for_each(|&v| free[v as usize] = true);
            maps.0 = close(&free, &mut mesh.points);
            for v in mesh.quads.iter_mut().flatten().chain(mesh.triangles.iter_mut().flatten()) {
                if v.0 != NONE {
                    *v = VertexId(maps.0[v.index()]);
                }
            }
            maps.0.truncate(n_before.0);
            forget(&mut maps.0, &gone.0);
        }
        if !gone.1.is_empty() {
            let free: Vec<bool> = mesh.quads.iter().map(|q| q[0].0 == NONE).collect();
            maps.1 = close(&free, &mut mesh.quads);
            maps.1.truncate(n_before.1);
            forget(&mut maps.1, &gone.1);
        }
        maps
    }
}

/// What was removed has no number, even if another took its place.
fn forget(map: &mut [u32], gone: &[u32]) {
    for &i in gone {
        if let Some(m) = map.get_mut(i as usize) {
            *m = REMOVED;
        }
    }
}

/// Drops what is gone; the new number of each entry.
fn close<T>(gone: &[bool], list: &mut Vec<T>) -> Vec<u32> {
    let mut next = 0;
    let map = gone
        .iter()
        .map(|&g| {
            next += u32::from(!g);
            if g { REMOVED } else { next - 1 }
        })
        .collect();
    let mut g = gone.iter();
    list.retain(|_| g.next().is_none_or(|&g| !g));
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of n x n unit quads.
    fn grid(n: u32) -> QuadMesh {
        let v = |i, j| VertexId(j * (n + 1) + i);
        QuadMesh {
            points: (0..=n)
                .flat_map(|j| (0..=n).map(move |i| Point2::new(f64::from(i), f64::from(j))))
                .collect(),
            quads: (0..n)
                .flat_map(|j| (0..n).map(move |i| [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)]))
                .collect(),
            triangles: Vec::new(),
        }
    }

    #[test]
    fn replaced_quads_leave_no_gaps() {
        let mut mesh = grid(4);
        let topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
        let mut edit = EditMesh::new(&mut mesh, &topology);
        assert_eq!(edit.across(0, 1), Some(4 + 3));
        assert_eq!(edit.across(0, 0), None);
        // Four quads around vertex 6 become one; vertices 6, 1, 5, 7, 11 lose quads, 6 all of them.
        let names = edit.replace(&[0, 1, 4, 5], &[[0, 2, 12, 10]], &[]);
        assert!(names.is_empty());
        assert!(edit.star(6).is_empty());
        assert_eq!(edit.valence(12), 4);
        let (vertices, quads) = edit.finish();
        assert_eq!(mesh.n_quads(), 13);
        assert_eq!(vertices[6], REMOVED);
        assert_eq!((quads[0], quads[1], quads[2]), (REMOVED, REMOVED, 1));
        assert_eq!(mesh.quads[0][1], VertexId(vertices[2]), "the new quad took the first free place");
        let expected = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
        assert_eq!(expected.n_bad_edges, 0);
    }
}
