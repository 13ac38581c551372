//! One seed: growing cavities around it until a patch is better.
//!
//! ```text
//!   mesh ──copy──▶ cavity + 2 rings ──quads of the cavity by patch──▶ smooth ──compare──▶ mesh
//!                        before                                        after
//! ```

use super::grow::{Cavity, Site, weight};
use crate::smooth::{SmoothOptions, finish};
use csalf_geom::{Point2, VertexId};
use csalf_mesh::{Contour, NodeFlags, Patch, QuadMesh, QuadTopology, RegionTask, certify, quality::Corners};
use csalf_sizemap::Hint;

const NONE: u32 = u32::MAX;

/// Other irregular vertices are looked for within this many quads around a seed.
const SEARCH: usize = 200;
/// Most other irregular vertices that are tried.
const TARGETS: usize = 6;
/// Rings that are added when there are no more irregular vertices around.
const RINGS: usize = 2;

/// What is compared.
#[derive(Clone, Copy, Debug, Default)]
struct Measure {
    min: f64,
    mean: f64,
    off_size: f64,
}

impl Site<'_> {
    /// Tries to replace a cavity around `seed`. Returns how many patches were tried and whether one was
    /// taken; `near` receives the vertices whose surroundings changed.
    pub(super) fn improve(&mut self, seed: u32, cavity: &mut Cavity, near: &mut Vec<u32>) -> (usize, bool) {
        cavity.clear(self.mesh.n_vertices(), self.mesh.n_quads());
        let mut tried = 0;
        let [targets, parent] = self.search(seed);
        if !self.add_star(cavity, seed) || !self.close(cavity) {
            self.rejected.blocked += 1;
            return (tried, false);
        }
        let mut next_target = 0;
        let mut rings = 0;
        let mut last = (usize::MAX, usize::MAX);
        loop {
            let state = (cavity.quads.len(), next_target);
            if state.0 != last.0 && self.is_promising(cavity) {
                tried += 1;
                if self.attempt(cavity, near) {
                    return (tried, true);
                }
                if tried >= self.task.rules.patches {
                    return (tried, false);
                }
            }
            last = state;
            let good: Vec<u32> = cavity.quads.clone();
            let mut grown = false;
            while next_target < targets.len() {
                let (v, q) = targets[next_target];
                next_target += 1;
                if cavity.inside(v) == self.mesh.valence(v) {
                    continue;
                }
                if self.add_path(cavity, q, &parent) && self.add_star(cavity, v) && self.close(cavity) {
                    grown = true;
                    break;
                }
                self.restore(cavity, &good);
            }
            if !grown {
                if rings == RINGS {
                    self.rejected.hopeless += usize::from(tried == 0);
                    return (tried, false);
                }
                rings += 1;
                let rim = cavity.rim.clone();
                let all = rim.iter().all(|&v| !self.is_free(v) || self.add_star(cavity, v));
                if !all || !self.close(cavity) {
                    self.rejected.hopeless += usize::from(tried == 0);
                    return (tried, false);
                }
            }
        }
    }

    /// Back to these quads, which were a cavity.
    fn restore(&mut self, cavity: &mut Cavity, quads: &[u32]) {
        cavity.clear(self.mesh.n_vertices(), self.mesh.n_quads());
        for &q in quads {
            self.add(cavity, q);
        }
        self.close(cavity);
    }

    /// True if a patch might have a lower potential.
    fn is_promising(&mut self, cavity: &Cavity) -> bool {
        let now = self.potential(cavity);
        now > 0 && Self::least(cavity).is_some_and(|l| l < now)
    }

    /// The nearest irregular vertices around `seed`, each with a quad that has it, and the tree of quads back to
    /// the seed as pairs (quad, parent).
    fn search(&mut self, seed: u32) -> [Vec<(u32, u32)>; 2] {
        let mut order: Vec<(u32, u32)> = self.mesh.star(seed).iter().map(|&h| (h / 4, NONE)).collect();
        let mut found: Vec<(u32, u32)> = Vec::new();
        let mut seen: Vec<u32> = order.iter().map(|o| o.0).collect();
        seen.sort_unstable();
        let mut i = 0;
        while i < order.len() && order.len() < SEARCH && found.len() < TARGETS {
            let q = order[i].0;
            for v in self.mesh.quad(q) {
                if v != seed && found.iter().all(|f| f.0 != v) && self.is_irregular(v) {
                    found.push((v, q));
                }
            }
            for k in 0..4 {
                let Some(h) = self.mesh.across(q, k) else { continue };
                let o = h / 4;
                if self.task.protected.get(o as usize).copied().unwrap_or(false) {
                    continue;
                }
                if let Err(at) = seen.binary_search(&o) {
                    seen.insert(at, o);
                    order.push((o, q));
                }
            }
            i += 1;
        }
        order.sort_unstable();
        [found, order]
    }

    fn add_path(&self, cavity: &mut Cavity, mut q: u32, parent: &[(u32, u32)]) -> bool {
        while q != NONE {
            if !self.add(cavity, q) {
                return false;
            }
            q = parent.binary_search_by_key(&q, |p| p.0).map_or(NONE, |i| parent[i].1);
        }
        true
    }

    /// Fills the cavity, smooths, compares; commits if better.
    fn attempt(&mut self, cavity: &Cavity, near: &mut Vec<u32>) -> bool {
        let Some(patch) = self.fill(cavity) else {
            self.rejected.unfilled += 1;
            return false;
        };
        let n_rim = cavity.rim.len();
        let mut valence = vec![0usize; n_rim + patch.points.len()];
        patch.quads.iter().flatten().for_each(|&v| valence[v as usize] += 1);
        let fits = valence[..n_rim].iter().zip(&cavity.wanted).all(|(&d, &k)| d == usize::from(k));
        let after: u32 = valence[n_rim..].iter().map(|&d| weight(d, 4)).sum();
        if !fits || after >= self.potential(cavity) {
            self.rejected.unfilled += 1;
            return false;
        }
        let mut local = self.local(cavity, &patch);
        let before = self.measure_now(cavity, &local);
        let topology = QuadTopology::new(local.mesh.n_vertices(), &local.mesh.quads);
        if topology.n_bad_edges > 0 {
            return false;
        }
        let options = SmoothOptions {
            threshold: 2.0,
            rings: 0,
            laplace_sweeps: 3,
            sweeps: 6,
            ..SmoothOptions::default()
        };
        finish(&mut local.mesh, &topology, &local.fixed, self.task.size, &options);
        let now = self.measure(&local.mesh);
        let r = &self.task.rules;
        let counter = if certify(&local.mesh.points, &local.mesh.quads).is_some()
            || now.min < before.min.min(r.min_sj)
        {
            Some(&mut self.rejected.shape)
        } else if now.mean < before.mean - r.mean_loss {
            Some(&mut self.rejected.mean)
        } else if now.off_size > before.off_size + r.size_loss {
            Some(&mut self.rejected.size)
        } else {
            None
        };
        if let Some(counter) = counter {
            *counter += 1;
            return false;
        }
        self.commit(cavity, &patch, &local, near);
        true
    }

    fn fill(&self, cavity: &Cavity) -> Option<Patch> {
        let mut contour = Contour::default();
        let mut hint = Hint::default();
        for &v in &cavity.rim {
            let p = self.mesh.point(v);
            let flags = if self.is_free(v) { NodeFlags::default() } else { NodeFlags::GEOMETRY };
            contour.push(p, v, self.task.size.h(p, &mut hint), flags);
        }
        contour.wanted.clone_from(&cavity.wanted);
        let task = RegionTask { contour: &contour, size: self.task.size, tolerance: self.task.tolerance };
        self.task.mesher.mesh(&task).ok().filter(|p| p.children.is_empty())
    }

    /// The patch and two rings of quads around it as a mesh of their own.
    fn local(&self, cavity: &Cavity, patch: &Patch) -> Local {
        let mut around: Vec<u32> = Vec::new();
        let mut verts: Vec<u32> = cavity.rim.clone();
        for _ in 0..2 {
            for &v in &verts {
                around.extend(self.mesh.star(v).iter().map(|&h| h / 4).filter(|&q| !cavity.has(q)));
            }
            around.sort_unstable();
            around.dedup();
            verts = around.iter().flat_map(|&q| self.mesh.quad(q)).collect();
            verts.sort_unstable();
            verts.dedup();
        }
        let mut names: Vec<u32> = verts;
        names.extend(&cavity.rim);
        names.sort_unstable();
        names.dedup();
        let find = |v: u32| names.binary_search(&v).map_or(NONE, |i| i as u32);
        let mut mesh = QuadMesh {
            points: names.iter().map(|&v| self.mesh.point(v)).collect(),
            quads: around.iter().map(|&q| self.mesh.quad(q).map(|v| VertexId(find(v)))).collect(),
            triangles: Vec::new(),
        };
        let mut fixed: Vec<bool> = names.iter().map(|&v| !self.is_free(v)).collect();
        let n_old = names.len() as u32;
        let n_rim = cavity.rim.len() as u32;
        let rim: Vec<u32> = cavity.rim.iter().map(|&v| find(v)).collect();
        let name = |v: u32| if v < n_rim { rim[v as usize] } else { n_old + v - n_rim };
        mesh.points.extend_from_slice(&patch.points);
        fixed.resize(mesh.points.len(), false);
        mesh.quads.extend(patch.quads.iter().map(|q| q.map(|v| VertexId(name(v)))));
        Local { mesh, fixed, names, around }
    }

    fn measure_now(&self, cavity: &Cavity, local: &Local) -> Measure {
        let quads = cavity.quads.iter().chain(&local.around).map(|&q| self.mesh.quad(q));
        self.measure_quads(quads.map(|q| q.map(|v| self.mesh.point(v))))
    }

    fn measure(&self, mesh: &QuadMesh) -> Measure {
        self.measure_quads(mesh.quads.iter().map(|q| q.map(|v| mesh.points[v.index()])))
    }

    fn measure_quads(&self, quads: impl Iterator<Item = [Point2; 4]>) -> Measure {
        let mut m = Measure { min: 1.0, ..Measure::default() };
        let (mut n, mut off) = (0.0, 0.0);
        let mut hint = Hint::default();
        for p in quads {
            let c = Corners::new(&p);
            let s = c.min_scaled();
            m.min = m.min.min(s);
            m.mean += s;
            n += 1.0;
            let h = self.task.size.h(0.25 * (p[0] + p[1] + p[2] + p[3]), &mut hint);
            off += c.length.iter().filter(|&&l| !(0.7 * h..=1.4 * h).contains(&l)).count() as f64;
        }
        m.mean /= f64::max(n, 1.0);
        m.off_size = off / f64::max(4.0 * n, 1.0);
        m
    }

    fn commit(&mut self, cavity: &Cavity, patch: &Patch, local: &Local, near: &mut Vec<u32>) {
        let n_rim = cavity.rim.len() as u32;
        let first = self.mesh.n_vertices() as u32;
        let name = |v: u32| if v < n_rim { cavity.rim[v as usize] } else { first + v - n_rim };
        let quads: Vec<[u32; 4]> = patch.quads.iter().map(|q| q.map(name)).collect();
        let n_old = local.names.len();
        let new = self.mesh.replace(&cavity.quads, &quads, &local.mesh.points[n_old..]);
        for (i, &v) in local.names.iter().enumerate() {
            if !local.fixed[i] {
                self.mesh.set_point(v, local.mesh.points[i]);
            }
        }
        near.extend_from_slice(&local.names);
        near.extend(new);
    }
}

/// The part of the mesh that is smoothed with the patch.
struct Local {
    mesh: QuadMesh,
    fixed: Vec<bool>,
    /// Mesh names of the first vertices; those of the patch follow.
    names: Vec<u32>,
    /// The quads around the cavity.
    around: Vec<u32>,
}
