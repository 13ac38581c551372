//! Growing a cavity: a disk of quads whose rim, read by connectivity, has corners and sides only.
//!
//! 1. [`Cavity::add`] counts for every vertex how many of its quads are inside.
//! 2. [`Site::close`]: a rim vertex that wants three or more quads inside (reflex), or none, draws in the
//!    quads that stand there, until there is no such vertex, or one that cannot be helped.
//! 3. [`Site::rim`] walks around; a vertex passed twice is drawn in as well.

use super::{CavityTask, Rejections};
use crate::edit::EditMesh;
use csalf_geom::angle::interior_angle;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

const NONE: u32 = u32::MAX;

/// Angles (radians) at which k and k + 1 equal quads have the same smallest sine: 120, 216, 308.6 degrees.
/// Source: handbook 2.2 (a).
const THRESHOLDS: [f64; 3] = [2.0 / 1.5 * FRAC_PI_2, 6.0 / 2.5 * FRAC_PI_2, 12.0 / 3.5 * FRAC_PI_2];

/// Within this much (radians, 12 degrees) of a threshold a boundary vertex keeps the number that it has.
/// Source: handbook 2.2 (d).
const AMBIGUOUS: f64 = 12.0 / 90.0 * FRAC_PI_2;

/// An inner vertex counts as much as this many on the boundary, where one quad more or less costs little
/// shape. Smaller: cavities trade one for the other.
pub(super) const INNER: u32 = 4;
/// Likewise one on the boundary.
const BOUNDARY: u32 = 2;
/// Likewise one at a quad that must stay. Larger: rings round, more irregular vertices further in.
pub(super) const LAYER: u32 = 14;

/// The mesh with everything that decides what may be done where.
pub(super) struct Site<'a> {
    pub(super) mesh: EditMesh<'a>,
    pub(super) task: &'a CavityTask<'a>,
    /// Edges that must stay, lower end first, sorted.
    kept: Vec<[u32; 2]>,
    /// Wanted number of quads at boundary vertices, once known; 0: not yet.
    wanted: Vec<u8>,
    /// Vertices of quads that must stay, or lay on the boundary at the start: an irregular one spoils a layer.
    pub(super) of_layer: Vec<bool>,
    /// Vertices that lie inside the material, fixed: judged by the angles of each side.
    special: Vec<bool>,
    pub(super) rejected: Rejections,
    /// Keys of cavities that were tried in vain.
    pub(super) failed: BTreeSet<u64>,
    /// Per quad: the wanted length at its centre, once known; 0: not yet.
    pub(super) lengths: Vec<f64>,
    /// Per quad: the last search that met it, and the quad that it came from.
    pub(super) met: Vec<(u32, u32)>,
    pub(super) n_searches: u32,
}

/// The cavity under construction, with counts that are cleared by the numbers of its own vertices.
#[derive(Debug, Default)]
pub(super) struct Cavity {
    pub(super) quads: Vec<u32>,
    /// Vertices of the quads, in the order of coming; those without quads inside any more stay.
    pub(super) vertices: Vec<u32>,
    inside: Vec<u8>,
    known: Vec<bool>,
    has: Vec<bool>,
    next: Vec<u32>,
    queue: Vec<u32>,
    /// The rim, counter-clockwise, and the numbers of quads wanted inside.
    pub(super) rim: Vec<u32>,
    pub(super) wanted: Vec<u8>,
}

/// What makes a closed cavity, to go back to.
#[derive(Debug, Default)]
pub(super) struct Saved {
    quads: Vec<u32>,
    rim: Vec<u32>,
    wanted: Vec<u8>,
}

impl Cavity {
    /// Empties the cavity, which then fits `n_vertices` and `n_quads`.
    pub(super) fn clear(&mut self, n_vertices: usize, n_quads: usize) {
        while let Some(q) = self.quads.pop() {
            self.has[q as usize] = false;
        }
        for v in self.vertices.drain(..) {
            self.inside[v as usize] = 0;
            self.known[v as usize] = false;
        }
        self.inside.resize(n_vertices, 0);
        self.known.resize(n_vertices, false);
        self.next.resize(n_vertices, NONE);
        self.has.resize(n_quads, false);
        self.queue.clear();
    }

    pub(super) fn save(&self, into: &mut Saved) {
        into.quads.clone_from(&self.quads);
        into.rim.clone_from(&self.rim);
        into.wanted.clone_from(&self.wanted);
    }

    pub(super) fn has(&self, q: u32) -> bool {
        self.has[q as usize]
    }

    pub(super) fn inside(&self, v: u32) -> usize {
        usize::from(self.inside[v as usize])
    }

    /// Takes a quad in; its vertices are to be looked at.
    pub(super) fn add(&mut self, q: u32, corners: [u32; 4]) {
        if std::mem::replace(&mut self.has[q as usize], true) {
            return;
        }
        self.quads.push(q);
        for v in corners {
            self.inside[v as usize] += 1;
            if !std::mem::replace(&mut self.known[v as usize], true) {
                self.vertices.push(v);
            }
            self.queue.push(v);
        }
    }
}

impl<'a> Site<'a> {
    pub(super) fn new(mesh: EditMesh<'a>, task: &'a CavityTask<'a>) -> Self {
        let (n, n_quads) = (mesh.n_vertices(), mesh.n_quads());
        let mut kept: Vec<[u32; 2]> =
            task.kept.iter().map(|e| [e[0].0.min(e[1].0), e[0].0.max(e[1].0)]).collect();
        kept.sort_unstable();
        let mut special: Vec<bool> = (0..n as u32)
            .map(|v| task.fixed.get(v as usize).copied().unwrap_or(false) && !mesh.on_boundary(v))
            .collect();
        for v in kept.iter().flatten() {
            if let Some(s) = special.get_mut(*v as usize) {
                *s = true;
            }
        }
        let mut of_layer = vec![false; n];
        for q in 0..mesh.n_quads() as u32 {
            let vs = mesh.quad(q);
            let touches = |k: usize| mesh.on_boundary(vs[k]) && mesh.on_boundary(vs[(k + 1) & 3]);
            if task.protected.get(q as usize) == Some(&true)
                || (0..4).any(|k| touches(k) && mesh.across(q, k as u32).is_none())
            {
                vs.into_iter().for_each(|v| of_layer[v as usize] = true);
            }
        }
        Self {
            mesh,
            task,
            kept,
            of_layer,
            wanted: vec![0; n],
            special,
            rejected: Rejections::default(),
            failed: BTreeSet::new(),
            // Zeros that the system hands out untouched: large meshes are mostly left alone.
            lengths: vec![0.0; n_quads],
            met: vec![(0, 0); n_quads],
            n_searches: 0,
        }
    }

    pub(super) fn is_special(&self, v: u32) -> bool {
        self.special.get(v as usize).copied().unwrap_or(false)
    }

    /// What the weight of `v` counts: most on a layer, least on the boundary, where one quad more or less costs little
    /// shape.
    pub(super) fn factor(&self, v: u32) -> u32 {
        if !self.is_free(v) {
            BOUNDARY
        } else if self.of_layer.get(v as usize).copied().unwrap_or(false) {
            LAYER
        } else {
            INNER
        }
    }

    /// True if the edge must stay.
    pub(super) fn is_kept(&self, a: u32, b: u32) -> bool {
        !self.is_free(a) && !self.is_free(b) && self.kept.binary_search(&[a.min(b), a.max(b)]).is_ok()
    }

    /// True if `v` may move: neither boundary nor fixed.
    pub(super) fn is_free(&self, v: u32) -> bool {
        !self.mesh.on_boundary(v) && !self.is_special(v)
    }

    /// 0 for a vertex with the number of quads that it wants, else 1 + the square of the difference.
    pub(super) fn weight(&mut self, v: u32) -> u32 {
        let d = self.mesh.valence(v);
        if d == 0 || self.is_special(v) {
            return 0;
        }
        weight(d, self.wanted(v))
    }

    /// True if `v` has a number of quads that it does not want.
    pub(super) fn is_irregular(&mut self, v: u32) -> bool {
        if !self.mesh.on_boundary(v) && self.mesh.valence(v) == 4 {
            return false;
        }
        self.weight(v) > 0
    }

    /// Number of quads that `v`, which is not special, should have.
    pub(super) fn wanted(&mut self, v: u32) -> usize {
        if !self.mesh.on_boundary(v) {
            return 4;
        }
        let known = self.wanted[v as usize];
        if known > 0 {
            return usize::from(known);
        }
        let w = self.wanted_on_boundary(v);
        self.wanted[v as usize] = w as u8;
        w
    }

    fn wanted_on_boundary(&self, v: u32) -> usize {
        let d = self.mesh.valence(v);
        let (mut before, mut after, mut n_out) = (None, None, 0);
        for &h in self.mesh.star(v) {
            let (q, k) = (h / 4, h & 3);
            let vs = self.mesh.quad(q);
            if self.mesh.across(q, k).is_none() {
                after = Some(vs[((k + 1) & 3) as usize]);
                n_out += 1;
            }
            if self.mesh.across(q, (k + 3) & 3).is_none() {
                before = Some(vs[((k + 3) & 3) as usize]);
            }
        }
        // Where the boundary passes twice there is no telling: as it is.
        let (Some(a), Some(c), 1) = (before, after, n_out) else { return d.clamp(1, 250) };
        let theta = interior_angle(self.mesh.point(a), self.mesh.point(v), self.mesh.point(c));
        let of = |t: f64| 1 + THRESHOLDS.iter().filter(|&&x| t > x).count();
        let (low, high) = (of(theta - AMBIGUOUS), of(theta + AMBIGUOUS));
        if (low..=high).contains(&d) { d } else { of(theta) }
    }

    /// Number of quads wanted inside the cavity at rim vertex `v`.
    fn wanted_inside(&mut self, cavity: &Cavity, v: u32) -> i32 {
        let d = self.mesh.valence(v);
        let outside = (d - cavity.inside(v)) as i32;
        if !self.is_special(v) {
            return self.wanted(v) as i32 - outside;
        }
        // The angle of the quads inside; the vertex will not move.
        let mut theta = 0.0;
        for &h in self.mesh.star(v).iter().filter(|&&h| cavity.has(h / 4)) {
            let vs = self.mesh.quad(h / 4);
            let at = |k: u32| self.mesh.point(vs[((h + k) & 3) as usize]);
            theta += interior_angle(at(3), at(0), at(1));
        }
        1 + THRESHOLDS.iter().filter(|&&x| theta > x).count() as i32
    }

    /// Takes a quad in, if it may be.
    pub(super) fn add(&self, cavity: &mut Cavity, q: u32) -> bool {
        if cavity.has(q) {
            return true;
        }
        let full = cavity.quads.len() >= self.task.rules.most_quads;
        if full || self.is_protected(q) {
            return false;
        }
        cavity.add(q, self.mesh.quad(q));
        true
    }

    /// True if quad `q` must stay.
    pub(super) fn is_protected(&self, q: u32) -> bool {
        self.task.protected.get(q as usize).copied().unwrap_or(false)
    }

    /// Takes all quads at `v` in that may be edited; false if there are none, or too many in all.
    pub(super) fn add_star(&self, cavity: &mut Cavity, v: u32) -> bool {
        let n = cavity.quads.len();
        let open = self.mesh.star(v).iter().map(|&h| h / 4).filter(|&q| !self.is_protected(q));
        let mut any = false;
        for q in open {
            any = true;
            if !self.add(cavity, q) {
                return false;
            }
        }
        any && (cavity.quads.len() > n || cavity.inside(v) == self.mesh.valence(v))
    }

    /// Back to a cavity that was closed, in the mesh as it was then.
    pub(super) fn restore(&self, cavity: &mut Cavity, saved: &Saved) {
        cavity.clear(self.mesh.n_vertices(), self.mesh.n_quads());
        for &q in &saved.quads {
            cavity.add(q, self.mesh.quad(q));
        }
        cavity.queue.clear();
        cavity.rim.clone_from(&saved.rim);
        cavity.wanted.clone_from(&saved.wanted);
    }

    /// Makes the cavity convex and finds its rim; false if that cannot be. The cavity then holds whatever
    /// was tried.
    pub(super) fn close(&mut self, cavity: &mut Cavity) -> bool {
        loop {
            while let Some(v) = cavity.queue.pop() {
                if !self.settle(cavity, v) {
                    return false;
                }
            }
            match self.rim(cavity) {
                Ok(true) => return true,
                Ok(false) => return false,
                Err(pinched) => {
                    if !self.is_free(pinched) || !self.add_star(cavity, pinched) {
                        return false;
                    }
                }
            }
        }
    }

    /// Draws in what a vertex of the cavity needs to be a corner or on a side; false if that cannot be.
    fn settle(&mut self, cavity: &mut Cavity, v: u32) -> bool {
        let (n_in, d) = (cavity.inside(v), self.mesh.valence(v));
        if n_in == 0 || n_in == d && self.is_free(v) {
            return true;
        }
        if n_in == d && !self.mesh.on_boundary(v) {
            // A fixed vertex inside cannot be kept by a pattern.
            return false;
        }
        match self.wanted_inside(cavity, v) {
            1 | 2 => true,
            k if self.is_free(v) || k <= 0 && self.mesh.on_boundary(v) && !self.is_special(v) => {
                self.add_star(cavity, v)
            }
            _ => false,
        }
    }

    /// Walks around the cavity. `Ok(false)`: it is no disk, or an edge inside must stay; `Err(v)`: the rim
    /// passes v twice.
    fn rim(&mut self, cavity: &mut Cavity) -> Result<bool, u32> {
        for &v in &cavity.vertices {
            cavity.next[v as usize] = NONE;
        }
        let mut n_rim = 0;
        let mut first = NONE;
        for i in 0..cavity.quads.len() {
            let q = cavity.quads[i];
            let vs = self.mesh.quad(q);
            for k in 0..4 {
                let (a, b) = (vs[k as usize], vs[((k + 1) & 3) as usize]);
                let (d, n_in) = (self.mesh.valence(a), cavity.inside(a));
                if d == n_in && !self.mesh.on_boundary(a) {
                    continue;
                }
                match self.mesh.across(q, k) {
                    Some(h) if cavity.has(h / 4) => {
                        if self.is_kept(a, b) {
                            return Ok(false);
                        }
                    }
                    _ => {
                        if cavity.next[a as usize] != NONE {
                            return Err(a);
                        }
                        cavity.next[a as usize] = b;
                        n_rim += 1;
                        if first == NONE {
                            first = a;
                        }
                    }
                }
            }
        }
        cavity.rim.clear();
        let mut v = first;
        while v != NONE && cavity.rim.len() < n_rim {
            cavity.rim.push(v);
            v = cavity.next[v as usize];
            if v == first {
                break;
            }
        }
        if v != first || cavity.rim.len() != n_rim || n_rim < 4 {
            return Ok(false);
        }
        cavity.wanted.clear();
        for i in 0..cavity.rim.len() {
            let k = self.wanted_inside(cavity, cavity.rim[i]);
            if !(1..=2).contains(&k) {
                return Ok(false);
            }
            cavity.wanted.push(k as u8);
        }
        Ok(true)
    }

    /// Sum of the weights of what a patch would make regular: irregular vertices inside, and rim vertices with
    /// another number of quads inside than they want.
    pub(super) fn potential(&mut self, cavity: &Cavity) -> u32 {
        let mut sum = 0;
        for &v in &cavity.vertices {
            let n_in = cavity.inside(v);
            if n_in == self.mesh.valence(v) && !self.mesh.on_boundary(v) && n_in > 0 {
                sum += INNER * weight(n_in, 4);
            }
        }
        for (&v, &k) in cavity.rim.iter().zip(&cavity.wanted) {
            sum += self.factor(v) * weight(cavity.inside(v), usize::from(k));
        }
        sum
    }

    /// The least potential that a patch of the cavity's corners can have; `None` if there are too many.
    pub(super) fn least(cavity: &Cavity) -> Option<u32> {
        let n = cavity.rim.len();
        let mut corners = [0usize; 7];
        let mut m = 0;
        for (i, &k) in cavity.wanted.iter().enumerate() {
            if k == 1 {
                *corners.get_mut(m)? = i;
                m += 1;
            }
        }
        match m {
            4 => {
                let side = |k: usize| corners[k + 1] - corners[k];
                let last = n - corners[3] + corners[0];
                Some(if side(0) == side(2) && side(1) == last { 0 } else { 4 * INNER })
            }
            0..=3 => Some(2 * INNER * (4 - m as u32)),
            5 | 6 => Some(2 * INNER * (m as u32 - 4)),
            _ => None,
        }
    }
}

/// 0 if a vertex has what it wants, else 1 + the square of the difference.
pub(super) fn weight(has: usize, wants: usize) -> u32 {
    let e = has.abs_diff(wants) as u32;
    if e == 0 { 0 } else { 1 + e * e }
}
