//! One ring around one loop, built aside: nothing outside changes until the driver commits it.
//!
//! ```text
//!   loop ──▶ angles, spacing ──▶ thickness ──▶ fronts ──▶ peel or demote adjacent corners
//!        ──▶ roles, ring (connectivity) ──▶ positions ──▶ relax ──▶ own tests ──▶ candidate
//! ```
//!
//! Names in a candidate: ids below [`NEW`] are nodes that exist, `NEW + k` is new point k. Source: handbook 2 and 3.

use crate::Front;
use crate::classify::{View, classify, decide};
use crate::evaluate::{self, Stop};
use crate::laws::{Thickness, isotropic};
use crate::place::{PavingRules, Site, harmonic};
use crate::relax;
use crate::ring::{NoRing, Ring, Role, settle};
use csalf_geom::Point2;
use csalf_geom::angle::interior_angle;
use csalf_mesh::quality::scaled_jacobian;
use csalf_mesh::validate::is_strictly_convex;
use csalf_sizemap::{Hint, SizeField};
use std::f64::consts::PI;

/// First name of new points.
pub(crate) const NEW: u32 = 1 << 31;

/// A front as the driver keeps it: one entry per occurrence in all lists.
#[derive(Clone, Debug, Default)]
pub(crate) struct LoopState {
    /// Node ids.
    pub(crate) nodes: Vec<u32>,
    /// Where they are.
    pub(crate) points: Vec<Point2>,
    /// Ring quads already at each occurrence.
    pub(crate) below: Vec<u8>,
    /// Edge i → i+1 may be covered.
    pub(crate) open: Vec<bool>,
    /// Nodes of the input.
    pub(crate) geometry: Vec<bool>,
}

/// How a ring is to be built.
#[derive(Clone, Copy)]
pub(crate) struct Order<'a> {
    pub(crate) thickness: Thickness,
    /// Asked for by the user: exact thickness, no relaxation, milder tests.
    pub(crate) user: bool,
    /// Only as thick as wanted, all around.
    pub(crate) whole: bool,
    pub(crate) rules: PavingRules,
    pub(crate) field: &'a dyn SizeField,
    /// Upper bounds of the thickness, one per occurrence; far below the wanted one the node is blocked.
    pub(crate) caps: Option<&'a [f64]>,
    /// Edges that must not be covered.
    pub(crate) banned: Option<&'a [bool]>,
}

/// A ring that may be committed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Candidate {
    pub(crate) points: Vec<Point2>,
    pub(crate) quads: Vec<[u32; 4]>,
    /// Occurrence of the old loop that each quad stands on.
    pub(crate) quad_at: Vec<u32>,
    pub(crate) next: LoopState,
    /// Occurrence of the old loop that each node of the new loop came from.
    pub(crate) origin: Vec<u32>,
    /// Every open edge is covered.
    pub(crate) full: bool,
    /// Largest relative deviation from the wanted thickness.
    pub(crate) thickness_error: f64,
}

/// What a ring failed by, and the occurrences where.
#[derive(Clone, Debug)]
pub(crate) struct Failure {
    pub(crate) stop: Stop,
    pub(crate) at: Vec<u32>,
}

impl From<Stop> for Failure {
    fn from(stop: Stop) -> Self {
        Self { stop, at: Vec::new() }
    }
}

/// Longest run of peeled corner pairs in one ring: more is a finger that the subdivider fills as well.
const MAX_PEELS: usize = 4;

/// A ring by rule is nowhere thinner than this share of the wanted thickness.
const THINNEST: f64 = 0.3;

/// Working copy of a loop while fronts are chosen.
struct Work {
    s: LoopState,
    /// Occurrence of the driver's loop.
    at: Vec<u32>,
    theta: Vec<f64>,
    spacing: Vec<f64>,
    t: Vec<f64>,
    /// Thickness before any cap.
    wanted: Vec<f64>,
    fronts: Vec<Front>,
    banned: Vec<bool>,
    peeled: Vec<([u32; 4], u32)>,
}

impl Work {
    fn new(state: &LoopState, order: &Order<'_>) -> Self {
        let n = state.nodes.len();
        let mut w = Self {
            s: state.clone(),
            at: (0..n as u32).collect(),
            theta: Vec::new(),
            spacing: Vec::new(),
            t: Vec::new(),
            wanted: Vec::new(),
            fronts: Vec::new(),
            banned: order.banned.map_or_else(|| vec![false; n], <[bool]>::to_vec),
            peeled: Vec::new(),
        };
        w.measure(order);
        if let Some(caps) = order.caps {
            for (i, &cap) in caps.iter().enumerate() {
                if cap < THINNEST * w.t[i] {
                    w.banned[i] = true;
                    w.banned[(i + n - 1) % n] = true;
                }
                w.t[i] = w.t[i].min(cap.max(THINNEST * w.t[i]));
            }
        }
        if !order.user && order.rules == PavingRules::Corrected {
            w.taper();
        }
        w
    }

    fn n(&self) -> usize {
        self.s.nodes.len()
    }

    fn around(&self, i: usize) -> (usize, usize) {
        let n = self.n();
        (if i == 0 { n - 1 } else { i - 1 }, if i + 1 == n { 0 } else { i + 1 })
    }

    /// Angles, spacing, thickness and fronts of all nodes.
    fn measure(&mut self, order: &Order<'_>) {
        let n = self.n();
        self.theta.clear();
        self.spacing.clear();
        for i in 0..n {
            let (a, c) = self.around(i);
            let p = &self.s.points;
            self.theta.push(if self.s.nodes[a] == self.s.nodes[c] {
                2.0 * PI
            } else {
                interior_angle(p[a], p[i], p[c])
            });
            self.spacing.push(0.5 * (p[a].distance(p[i]) + p[i].distance(p[c])));
        }
        let turn: Vec<f64> =
            self.theta.iter().map(|th| if (th - PI).abs() < 0.9 { th - PI } else { 0.0 }).collect();
        // Void on the other side that bulges nowhere inward: a hole.
        let convex = self.theta.iter().all(|th| *th > PI - 0.1);
        self.t = match order.thickness {
            Thickness::Fixed(t) => vec![t; n],
            Thickness::Isotropic(factor) => {
                let mut hint = Hint::default();
                let mut t: Vec<f64> = (0..n)
                    .map(|i| {
                        let (a, c) = self.around(i);
                        let phi = 0.25 * (turn[a] + 2.0 * turn[i] + turn[c]);
                        let iso = factor * isotropic(self.spacing[i], phi);
                        match (order.rules, order.user) {
                            (PavingRules::Paper, _) => {
                                let mut g = |k: usize| order.field.h(self.s.points[k], &mut hint);
                                harmonic(g(a), g(i), g(c))
                            }
                            (_, true) => iso,
                            _ => {
                                let h = order.field.h(self.s.points[i], &mut hint);
                                let t = iso * towards(h / iso);
                                if convex && phi > 0.0 {
                                    t.min(most_thick(self.spacing[i], phi, h))
                                } else {
                                    t
                                }
                            }
                        }
                    })
                    .collect();
                if order.rules == PavingRules::Corrected {
                    relax::smooth_thickness(&mut t, &vec![true; n]);
                }
                t
            }
        };
        self.wanted.clone_from(&self.t);
        let smooth: Vec<bool> = (0..n)
            .map(|i| {
                let (a, c) = self.around(i);
                let x = self.theta[i] - PI;
                let same = [self.theta[a] - PI, self.theta[c] - PI]
                    .into_iter()
                    .map(|u| u * x.signum())
                    .fold(f64::NEG_INFINITY, f64::max);
                x.abs() < 20f64.to_radians() || (x.abs() < 50f64.to_radians() && x.abs() <= 1.5 * same)
            })
            .collect();
        self.fronts = (0..n).map(|i| self.front(i, smooth[i])).collect();
    }

    fn front(&self, i: usize, smooth: bool) -> Front {
        let view = View {
            theta: self.theta[i],
            below: self.s.below[i],
            geometry: self.s.geometry[i],
            smooth,
            rho: self.t[i] / self.spacing[i],
        };
        let choice = classify(&view);
        let n = self.n();
        if choice.rival.is_none() || n < 7 {
            return choice.front;
        }
        let p = std::array::from_fn(|k| self.s.points[(i + n + k - 3) % n]);
        decide(choice, &p, self.t[i])
    }

    /// Lets the thickness grow by no more than 0.3 per length along the loop, both ways round, twice: a cap thins
    /// its neighbours, it never jumps.
    fn taper(&mut self) {
        const SLOPE: f64 = 0.3;
        let n = self.n();
        for k in 0..2 * n {
            let (i, j) = (k % n, (k + 1) % n);
            self.t[j] = self.t[j].min(self.t[i] + SLOPE * self.spacing[j]);
        }
        for k in (0..2 * n).rev() {
            let (i, j) = (k % n, (k + 1) % n);
            self.t[i] = self.t[i].min(self.t[j] + SLOPE * self.spacing[i]);
        }
    }

    /// Corner nodes i and i+1 whose three edges may all be covered.
    fn corner_pair(&self) -> Option<usize> {
        let n = self.n();
        let open = |i: usize| self.s.open[i] && !self.banned[i];
        (0..n)
            .filter(|&i| {
                let (a, c) = self.around(i);
                self.fronts[i].is_corner() && self.fronts[c].is_corner() && open(a) && open(i) && open(c)
            })
            .min_by(|&i, &j| {
                let sum = |i: usize| self.theta[i] + self.theta[self.around(i).1];
                sum(i).total_cmp(&sum(j)).then(i.cmp(&j))
            })
    }

    /// Peels the pair (handbook 2.4), or makes the blunter of the two flat.
    fn part_corners(&mut self, order: &Order<'_>) {
        while let Some(i) = self.corner_pair() {
            let (x, j) = self.around(i);
            let (_, c) = self.around(j);
            let q = [x, i, j, c];
            let corners = q.map(|k| self.s.points[k]);
            let good = is_strictly_convex(&corners) && scaled_jacobian::value(&corners) >= 0.3;
            if good && self.n() >= 8 && self.peeled.len() < MAX_PEELS && !order.user {
                self.peeled.push((q.map(|k| self.s.nodes[k]), self.at[i]));
                for k in [x, c] {
                    self.s.below[k] += 1;
                    // From now on an angle inside the ring, not of the part.
                    self.s.geometry[k] = false;
                }
                let mut gone = [i, j];
                gone.sort_unstable();
                for k in [gone[1], gone[0]] {
                    self.s.nodes.remove(k);
                    self.s.points.remove(k);
                    self.s.below.remove(k);
                    self.s.geometry.remove(k);
                    self.s.open.remove(k);
                    self.banned.remove(k);
                    self.at.remove(k);
                }
                self.measure(order);
            } else if !good && self.theta[i].max(self.theta[j]) > 100f64.to_radians() {
                let k = if self.theta[i] > self.theta[j] { i } else { j };
                self.fronts[k] = Front::Flat;
            } else {
                // A finger too narrow for a layer: both stay on the new loop.
                self.fronts[i] = Front::Acute;
                self.fronts[j] = Front::Acute;
            }
        }
    }
}

/// Factor by which a default layer leaves its isotropic thickness towards the wanted size; none within 25 %, at
/// most 0.7 to 1.4 (handbook 1.1).
fn towards(ratio: f64) -> f64 {
    if ratio > 1.25 { (ratio / 1.25).min(1.4) } else { (ratio / 0.8).clamp(0.7, 1.0) }
}

/// Edges of a front by rule are at most this many wanted edges long, as far as its ring need not be thinner than
/// [`THIN`] for it. (Measured on a plate with 64 holes: .95 of the boundary with a regular first ring against .91.)
const LONG: f64 = 1.36;
/// See [`LONG`], in wanted edges.
const THIN: f64 = 0.74;

/// Most that a ring by rule may be thick on an edge of length `s`, where the loop turns away from the material by `turn`
/// per node and edges shall be `h` long: the edges of its front are s + t turn.
fn most_thick(s: f64, turn: f64, h: f64) -> f64 {
    ((LONG * h - s) / turn).max(THIN * h)
}

/// Builds a ring around `state` and tests its quads; `all` holds the points of existing nodes by id.
pub(crate) fn build(state: &LoopState, order: &Order<'_>, all: &[Point2]) -> Result<Candidate, Failure> {
    if state.nodes.len() < 4 {
        return Err(Stop::Short.into());
    }
    let mut w = Work::new(state, order);
    if order.whole && w.t.iter().zip(&w.wanted).any(|(t, wanted)| *t < 0.95 * wanted) {
        return Err(Stop::Gap.into());
    }
    w.part_corners(order);
    let mut cover: Vec<bool> = w.s.open.iter().zip(&w.banned).map(|(o, b)| *o && !b).collect();
    let roles = chains(&w, &mut cover)?;
    let ring = Ring::new(&roles).map_err(|e| match e {
        NoRing::AdjacentCorners(_) | NoRing::Pinched => Stop::Narrow,
        NoRing::Nothing => Stop::Short,
    })?;
    if ring.new_loop.len() < 4 {
        return Err(Stop::Short.into());
    }
    let points = positions(&w, &roles, &ring, order);
    let out = assemble(&w, &ring, &cover, points);
    evaluate::own_quads(&out, all, order.user)?;
    evaluate::angle_sums(&ring, &w.s.points, &out.points).map_err(|at| Failure {
        stop: Stop::Folded,
        at: at.into_iter().map(|i| w.at[i as usize]).collect(),
    })?;
    Ok(out)
}

/// Roles under partial cover: chains of fewer than three edges are given up, and so is the ring if less than half
/// of the loop is left (handbook 2.7).
fn chains(w: &Work, cover: &mut [bool]) -> Result<Vec<Role>, Stop> {
    let n = w.n();
    let room = |i: usize| w.theta[i] >= 135f64.to_radians();
    let mut roles = settle(&w.fronts, cover, room);
    if cover.iter().all(|&c| c) {
        return Ok(roles);
    }
    for i in 0..n {
        if roles[i] == Role::Start {
            let length = (0..n).take_while(|k| cover[(i + k) % n]).count();
            if length < 3 {
                (0..length).for_each(|k| cover[(i + k) % n] = false);
            }
        }
    }
    roles = settle(&w.fronts, cover, room);
    let covered = cover.iter().filter(|&&c| c).count();
    if 2 * covered < n { Err(Stop::LittleLeft) } else { Ok(roles) }
}

fn positions(w: &Work, roles: &[Role], ring: &Ring, order: &Order<'_>) -> Vec<Point2> {
    let n = w.n();
    let p = &w.s.points;
    let site = |i: usize| {
        let (a, c) = w.around(i);
        Site { a: p[a], b: p[i], c: p[c], theta: w.theta[i], t: w.t[i] }
    };
    let mut out = vec![Point2::NAN; ring.n_new];
    let mut flat: Vec<Point2> = vec![Point2::ZERO; n];
    let mut free = vec![false; n];
    for i in 0..n {
        let s = site(i);
        let mut put = |m: usize, q: Point2| {
            let k = ring.rays[ring.ray_start[i] as usize + m] as usize;
            if out[k].is_nan() {
                out[k] = q;
            }
        };
        match roles[i] {
            Role::Blocked | Role::Corner => {}
            Role::Start => put(0, s.start()),
            Role::End => put(0, s.end()),
            Role::Flat => {
                flat[i] = s.flat();
                free[i] = w.fronts[i] == Front::Flat && (s.theta - PI).abs() < 0.6;
                put(0, flat[i]);
            }
            Role::RightReversal => {
                s.right_reversal(order.rules).into_iter().enumerate().for_each(|(m, q)| put(m, q));
            }
            Role::Reversal => s.reversal(order.rules).into_iter().enumerate().for_each(|(m, q)| put(m, q)),
        }
    }
    if order.rules == PavingRules::Paper {
        return out;
    }
    if !order.user {
        // Only runs of flat nodes relax: a node beside another kind keeps its ray.
        let run: Vec<bool> = (0..n)
            .map(|i| {
                let (a, c) = w.around(i);
                free[a] && free[i] && free[c]
            })
            .collect();
        relax::smooth_directions(p, &mut flat, &run);
        for i in (0..n).filter(|&i| run[i]) {
            out[ring.rays[ring.ray_start[i] as usize] as usize] = flat[i];
        }
    }
    // Corners last: they own the node that their neighbours share. Two corners that share one meet half way.
    let mut owner_of: Vec<(u32, Point2)> = Vec::new();
    for i in (0..n).filter(|&i| roles[i] == Role::Corner) {
        let before = w.around(i).0;
        let k = ring.rays[ring.ray_start[before + 1] as usize - 1];
        let s = site(i);
        let q = if matches!(order.thickness, Thickness::Fixed(_)) { s.flat() } else { s.corner() };
        owner_of.push((k, q));
    }
    owner_of.sort_by_key(|o| o.0);
    for shared in owner_of.chunk_by(|a, b| a.0 == b.0) {
        let sum: Point2 = shared.iter().map(|o| o.1).sum();
        out[shared[0].0 as usize] = sum / shared.len() as f64;
    }
    out
}

fn assemble(w: &Work, ring: &Ring, cover: &[bool], points: Vec<Point2>) -> Candidate {
    let n = w.n();
    let id = |v: u32| if (v as usize) < n { w.s.nodes[v as usize] } else { NEW + (v - n as u32) };
    let mut out = Candidate { points, ..Candidate::default() };
    for (q, at) in &w.peeled {
        out.quads.push(*q);
        out.quad_at.push(*at);
    }
    let mut count = vec![0u8; n + ring.n_new];
    let mut error = 0.0f64;
    for (q, &i) in ring.quads.iter().zip(&ring.quad_node) {
        out.quads.push(q.map(id));
        out.quad_at.push(w.at[i as usize]);
        for v in q {
            count[*v as usize] = count[*v as usize].saturating_add(1);
        }
    }
    // Nodes with three and more quads are shared at corners: no edge of theirs tells the thickness.
    for (q, &i) in ring.quads.iter().zip(&ring.quad_node) {
        if q[0] != i || (q[1] as usize) >= n || (q[2] as usize) < n {
            continue;
        }
        let (a, b) = (w.s.points[q[0] as usize], w.s.points[q[1] as usize]);
        let up = (b - a).normalize_or_zero().perp();
        for (v, at) in [(q[3], q[0]), (q[2], q[1])] {
            if count[v as usize] < 3 {
                let d = up.dot(out.points[v as usize - n] - a);
                error = error.max((d / w.wanted[at as usize] - 1.0).abs());
            }
        }
    }
    out.thickness_error = error;
    let mut owner = vec![0u32; ring.n_new];
    for i in (0..n).rev() {
        for v in ring.rays_of(i) {
            owner[v as usize - n] = i as u32;
        }
    }
    for &v in &ring.new_loop {
        let old = (v as usize) < n;
        let from = if old { v } else { owner[v as usize - n] };
        out.origin.push(w.at[from as usize]);
        out.next.nodes.push(id(v));
        out.next.points.push(if old { w.s.points[v as usize] } else { out.points[v as usize - n] });
        out.next.below.push(count[v as usize] + if old { w.s.below[v as usize] } else { 0 });
        out.next.geometry.push(old && w.s.geometry[v as usize]);
    }
    let m = ring.new_loop.len();
    let is_new = |k: usize| ring.new_loop[k % m] as usize >= n;
    out.next.open = (0..m).map(|k| is_new(k) && is_new(k + 1)).collect();
    out.full = cover.iter().all(|&c| c);
    out
}

/// The ring around an isolated point, the first ray along `tangent` (a unit vector).
pub(crate) fn build_point(id: u32, p: Point2, t: f64, tangent: Point2) -> Candidate {
    let ring = Ring::around_point();
    let points: Vec<Point2> = (0..8)
        .map(|k| {
            let l = if k % 2 == 0 { t } else { t * std::f64::consts::SQRT_2 };
            p + csalf_geom::angle::rotated(tangent, -f64::from(k) * PI / 4.0) * l
        })
        .collect();
    let name = |v: u32| if v == 0 { id } else { NEW + v - 1 };
    Candidate {
        quads: ring.quads.iter().map(|q| q.map(name)).collect(),
        quad_at: vec![0; 4],
        next: LoopState {
            nodes: ring.new_loop.iter().map(|&v| name(v)).collect(),
            points: points.clone(),
            below: (0..8).map(|k| if k % 2 == 0 { 2 } else { 1 }).collect(),
            open: vec![true; 8],
            geometry: vec![false; 8],
        },
        points,
        origin: vec![0; 8],
        full: true,
        thickness_error: 0.0,
    }
}
