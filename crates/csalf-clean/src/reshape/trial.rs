//! Candidates for one seed: rated, laid out in a copy of what is around, compared.

use super::cavity::{Cavity, around};
use super::{POOR, ReshapeTask};
use crate::ops::{Disk, Edit, Site, disks};
use crate::smooth::{
    DOUBLINGS, Effort, SmoothOptions, TRIAL_ITERATIONS, least_sine, lift_by, untangle_with, worth,
};
use csalf_geom::angle::interior_angle;
use csalf_geom::{Point2, VertexId};
use csalf_mesh::quality::{Corners, FLAT};
use csalf_mesh::{QuadMesh, QuadTopology};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Rings of quads around a cavity that may move with it.
const RINGS: usize = 2;
/// No quad gets more than this of a straight angle.
const WIDEST: f64 = 0.97 * PI;
/// Rings that reach from anywhere in such a copy to everywhere.
const WHOLE: usize = 12;
/// What an inner vertex counts beside its valence.
const INNER: f64 = 0.02;
/// What is worth more than this is all the same.
const ENOUGH: f64 = 1.2 * POOR;
/// A gain, and no loss: factors between worths.
const GAIN: f64 = 1.05;
/// See [`GAIN`].
const EQUAL: f64 = 0.99;
/// A layout whose smallest sine is below this part of the smallest before is given up half-way. *Arbitrary.*
const BEHIND: f64 = 0.6;

/// A change that was found good.
#[derive(Clone, Debug)]
pub(super) struct Change {
    pub(super) edit: Edit,
    /// Vertices that moved, and where to.
    pub(super) moved: Vec<(u32, Point2)>,
    /// All vertices that took part.
    pub(super) touched: Vec<u32>,
}

struct Candidate {
    cost: f64,
    cavity: usize,
    disk: usize,
}

/// What came of a seed.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// Layouts tried.
    pub(super) tried: usize,
    /// Some were not, as they share a vertex with those `taken`.
    pub(super) blocked: bool,
    /// The best improvement.
    pub(super) change: Option<Change>,
}

/// The best change at quad `seed` out of at most `most` that share no vertex with those `taken`.
pub(super) fn best(
    site: &Site<'_>,
    protected: &[bool],
    taken: &[bool],
    seed: u32,
    most: usize,
    task: &ReshapeTask<'_>,
) -> Found {
    let mut out = Found::default();
    let mut places: Vec<(Cavity, Local, Rank)> = Vec::new();
    let mut list: Vec<Candidate> = Vec::new();
    for cavity in around(site, protected, seed) {
        let local = Local::new(site, &cavity);
        if local.names.iter().any(|&v| taken[v as usize]) {
            out.blocked = true;
            continue;
        }
        rate(site, &cavity, places.len(), &mut list);
        let before = local.before(site, &cavity);
        places.push((cavity, local, before));
    }
    list.sort_unstable_by(|a, b| {
        a.cost.total_cmp(&b.cost).then(a.cavity.cmp(&b.cavity)).then(a.disk.cmp(&b.disk))
    });
    let mut seen: Vec<u64> = Vec::new();
    let mut best: Option<Rank> = None;
    for Candidate { cavity, disk, .. } in list {
        if out.tried == most {
            break;
        }
        let (cavity, local, before) = &places[cavity];
        let Some(disk) = disks(cavity.rim.len()).get(disk) else { continue };
        let key = key(site, cavity, disk);
        if seen.contains(&key) {
            continue;
        }
        seen.push(key);
        out.tried += 1;
        if let Some((after, change)) = local.solve(site, cavity, disk, before, task)
            && after.is_better(before)
            && best.as_ref().is_none_or(|b| after.is_better(b))
        {
            let done = after.worths.first().is_none_or(|&s| s >= POOR);
            (best, out.change) = (Some(after), Some(change));
            if done {
                break;
            }
        }
    }
    out
}

/// How good a place is.
struct Rank {
    /// What quads are worth, ascending, as far as it is not enough.
    worths: Vec<f64>,
    /// The smallest sine of a corner, at most [`ENOUGH`].
    sine: f64,
}

impl Rank {
    fn of(quads: impl Iterator<Item = [Point2; 4]>) -> Self {
        let mut out = Self { worths: Vec::new(), sine: ENOUGH };
        for p in quads {
            let worth = worth(&p);
            if worth < ENOUGH {
                out.worths.push(worth);
                out.sine = out.sine.min(least_sine(&p));
            }
        }
        out.worths.sort_unstable_by(f64::total_cmp);
        out
    }

    /// True if the first clear difference of the worths is a gain, and the smallest sine does not fall.
    fn is_better(&self, before: &Self) -> bool {
        if self.sine < EQUAL * before.sine {
            return false;
        }
        let at = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(ENOUGH);
        for i in 0..self.worths.len().max(before.worths.len()) {
            let (a, b) = (at(&self.worths, i), at(&before.worths, i));
            if a > GAIN * b {
                return true;
            }
            if a < EQUAL * b {
                return false;
            }
        }
        false
    }
}

/// Adds the disks that fit the rim of a cavity, each with its cost: how far the angles of the quads will be from right ones.
fn rate(site: &Site<'_>, cavity: &Cavity, index: usize, list: &mut Vec<Candidate>) {
    let n = cavity.rim.len();
    let (mesh, topology) = (site.mesh, site.topology);
    let p = |v: u32| mesh.points[v as usize];
    let stays =
        |v: u32| topology.on_boundary[v as usize] || site.fixed.get(v as usize).copied().unwrap_or(false);
    let off = |angle: f64, n: usize| {
        let each = angle / n as f64;
        if each > WIDEST { f64::INFINITY } else { 2.0 * (each / FRAC_PI_2).ln().powi(2) }
    };
    let mut cost = vec![[f64::INFINITY; 8]; n];
    for (i, &v) in cavity.rim.iter().enumerate() {
        let (a, b) = (cavity.rim[(i + n - 1) % n], cavity.rim[(i + 1) % n]);
        let outside = topology.n_quads_at(VertexId(v)) - cavity.inside[i];
        for (k, c) in cost[i].iter_mut().enumerate().skip(1) {
            *c = if stays(v) && stays(a) && stays(b) {
                off(interior_angle(p(a), p(v), p(b)), k)
            } else if topology.on_boundary[v as usize] {
                let ends = topology.boundary_neighbours(VertexId(v), &mesh.quads);
                let angle = ends.map_or(TAU, |[a, b]| interior_angle(p(a.0), p(v), p(b.0)));
                off(angle, outside + k)
            } else if outside + k < 3 {
                f64::INFINITY
            } else {
                off(TAU, outside + k)
            };
        }
    }
    for (d, disk) in disks(n).iter().enumerate() {
        let same = (0..n).all(|i| usize::from(disk.rim[i]) == cavity.inside[i]);
        if same && disk.quads.len() == cavity.quads.len() {
            continue;
        }
        let rim: f64 = (0..n).map(|i| cost[i][usize::from(disk.rim[i]).min(7)]).sum();
        let inner: f64 = disk.inner.iter().map(|&d| INNER + off(TAU, usize::from(d))).sum();
        if (rim + inner).is_finite() {
            list.push(Candidate { cost: rim + inner, cavity: index, disk: d });
        }
    }
}

/// The change as a number: what goes and what comes, but for what does both.
fn key(site: &Site<'_>, cavity: &Cavity, disk: &Disk) -> u64 {
    let mix = |x: u64| {
        let x = (x ^ x >> 31).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (x ^ x >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9)
    };
    let of = |mut q: [u64; 4]| {
        let least = (0..4).min_by_key(|&k| q[k]).unwrap_or(0);
        q.rotate_left(least);
        mix(mix(q[0] ^ q[2] << 32) ^ q[1] ^ q[3] << 32)
    };
    let n = cavity.rim.len();
    let name =
        |v: u8| cavity.rim.get(usize::from(v)).map_or((1 << 31) + u64::from(v) - n as u64, |&v| u64::from(v));
    let come = disk.quads.iter().map(|q| of(q.map(name))).fold(0, u64::wrapping_add);
    let go = cavity.quads.iter().map(|&q| of(site.mesh.quads[q as usize].map(|v| u64::from(v.0))));
    come.wrapping_sub(go.fold(0, u64::wrapping_add))
}

/// The surroundings of a cavity.
struct Local {
    /// Quads around, ascending.
    around: Vec<u32>,
    /// Vertices of these and of the rim, ascending.
    names: Vec<u32>,
}

impl Local {
    fn new(site: &Site<'_>, cavity: &Cavity) -> Self {
        let mut around: Vec<u32> = Vec::new();
        let mut names: Vec<u32> = cavity.rim.clone();
        for _ in 0..RINGS {
            around.extend(names.iter().flat_map(|&v| site.topology.star(VertexId(v)).iter().map(|&h| h / 4)));
            around.sort_unstable();
            around.dedup();
            around.retain(|q| cavity.quads.binary_search(q).is_err());
            names.extend(around.iter().flat_map(|&q| site.mesh.quads[q as usize].map(|v| v.0)));
            names.sort_unstable();
            names.dedup();
        }
        Self { around, names }
    }

    /// How good it is as it is.
    fn before(&self, site: &Site<'_>, cavity: &Cavity) -> Rank {
        let quads = self.around.iter().chain(&cavity.quads);
        Rank::of(quads.map(|&q| site.mesh.quads[q as usize].map(|v| site.mesh.points[v.index()])))
    }

    /// Lays the disk out; how good it is with what is around, and the change, if all quads are positive.
    fn solve(
        &self,
        site: &Site<'_>,
        cavity: &Cavity,
        disk: &Disk,
        before: &Rank,
        task: &ReshapeTask<'_>,
    ) -> Option<(Rank, Change)> {
        let n_rim = cavity.rim.len();
        let find = |v: u32| VertexId(self.names.binary_search(&v).map_or(u32::MAX, |i| i as u32));
        let n_old = self.names.len();
        let local = |v: u8| match cavity.rim.get(usize::from(v)) {
            Some(&v) => find(v),
            None => VertexId::new(n_old + usize::from(v) - n_rim),
        };
        let mut mesh = QuadMesh {
            points: self.names.iter().map(|&v| site.mesh.points[v as usize]).collect(),
            quads: self.around.iter().map(|&q| site.mesh.quads[q as usize].map(|v| find(v.0))).collect(),
            triangles: Vec::new(),
        };
        mesh.points.extend(layout(site, cavity, disk));
        mesh.quads.extend(disk.quads.iter().map(|q| q.map(local)));
        let topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
        if topology.n_bad_edges > 0 {
            return None;
        }
        let mut fixed: Vec<bool> =
            self.names.iter().map(|&v| site.fixed.get(v as usize).copied().unwrap_or(false)).collect();
        fixed.resize(mesh.n_vertices(), false);
        if corners(&mesh).any(|p| Corners::new(&p).min_scaled() <= FLAT) {
            let options = SmoothOptions::default();
            let effort = &Effort::TRIAL;
            if !untangle_with(&mut mesh, &topology, &fixed, task.size, &options, effort).is_positive() {
                return None;
            }
        }
        let lift = |mesh: &mut QuadMesh, doublings: &[u32]| {
            lift_by(mesh, &topology, &fixed, ENOUGH, WHOLE, (doublings, TRIAL_ITERATIONS));
        };
        lift(&mut mesh, &DOUBLINGS[..1]);
        // What is far behind after the first power does not win by the others.
        let least = BEHIND * before.sine;
        if corners(&mesh).any(|p| least_sine(&p) < least) {
            return None;
        }
        lift(&mut mesh, &DOUBLINGS[1..]);
        let merge = task.tolerance.merge();
        let apart = |p: [Point2; 4]| (0..4).all(|k| p[k].distance(p[(k + 1) & 3]) > 4.0 * merge);
        if !corners(&mesh).all(apart) || csalf_mesh::certify(&mesh.points, &mesh.quads).is_some() {
            return None;
        }
        let first = site.mesh.n_vertices() as u32;
        let name = |v: u8| match cavity.rim.get(usize::from(v)) {
            Some(&v) => v,
            None => first + u32::from(v) - n_rim as u32,
        };
        let edit = Edit {
            remove: cavity.quads.clone(),
            add: disk.quads.iter().map(|q| q.map(name)).collect(),
            points: mesh.points[n_old..].to_vec(),
            mandatory: false,
        };
        let moved = self.names.iter().copied().zip(mesh.points.iter().copied()).collect();
        Some((Rank::of(corners(&mesh)), Change { edit, moved, touched: self.names.clone() }))
    }
}

fn corners(mesh: &QuadMesh) -> impl Iterator<Item = [Point2; 4]> {
    mesh.quads.iter().map(|q| q.map(|v| mesh.points[v.index()]))
}

/// Inner vertices of a disk at the mean of their neighbours.
fn layout(site: &Site<'_>, cavity: &Cavity, disk: &Disk) -> Vec<Point2> {
    let rim: Vec<Point2> = cavity.rim.iter().map(|&v| site.mesh.points[v as usize]).collect();
    let n = rim.len();
    let mut points = vec![rim.iter().copied().sum::<Point2>() / n as f64; disk.inner.len()];
    for _ in 0..8 {
        for i in 0..points.len() {
            let (mut sum, mut count) = (Point2::ZERO, 0.0);
            for q in disk.quads {
                if let Some(k) = q.iter().position(|&v| usize::from(v) == n + i) {
                    let w = usize::from(q[(k + 1) & 3]);
                    sum += if w < n { rim[w] } else { points[w - n] };
                    count += 1.0;
                }
            }
            points[i] = sum / count;
        }
    }
    points
}
