//! Small disks around one seed: edges turned, quads collapsed and opened, neighbouring irregular vertices merged,
//! all by one table.
//!
//! ```text
//!    o────o────o        o────o────o      rim of 4 to 10 vertices; every quadrangulation of it is known ([`disks`])
//!    │   5│5   │        │  4/ \4  │      and its gain is a sum over the rim and the inner vertices:
//!   o│    │    │o  ──▶ o│  /   \  │o     no trial mesh before the gain is known
//!    │   3│3   │        │4/     \4│
//!    o────o────o        o────o────o
//! ```
//!
//! 1. Cavities: the star of the seed, the union with the star of a neighbour (along an edge, across a quad, of all
//!    of a quad's vertices of three), two quads with an edge at or opposite the seed, three or four quads in a row
//!    around the seed.
//! 2. For each the disk of least potential. Only a lower potential than now counts; largest gains first.
//! 3. Relaxed apart from the mesh, judged and taken as a refilled cavity is.
//!
//! Covers handbook 6.3: face collapse (a star of d quads to a fan of d - 1) and open (its reverse), edge rotation,
//! side and element elimination, 3-3, 3-5 and 5-5 patterns, and boundary vertices by angle.

use super::grow::{Cavity, INNER, Site, weight};
use super::refill::Tries;
use crate::ops::{Disk, MAX_RIM, disks};
use csalf_geom::Point2;
use csalf_mesh::Patch;

/// Most quads of a small cavity.
const MOST: usize = 9;
/// Cavities of a seed whose disks are tried.
const TRIALS: usize = 2;
/// A quad count that no vertex may have.
const NEVER: u32 = u32::MAX / 64;

/// A cavity with the best disk for it.
#[derive(Clone, Copy, Debug)]
struct Choice {
    gain: u32,
    /// Index into the disks of this rim.
    disk: u32,
    quads: [u32; MOST],
    n_quads: usize,
}

/// Quads of a cavity under construction.
#[derive(Clone, Copy, Debug, Default)]
struct Few {
    quads: [u32; MOST],
    n: usize,
    full: bool,
}

impl Few {
    fn add(&mut self, q: u32) {
        if self.list().contains(&q) {
            return;
        }
        match self.quads.get_mut(self.n) {
            Some(slot) => (*slot, self.n) = (q, self.n + 1),
            None => self.full = true,
        }
    }
    fn list(&self) -> &[u32] {
        &self.quads[..self.n]
    }
}

/// Rim (counter-clockwise) and inner vertices of a small disk.
#[derive(Clone, Copy, Debug)]
struct Around {
    rim: [u32; MAX_RIM],
    /// Number of quads of the disk at each rim vertex.
    inside: [u8; MAX_RIM],
    n_rim: usize,
    inner: [u32; MOST],
    n_inner: usize,
}

impl Around {
    fn rim(&self) -> &[u32] {
        &self.rim[..self.n_rim]
    }
    fn inner(&self) -> &[u32] {
        &self.inner[..self.n_inner]
    }
}

impl Site<'_> {
    /// Replaces a small disk around `seed` by one of lower potential, if there is a good one. Returns how many were
    /// tried and whether one was taken; `near` receives the vertices whose surroundings changed.
    pub(super) fn mend(&mut self, seed: u32, cavity: &mut Cavity, near: &mut Vec<u32>) -> (usize, bool) {
        let mut found: Vec<Choice> = Vec::new();
        self.small_cavities(seed, &mut |site, few| {
            if let Some(c) = site.best_disk(seed, few) {
                found.push(c);
            }
        });
        found.sort_by(|a, b| b.gain.cmp(&a.gain).then(a.n_quads.cmp(&b.n_quads)));
        let mut tries = Tries::new(TRIALS, TRIALS);
        for c in &found {
            if tries.are_spent() {
                break;
            }
            cavity.clear(self.mesh.n_vertices(), self.mesh.n_quads());
            for &q in &c.quads[..c.n_quads] {
                cavity.add(q, self.mesh.quad(q));
            }
            let key = self.key(cavity) ^ u64::from(c.disk);
            if !self.failed.insert(key) {
                continue;
            }
            let Some(around) = self.small_rim(&c.quads[..c.n_quads]) else { continue };
            let rim = around.rim();
            let Some(disk) = disks(rim.len()).get(c.disk as usize) else { continue };
            cavity.rim.clear();
            cavity.rim.extend_from_slice(rim);
            let patch = self.patch_of(disk, &cavity.rim);
            let samples: Vec<Point2> = cavity.rim.iter().map(|&v| self.mesh.point(v)).collect();
            if self.judge(cavity, &patch, c.gain, &samples, false, near, &mut tries) {
                return (tries.tried, true);
            }
        }
        (tries.tried, false)
    }

    /// Step 1.
    fn small_cavities(&mut self, seed: u32, visit: &mut dyn FnMut(&mut Self, &Few)) {
        let star: Vec<u32> = self.mesh.star(seed).to_vec();
        let inner = self.is_free(seed);
        let union = |site: &Self, list: &[u32]| {
            let mut few = Few::default();
            for &v in list {
                site.mesh.star(v).iter().for_each(|&h| few.add(h / 4));
            }
            few
        };
        if inner {
            visit(self, &union(self, &[seed]));
        }
        for &h in &star {
            let (q, vs) = (h / 4, self.mesh.quad(h / 4));
            let at = |k: u32| vs[((h + k) & 3) as usize];
            let (next, across) = (at(1), at(2));
            if inner {
                for w in [next, across] {
                    if self.is_free(w) && self.mesh.valence(w) <= 5 {
                        visit(self, &union(self, &[seed, w]));
                    }
                }
                let threes: Vec<u32> =
                    vs.iter().copied().filter(|&v| self.is_free(v) && self.mesh.valence(v) == 3).collect();
                if threes.len() > 2 {
                    visit(self, &union(self, &threes));
                }
            }
            // Two quads that share the edge to the next vertex, or one opposite the seed.
            for k in 0..3 {
                if let Some(o) = self.mesh.across(q, (h + k) & 3) {
                    let mut few = Few::default();
                    few.add(q);
                    few.add(o / 4);
                    visit(self, &few);
                    if inner && star.len() == 3 {
                        // The star and one more.
                        let mut few = union(self, &[seed]);
                        few.add(o / 4);
                        if few.n == 4 {
                            visit(self, &few);
                        }
                    }
                }
            }
            // Fans of three and four quads around the seed.
            let mut few = Few::default();
            few.add(q);
            let mut side = h;
            for n in 2..=4 {
                // The quad beyond the edge that ends in the seed.
                let Some(o) = self.mesh.across(side / 4, (side + 3) & 3) else { break };
                if o / 4 == q {
                    break;
                }
                side = o;
                few.add(o / 4);
                if n > 2 {
                    visit(self, &few);
                }
            }
        }
    }

    /// Rim (counter-clockwise) and inner vertices of a few quads; `None` if they are no disk, too large, or may not
    /// be edited.
    fn small_rim(&self, quads: &[u32]) -> Option<Around> {
        let mut edges = [(0u32, 0u32); MAX_RIM];
        let mut n = 0;
        for &q in quads {
            let vs = self.mesh.quad(q);
            if self.is_protected(q) {
                return None;
            }
            for k in 0..4 {
                let (a, b) = (vs[k as usize], vs[((k + 1) & 3) as usize]);
                match self.mesh.across(q, k) {
                    Some(o) if quads.contains(&(o / 4)) => {
                        if self.is_kept(a, b) {
                            return None;
                        }
                    }
                    _ => {
                        *edges.get_mut(n)? = (a, b);
                        n += 1;
                    }
                }
            }
        }
        let edges = &edges[..n];
        let mut out =
            Around { rim: [0; MAX_RIM], inside: [0; MAX_RIM], n_rim: 0, inner: [0; MOST], n_inner: 0 };
        let mut v = edges.first()?.0;
        for _ in 0..n {
            if out.rim().contains(&v) {
                return None;
            }
            out.rim[out.n_rim] = v;
            out.n_rim += 1;
            v = edges.iter().find(|e| e.0 == v)?.1;
        }
        if v != out.rim[0] {
            return None;
        }
        for v in quads.iter().flat_map(|&q| self.mesh.quad(q)) {
            if let Some(i) = out.rim().iter().position(|&w| w == v) {
                out.inside[i] += 1;
            } else if !out.inner().contains(&v) {
                *out.inner.get_mut(out.n_inner)? = v;
                out.n_inner += 1;
            }
        }
        // Euler: a disk. A boundary vertex inside would be one that the boundary passes twice.
        let disk = 2 * quads.len() + 2 == n + 2 * out.n_inner;
        (disk && out.inner().iter().all(|&v| self.is_free(v))).then_some(out)
    }

    /// Step 2.
    fn best_disk(&mut self, seed: u32, few: &Few) -> Option<Choice> {
        if few.full || self.is_alone(seed, few) {
            return None;
        }
        let around = self.small_rim(few.list())?;
        let (rim, inner) = (around.rim(), around.inner());
        let n = rim.len();
        let mut now: u32 = inner.iter().map(|&v| INNER * weight(self.mesh.valence(v), 4)).sum();
        // cost[i][d]: potential of rim vertex i with d quads inside.
        let mut cost = [[NEVER; 8]; MAX_RIM];
        for (i, &v) in rim.iter().enumerate() {
            let inside = usize::from(around.inside[i]);
            let outside = self.mesh.valence(v) - inside;
            if self.is_special(v) {
                cost[i][inside.min(7)] = 0;
                continue;
            }
            let wanted = self.wanted(v);
            let (factor, least) = (self.factor(v), if self.is_free(v) { 3 } else { 1 });
            for (d, c) in cost[i].iter_mut().enumerate().skip(1) {
                if outside + d >= least {
                    *c = factor * weight(outside + d, wanted);
                }
            }
            now += factor * weight(outside + inside, wanted);
        }
        let (mut least, mut best) = (now, None);
        for (k, disk) in disks(n).iter().enumerate() {
            let mut sum: u32 = disk.inner.iter().map(|&d| INNER * weight(usize::from(d), 4)).sum();
            for (cost, &d) in cost[..n].iter().zip(&disk.rim) {
                // Costs are not negative: most disks are too dear after a few vertices.
                if sum >= least {
                    break;
                }
                sum += cost[usize::from(d).min(7)];
            }
            if sum < least {
                (least, best) = (sum, Some(k as u32));
            }
        }
        Some(Choice { gain: now - least, disk: best?, quads: few.quads, n_quads: few.n })
    }

    /// True if the seed lacks or has one quad too many and is the only such vertex of these quads, all of which are inside
    /// the material: any other disk has one, too, as the sum of wanted - d over a disk is the same for all of its meshes
    /// (handbook 4.7), so no potential can be lower.
    fn is_alone(&mut self, seed: u32, few: &Few) -> bool {
        if !self.is_free(seed) || self.mesh.valence(seed).abs_diff(4) != 1 || self.factor(seed) > INNER {
            return false;
        }
        let quads = few.list();
        quads.iter().all(|&q| {
            self.mesh.quad(q).into_iter().all(|v| v == seed || self.is_free(v) && self.mesh.valence(v) == 4)
        })
    }

    /// The disk with its inner vertices at the mean of their neighbours.
    fn patch_of(&self, disk: &Disk, rim: &[u32]) -> Patch {
        let n = rim.len();
        let centre = rim.iter().map(|&v| self.mesh.point(v)).sum::<Point2>() / n as f64;
        let mut points = vec![centre; disk.inner.len()];
        for _ in 0..4 {
            for i in 0..points.len() {
                let (mut sum, mut count) = (Point2::ZERO, 0.0);
                for q in disk.quads {
                    if let Some(k) = q.iter().position(|&v| usize::from(v) == n + i) {
                        let w = usize::from(q[(k + 1) & 3]);
                        sum += if w < n { self.mesh.point(rim[w]) } else { points[w - n] };
                        count += 1.0;
                    }
                }
                points[i] = sum / count;
            }
        }
        Patch { points, quads: disk.quads.iter().map(|q| q.map(u32::from)).collect(), ..Patch::default() }
    }
}
