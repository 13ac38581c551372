//! One seed: growing cavities around it until a patch is better.
//!
//! ```text
//!   mesh ──copy──▶ cavity + a ring ──quads of the cavity by patch──▶ smooth ──compare──▶ mesh
//!                        before                                        after
//! ```

use super::grow::{Cavity, INNER, Saved, Site, weight};
use super::local_size::LinearSize;
use crate::smooth::{SmoothOptions, finish, smooth};
use csalf_geom::{Point2, VertexId};
use csalf_mesh::{Contour, NodeFlags, Patch, QuadMesh, QuadTopology, RegionTask, certify, quality::Corners};
use csalf_sizemap::{Hint, SizeField};

const NONE: u32 = u32::MAX;

/// Other irregular vertices are looked for within this many quads around a seed.
const SEARCH: usize = 200;
/// Most other irregular vertices that are tried.
const TARGETS: usize = 4;
/// Most cavities per seed that are given to the mesher.
const FILLS: usize = 12;
/// Rings that are added when there are no more irregular vertices around.
const RINGS: usize = 1;

/// The mean scaled Jacobian of a patch rises by less than this when it is smoothed (measured; 8 percent of
/// the patches that were good after it are lost). Larger: more patches are smoothed in vain.
const RAW_MEAN: f64 = 0.04;
/// Likewise the fall of the share of edges of a wrong length.
const RAW_SIZE: f64 = 0.05;

/// What is compared.
#[derive(Clone, Copy, Debug, Default)]
struct Measure {
    min: f64,
    /// Sum of the scaled Jacobians.
    sum: f64,
    /// Number of edges of a wrong length, a quarter for each quad.
    off: f64,
    /// Number of quads.
    n: f64,
}

impl Measure {
    fn and(self, o: &Self) -> Self {
        Self { min: self.min.min(o.min), sum: self.sum + o.sum, off: self.off + o.off, n: self.n + o.n }
    }
    fn mean(&self) -> f64 {
        self.sum / self.n.max(1.0)
    }
    fn off_size(&self) -> f64 {
        self.off / self.n.max(1.0)
    }
}

/// Of quads, each with its wanted length.
fn measure(quads: impl Iterator<Item = ([Point2; 4], f64)>) -> Measure {
    let mut m = Measure { min: 1.0, ..Measure::default() };
    for (p, h) in quads {
        let c = Corners::new(&p);
        let s = c.min_scaled();
        m.min = m.min.min(s);
        m.sum += s;
        m.n += 1.0;
        m.off += 0.25 * c.length.iter().filter(|&&l| !(0.7 * h..=1.4 * h).contains(&l)).count() as f64;
    }
    m
}

fn quads_of(mesh: &QuadMesh) -> impl Iterator<Item = [Point2; 4]> {
    mesh.quads.iter().map(|q| q.map(|v| mesh.points[v.index()]))
}

/// What became of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// Nothing to be gained from this cavity, or no tries left.
    Hopeless,
    /// No patch fits the sides.
    Unfilled,
    /// The patch is not good enough.
    Rejected,
    /// The patch is in the mesh.
    Taken,
}

/// What is left to try for a seed.
pub(super) struct Tries {
    patches: usize,
    fills: usize,
    pub(super) tried: usize,
}

impl Tries {
    pub(super) fn new(patches: usize, fills: usize) -> Self {
        Self { patches, fills, tried: 0 }
    }

    pub(super) fn are_spent(&self) -> bool {
        self.patches == 0 || self.fills == 0
    }
}

impl Site<'_> {
    /// Tries to replace a cavity around `seed`. Returns how many patches were tried and whether one was
    /// taken; `near` receives the vertices whose surroundings changed.
    pub(super) fn improve(&mut self, seed: u32, cavity: &mut Cavity, near: &mut Vec<u32>) -> (usize, bool) {
        cavity.clear(self.mesh.n_vertices(), self.mesh.n_quads());
        if !self.add_star(cavity, seed) || !self.close(cavity) {
            self.rejected.blocked += 1;
            return (0, false);
        }
        let mut targets: Option<Vec<(u32, u32)>> = None;
        let mut saved = Saved::default();
        let mut next_target = 0;
        let mut rings = 0;
        let mut tries = Tries::new(self.task.rules.patches, FILLS);
        loop {
            match self.attempt(cavity, near, &mut tries) {
                Outcome::Taken => return (tries.tried, true),
                Outcome::Unfilled if self.push_sides(cavity, near, &mut tries) => {
                    return (tries.tried, true);
                }
                _ => {}
            }
            if tries.are_spent() {
                return (tries.tried, false);
            }
            cavity.save(&mut saved);
            let targets = targets.get_or_insert_with(|| self.search(seed));
            let mut grown = false;
            while next_target < targets.len() {
                let (v, q) = targets[next_target];
                next_target += 1;
                if cavity.inside(v) == self.mesh.valence(v) {
                    continue;
                }
                if self.add_path(cavity, q) && self.add_star(cavity, v) && self.close(cavity) {
                    grown = true;
                    break;
                }
                self.restore(cavity, &saved);
            }
            if !grown {
                let rim = cavity.rim.clone();
                let all = rim.iter().all(|&v| {
                    let room = cavity.quads.len() < self.task.rules.most_quads;
                    if room && self.is_free(v) {
                        self.add_star(cavity, v);
                    }
                    room
                });
                if rings == RINGS || !all || !self.close(cavity) {
                    self.rejected.hopeless += usize::from(tries.tried == 0);
                    return (tries.tried, false);
                }
                rings += 1;
            }
        }
    }

    /// Tries the cavity with one side pushed out by a row, for each side; true if a patch was taken. The
    /// cavity is as before otherwise.
    fn push_sides(&mut self, cavity: &mut Cavity, near: &mut Vec<u32>, tries: &mut Tries) -> bool {
        let n = cavity.rim.len();
        let corners: Vec<usize> = (0..n).filter(|&i| cavity.wanted[i] == 1).collect();
        let mut saved = Saved::default();
        cavity.save(&mut saved);
        let rim = cavity.rim.clone();
        for (k, &from) in corners.iter().enumerate() {
            let to = corners.get(k + 1).copied().unwrap_or(corners[0] + n);
            let mut all = true;
            for i in from..to {
                let (a, b) = (rim[i % n], rim[(i + 1) % n]);
                let back = |h: &u32| self.mesh.quad(h / 4)[((h + 1) & 3) as usize] == a;
                let beyond = self.mesh.star(b).iter().copied().find(|h| !cavity.has(h / 4) && back(h));
                all = all && beyond.is_some_and(|h| self.add(cavity, h / 4));
            }
            if all && self.close(cavity) && matches!(self.attempt(cavity, near, tries), Outcome::Taken) {
                return true;
            }
            self.restore(cavity, &saved);
            if tries.are_spent() {
                return false;
            }
        }
        false
    }

    /// True if a patch might have a lower potential.
    fn is_promising(&mut self, cavity: &Cavity) -> bool {
        let now = self.potential(cavity);
        now > 0 && Self::least(cavity).is_some_and(|l| l < now)
    }

    /// The nearest irregular vertices around `seed`, each with a quad that has it. `met` holds the tree of quads back to
    /// the seed.
    fn search(&mut self, seed: u32) -> Vec<(u32, u32)> {
        self.n_searches += 1;
        let now = self.n_searches;
        self.met.resize(self.mesh.n_quads(), (0, NONE));
        let mut order: Vec<u32> = self.mesh.star(seed).iter().map(|&h| h / 4).collect();
        order.iter().for_each(|&q| self.met[q as usize] = (now, NONE));
        let mut found: Vec<(u32, u32)> = Vec::new();
        let mut i = 0;
        while i < order.len() && order.len() < SEARCH && found.len() < TARGETS {
            let q = order[i];
            for v in self.mesh.quad(q) {
                if v != seed && self.is_irregular(v) && found.iter().all(|f| f.0 != v) {
                    found.push((v, q));
                }
            }
            for k in 0..4 {
                let Some(h) = self.mesh.across(q, k) else { continue };
                let o = h / 4;
                if self.met[o as usize].0 != now && !self.is_protected(o) {
                    self.met[o as usize] = (now, q);
                    order.push(o);
                }
            }
            i += 1;
        }
        found
    }

    /// Adds the quads from `q` back to the seed of the last search.
    fn add_path(&self, cavity: &mut Cavity, mut q: u32) -> bool {
        while q != NONE {
            if !self.add(cavity, q) {
                return false;
            }
            q = self.met[q as usize].1;
        }
        true
    }

    /// Fills the cavity, smooths, compares; commits if better.
    fn attempt(&mut self, cavity: &Cavity, near: &mut Vec<u32>, tries: &mut Tries) -> Outcome {
        if tries.are_spent() || !self.is_promising(cavity) {
            return Outcome::Hopeless;
        }
        // Seeds close to each other grow the same cavities.
        let key = self.key(cavity);
        if !self.failed.insert(key) {
            return Outcome::Hopeless;
        }
        tries.fills -= 1;
        let potential = self.potential(cavity);
        let samples: Vec<Point2> = cavity.rim.iter().map(|&v| self.mesh.point(v)).collect();
        let size = LinearSize::new(self.task.size, &samples);
        let filled = self.fill(cavity, potential, &size).filter(|patch| {
            let n_rim = cavity.rim.len();
            let mut valence = vec![0usize; n_rim + patch.points.len()];
            patch.quads.iter().flatten().for_each(|&v| valence[v as usize] += 1);
            let fits = valence[..n_rim].iter().zip(&cavity.wanted).all(|(&d, &k)| d == usize::from(k));
            fits && valence[n_rim..].iter().map(|&d| INNER * weight(d, 4)).sum::<u32>() < potential
        });
        let Some(patch) = filled else {
            self.rejected.unfilled += 1;
            return Outcome::Unfilled;
        };
        let mut valence = vec![0usize; cavity.rim.len() + patch.points.len()];
        patch.quads.iter().flatten().for_each(|&v| valence[v as usize] += 1);
        let after = valence[cavity.rim.len()..].iter().map(|&d| INNER * weight(d, 4)).sum::<u32>();
        if self.judge(cavity, &patch, potential - after, &samples, true, near, tries) {
            Outcome::Taken
        } else {
            Outcome::Rejected
        }
    }

    /// Relaxes the patch with what is around it, compares, and commits if it is good; true then. `gain`: how much the
    /// potential falls. `good`: the patch is nearly in shape, so that a bad one need not be relaxed to be refused.
    #[expect(clippy::too_many_arguments, reason = "two callers, all different")]
    pub(super) fn judge(
        &mut self,
        cavity: &Cavity,
        patch: &Patch,
        gain: u32,
        samples: &[Point2],
        good: bool,
        near: &mut Vec<u32>,
        tries: &mut Tries,
    ) -> bool {
        let size = LinearSize::new(self.task.size, samples);
        let mut local = self.local(cavity, patch);
        let around = self.measure_known(&local.around);
        let inside = self.measure_known(&cavity.quads);
        let n_around = local.around.len();
        let before = inside.and(&around);
        let r = &self.task.rules;
        // Irregular inner vertices that go, about: each has a potential of 2 or more.
        let n = (n_around + patch.quads.len()) as f64;
        let gone = 0.5 * f64::from(gain) / f64::from(INNER) / n;
        let least = before.mean() - r.mean_loss * gone;
        let most = before.off_size() + r.size_loss * gone;
        if good {
            let raw = self.measure(quads_of(&local.mesh).skip(n_around)).and(&around);
            if raw.mean() < least - RAW_MEAN {
                self.rejected.mean += 1;
                return false;
            }
            if raw.off_size() > most + RAW_SIZE {
                self.rejected.size += 1;
                return false;
            }
        }
        let topology = QuadTopology::new(local.mesh.n_vertices(), &local.mesh.quads);
        if topology.n_bad_edges > 0 {
            return false;
        }
        tries.patches -= 1;
        tries.tried += 1;
        let options = SmoothOptions {
            threshold: 2.0,
            rings: 0,
            laplace_sweeps: if good { 2 } else { 5 },
            sweeps: 2,
            ..SmoothOptions::default()
        };
        if good {
            finish(&mut local.mesh, &topology, &local.fixed, &size, &options);
        } else {
            smooth(&mut local.mesh, &topology, &local.fixed, &size, &options);
        }
        // What is around moves little: its sizes stay.
        let lengths = local.around.iter().map(|&q| self.lengths[q as usize]);
        let around = measure(quads_of(&local.mesh).zip(lengths));
        let now = self.measure(quads_of(&local.mesh).skip(n_around)).and(&around);
        let counter = if certify(&local.mesh.points, &local.mesh.quads).is_some()
            || now.min < before.min.min(r.min_sj)
        {
            Some(&mut self.rejected.shape)
        } else if now.mean() < least {
            Some(&mut self.rejected.mean)
        } else if now.off_size() > most {
            Some(&mut self.rejected.size)
        } else {
            None
        };
        if let Some(counter) = counter {
            *counter += 1;
            return false;
        }
        self.commit(cavity, patch, &local, near);
        true
    }

    fn fill(&self, cavity: &Cavity, potential: u32, size: &LinearSize) -> Option<Patch> {
        let mut contour = Contour::default();
        let mut hint = Hint::default();
        for &v in &cavity.rim {
            let p = self.mesh.point(v);
            let flags = if self.is_free(v) { NodeFlags::default() } else { NodeFlags::GEOMETRY };
            contour.push(p, v, size.h(p, &mut hint), flags);
        }
        contour.wanted.clone_from(&cavity.wanted);
        // An irregular vertex inside counts this much or more, and the sum must fall.
        contour.most_irregular = Some(potential.saturating_sub(1) / (INNER * weight(5, 4)));
        let task = RegionTask { contour: &contour, size, tolerance: self.task.tolerance };
        self.task.mesher.mesh(&task).ok().filter(|p| p.children.is_empty())
    }

    /// The patch and a ring of quads around it as a mesh of their own. (A second ring costs a tenth of all the time and
    /// changes nothing in the mean.)
    fn local(&self, cavity: &Cavity, patch: &Patch) -> Local {
        let at_rim = cavity.rim.iter().flat_map(|&v| self.mesh.star(v));
        let mut around: Vec<u32> = at_rim.map(|&h| h / 4).filter(|&q| !cavity.has(q)).collect();
        around.sort_unstable();
        around.dedup();
        let mut names: Vec<u32> = around.iter().flat_map(|&q| self.mesh.quad(q)).collect();
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

    fn measure(&self, quads: impl Iterator<Item = [Point2; 4]>) -> Measure {
        let mut hint = Hint::default();
        measure(quads.map(|p| (p, self.task.size.h(0.25 * (p[0] + p[1] + p[2] + p[3]), &mut hint))))
    }

    /// Of quads of the mesh, whose wanted lengths are remembered.
    fn measure_known(&mut self, quads: &[u32]) -> Measure {
        self.lengths.resize(self.mesh.n_quads(), 0.0);
        let mut hint = Hint::default();
        let corners = |q: u32| self.mesh.quad(q).map(|v| self.mesh.point(v));
        for &q in quads {
            let h = &mut self.lengths[q as usize];
            if *h == 0.0 {
                let p = corners(q);
                *h = self.task.size.h(0.25 * (p[0] + p[1] + p[2] + p[3]), &mut hint);
            }
        }
        measure(quads.iter().map(|&q| (corners(q), self.lengths[q as usize])))
    }

    /// What a cavity is made of, as a number.
    pub(super) fn key(&self, cavity: &Cavity) -> u64 {
        let mix = |x: u64| {
            let x = (x ^ x >> 31).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            (x ^ x >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9)
        };
        cavity.quads.iter().fold(0, |sum: u64, &q| {
            let [a, b, c, d] = self.mesh.quad(q).map(u64::from);
            sum.wrapping_add(mix(mix(a ^ c << 32) ^ b ^ d << 32))
        })
    }

    fn commit(&mut self, cavity: &Cavity, patch: &Patch, local: &Local, near: &mut Vec<u32>) {
        let n_rim = cavity.rim.len() as u32;
        let first = self.mesh.n_vertices() as u32;
        let name = |v: u32| if v < n_rim { cavity.rim[v as usize] } else { first + v - n_rim };
        let quads: Vec<[u32; 4]> = patch.quads.iter().map(|q| q.map(name)).collect();
        let n_old = local.names.len();
        for &q in cavity.quads.iter().chain(&local.around) {
            self.lengths[q as usize] = 0.0;
        }
        let new = self.mesh.replace(&cavity.quads, &quads, &local.mesh.points[n_old..]);
        for (i, &v) in local.names.iter().enumerate() {
            if !local.fixed[i] {
                self.mesh.set_point(v, local.mesh.points[i]);
            }
        }
        for &v in &new {
            if let Some(l) = self.of_layer.get_mut(v as usize) {
                *l = false;
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
