//! Mending: quads that smoothing and untangling could not make convex are cut out, and the hole is filled anew with
//! convex ones.
//!
//! ```text
//!   bad quads ──▶ with rings around ──▶ walks along their rim, scars and hard points ──bridge──▶ contour ──▶ quads
//!                       ▲                                                                          │ refused
//!                       └──────────────────────────── more rings ◀────────────────────────────────┘
//! ```
//!
//! 1. [`bad_quads`]: concave, flat, or with two vertices that are one point by the tolerance.
//! 2. [`Holes`]: the quads within some rings around them, in parts that share edges (scars part them).
//! 3. [`walks`]: the rim of each part, and what it holds of scars and hard points.
//! 4. Strict subdivision, then the guaranteed fallback alone, fill the bridged contour. What is still bad is not
//!    taken: the next round cuts out more.
//!
//! As the quads outside are convex, the mesh is valid as soon as all of them are: no test for overlaps is needed.
//! Cost O(n) per round, then that of filling the holes.

use csalf_geom::{Point2, QuadId, Tolerance, VertexId};
use csalf_mesh::quality::Corners;
use csalf_mesh::{
    Contour, NamedSets, NodeFlags, Patch, QuadMesh, QuadTopology, RegionMesher, RegionTask,
    is_strictly_convex,
};
use csalf_sizemap::SizeField;
use csalf_subdiv::fallback::Fallback;
use csalf_subdiv::{SplitRules, Subdivision, Walks, bridge};
use rayon::prelude::*;

/// Rings of quads around the bad ones, round after round: first without the guaranteed fallback, which makes poor
/// quads, then with it.
const RINGS: [usize; 12] = [1, 2, 3, 5, 0, 1, 2, 3, 5, 8, 16, 64];
/// From this round on the guaranteed fallback is taken.
const FALLBACK_FROM: usize = 4;
/// From this round on protected quads are cut out like others.
const PROTECTED_FROM: usize = 8;
/// Before [`FALLBACK_FROM`] no quad may be worse than this (scaled Jacobian).
const LEAST_SJ: f64 = 0.02;
/// Where subdivision makes more quads than this for each node of the rim, it has gone astray (nodes nearly in one place,
/// split into ever smaller contours), and the guaranteed fallback is asked, too. *Arbitrary.*
const MOST: usize = 10;

const NONE: u32 = QuadTopology::NONE;

/// What mending must respect.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MendTask<'a> {
    /// The first so many vertices are those of the input.
    pub(crate) n_input: usize,
    /// Edges that must stay (scars).
    pub(crate) kept: &'a [[VertexId; 2]],
    pub(crate) size: &'a dyn SizeField,
    pub(crate) tolerance: Tolerance,
}

/// What mending did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MendReport {
    /// Bad quads before.
    pub(crate) n_bad: usize,
    /// Bad quads that are left.
    pub(crate) n_left: usize,
    /// Holes cut and filled.
    pub(crate) n_holes: usize,
    /// Contours filled by the guaranteed fallback.
    pub(crate) n_fallbacks: usize,
}

impl MendReport {
    /// Counts a later round of mending in.
    pub(crate) fn add(&mut self, later: &Self) {
        self.n_left = later.n_left;
        self.n_holes += later.n_holes;
        self.n_fallbacks += later.n_fallbacks;
    }
}

/// True if a quad is not strictly convex, flat, or has two vertices in one place. Cost about 10 ns for nearly all.
pub(crate) fn is_bad(p: &[Point2; 4], tolerance: Tolerance) -> bool {
    /// Squares of a sine, and of a number of merge lengths, from which on nothing is near a limit: neither rounding nor
    /// a short diagonal beside sides of this length.
    const CLEAR: (f64, f64) = (1e-6, 1e8);
    let merge = tolerance.merge() * tolerance.merge();
    let e = [p[1] - p[0], p[2] - p[1], p[3] - p[2], p[0] - p[3]];
    let l = e.map(|e| e.length_squared());
    let clear = |k: usize| {
        let j = e[(k + 3) & 3].perp_dot(e[k]);
        j > 0.0 && j * j > CLEAR.0 * (l[(k + 3) & 3] * l[k]) && l[k] > CLEAR.1 * merge
    };
    if (0..4).all(clear) && l[0].max(l[2]) < f64::MAX.sqrt() {
        return false;
    }
    let close = || (0..4).any(|k| p[k].distance_squared(p[(k + 1) & 3]) <= merge);
    !is_strictly_convex(p) || Corners::new(p).is_flat() || close() || p[0].distance_squared(p[2]) <= merge
}

fn bad_quads(mesh: &QuadMesh, tolerance: Tolerance) -> Vec<u32> {
    let bad = |q: &[VertexId; 4]| is_bad(&q.map(|v| mesh.points[v.index()]), tolerance);
    let quads = mesh.quads.par_iter().with_min_len(1 << 14).enumerate();
    quads.filter(|(_, q)| bad(q)).map(|(q, _)| q as u32).collect()
}

/// Mends the mesh. `fixed`, `protected` and the sets follow the new numbers; `topology` is made anew if anything was
/// changed.
pub(crate) fn mend(
    mesh: &mut QuadMesh,
    topology: &mut QuadTopology,
    fixed: &mut Vec<bool>,
    protected: &mut Vec<bool>,
    sets: &mut NamedSets,
    task: &MendTask<'_>,
) -> MendReport {
    let mut bad = bad_quads(mesh, task.tolerance);
    let mut report = MendReport { n_bad: bad.len(), n_left: bad.len(), ..MendReport::default() };
    protected.resize(mesh.n_quads(), false);
    fixed.resize(mesh.n_vertices(), false);
    for (round, &rings) in RINGS.iter().enumerate() {
        if bad.is_empty() || topology.n_bad_edges > 0 {
            break;
        }
        let open = |q: u32| round >= PROTECTED_FROM || !protected[q as usize];
        let holes = Holes::new(mesh, topology, task, &bad, rings, &open);
        let mut gone = vec![false; mesh.n_quads()];
        let mut new: Vec<Filling> = Vec::new();
        for part in 0..holes.n_parts() {
            if let Some(filling) = fill(mesh, topology, &holes, part, task, round >= FALLBACK_FROM) {
                for &q in holes.part(part) {
                    gone[q as usize] = true;
                }
                report.n_holes += 1;
                report.n_fallbacks += filling.patch.n_fallbacks;
                new.push(filling);
            }
        }
        tracing::debug!(bad = bad.len(), rings, parts = holes.n_parts(), filled = new.len(), "mending");
        if new.is_empty() {
            continue;
        }
        replace(mesh, fixed, protected, sets, &gone, &new, task.n_input);
        *topology = QuadTopology::new(mesh.n_vertices(), &mesh.quads);
        bad = bad_quads(mesh, task.tolerance);
        report.n_left = bad.len();
    }
    if report.n_bad > 0 {
        let MendReport { n_bad, n_left, n_holes, n_fallbacks } = report;
        tracing::info!(n_bad, n_left, n_holes, n_fallbacks, "mended");
    }
    report
}

/// Quads to be cut out, in parts.
struct Holes {
    /// Part of each quad, or [`NONE`].
    part_of: Vec<u32>,
    quads: Vec<u32>,
    start: Vec<usize>,
    /// Per half-edge: it is an edge that must stay.
    wall: Vec<bool>,
}

impl Holes {
    fn new(
        mesh: &QuadMesh,
        topology: &QuadTopology,
        task: &MendTask<'_>,
        bad: &[u32],
        rings: usize,
        open: &dyn Fn(u32) -> bool,
    ) -> Self {
        let mut inside = vec![false; mesh.n_quads()];
        let mut wave: Vec<u32> = bad.to_vec();
        wave.iter().for_each(|&q| inside[q as usize] = true);
        for _ in 0..rings {
            let mut next = Vec::new();
            for v in wave.iter().flat_map(|&q| mesh.quads[q as usize]) {
                for q in topology.star(v).iter().map(|h| h / 4) {
                    if open(q) && !std::mem::replace(&mut inside[q as usize], true) {
                        next.push(q);
                    }
                }
            }
            wave = next;
        }
        let mut kept: Vec<[VertexId; 2]> = task.kept.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
        kept.sort_unstable();
        let mut wall = vec![false; 4 * mesh.n_quads()];
        let mut is_wall = |h: usize| {
            let (a, b) = (mesh.quads[h / 4][h & 3], mesh.quads[h / 4][(h + 1) & 3]);
            wall[h] = kept.binary_search(&[a.min(b), a.max(b)]).is_ok();
            wall[h]
        };
        let mut out =
            Self { part_of: vec![NONE; mesh.n_quads()], quads: Vec::new(), start: vec![0], wall: Vec::new() };
        for &seed in bad {
            if out.part_of[seed as usize] != NONE {
                continue;
            }
            let (part, mut at) = (out.n_parts() as u32, out.quads.len());
            out.part_of[seed as usize] = part;
            out.quads.push(seed);
            while at < out.quads.len() {
                let q = out.quads[at] as usize;
                at += 1;
                for h in 4 * q..4 * q + 4 {
                    let twin = topology.twin[h];
                    if is_wall(h) || twin == NONE {
                        continue;
                    }
                    let o = twin / 4;
                    if inside[o as usize] && out.part_of[o as usize] == NONE {
                        out.part_of[o as usize] = part;
                        out.quads.push(o);
                    }
                }
            }
            out.start.push(out.quads.len());
        }
        out.wall = wall;
        out
    }

    fn n_parts(&self) -> usize {
        self.start.len() - 1
    }

    fn part(&self, k: usize) -> &[u32] {
        &self.quads[self.start[k]..self.start[k + 1]]
    }
}

/// The walks of one part in vertices of the mesh: the outer one first. `None` if there is not exactly one outer walk.
fn walks(
    mesh: &QuadMesh,
    topology: &QuadTopology,
    holes: &Holes,
    part: usize,
    n_input: usize,
) -> Option<Vec<Vec<u32>>> {
    let inside = |h: u32| holes.part_of[(h / 4) as usize] == part as u32;
    let is_rim = |h: u32| {
        let twin = topology.twin[h as usize];
        holes.wall[h as usize] || twin == NONE || !inside(twin)
    };
    let tail = |h: u32| mesh.quads[(h / 4) as usize][(h & 3) as usize].0;
    let next = |h: u32| (h & !3) | ((h + 1) & 3);
    let mut seen: Vec<u32> = Vec::new();
    let mut rim: Vec<u32> = holes.part(part).iter().flat_map(|&q| 4 * q..4 * q + 4).collect();
    rim.retain(|&h| is_rim(h));
    rim.sort_unstable();
    let mut used = vec![false; rim.len()];
    let mut out: Vec<Vec<u32>> = Vec::new();
    for first in 0..rim.len() {
        if used[first] {
            continue;
        }
        let mut walk = Vec::new();
        let mut h = rim[first];
        // Each rim half-edge once: the successor is the next rim half-edge on the left side.
        while let Ok(i) = rim.binary_search(&h) {
            if std::mem::replace(&mut used[i], true) {
                break;
            }
            walk.push(tail(h));
            h = next(h);
            while !is_rim(h) {
                h = next(topology.twin[h as usize]);
            }
        }
        seen.extend_from_slice(&walk);
        out.push(walk);
    }
    // Vertices of the input that no walk passes: hard points inside.
    seen.sort_unstable();
    let mut points: Vec<u32> =
        holes.part(part).iter().flat_map(|&q| mesh.quads[q as usize].map(|v| v.0)).collect();
    points.sort_unstable();
    points.dedup();
    points.retain(|&v| (v as usize) < n_input && seen.binary_search(&v).is_err());
    let area = |w: &[u32]| {
        let p = |i: usize| mesh.points[w[i % w.len()] as usize];
        (0..w.len()).map(|i| (p(i) - p(0)).perp_dot(p(i + 1) - p(0))).sum::<f64>()
    };
    let outer = (0..out.len()).max_by(|&a, &b| area(&out[a]).total_cmp(&area(&out[b])))?;
    out.swap(0, outer);
    if area(&out[0]) <= 0.0 {
        return None;
    }
    out.extend(points.into_iter().map(|v| vec![v]));
    Some(out)
}

/// New quads for one part: local names are places in `names`, then new points.
struct Filling {
    /// Vertices of the mesh, one per occurrence of the contour, then bridge nodes as new points.
    names: Vec<u32>,
    bridges: Vec<Point2>,
    patch: Patch,
}

fn fill(
    mesh: &QuadMesh,
    topology: &QuadTopology,
    holes: &Holes,
    part: usize,
    task: &MendTask<'_>,
    at_any_price: bool,
) -> Option<Filling> {
    let walks = walks(mesh, topology, holes, part, task.n_input)?;
    let mut ids: Vec<u32> = walks.iter().flatten().copied().collect();
    ids.sort_unstable();
    ids.dedup();
    let local: Vec<Vec<u32>> = walks
        .iter()
        .map(|w| w.iter().map(|v| ids.binary_search(v).map_or(0, |i| i as u32)).collect())
        .collect();
    let points: Vec<Point2> = ids.iter().map(|&v| mesh.points[v as usize]).collect();
    // For the meshers all of the rim stays where it is.
    let flags = vec![NodeFlags::GEOMETRY; points.len()];
    let input = Walks { walks: &local, points: &points, flags: &flags };
    let bridged = bridge(input, task.size, points.len() as u32).ok()?;
    let contour: Contour = bridged.contour;
    if contour.len() < 4 || contour.len() % 2 == 1 {
        return None;
    }
    let shown = Contour { ids: contour.first_occurrences(), ..contour.clone() };
    let region = RegionTask { contour: &shown, size: task.size, tolerance: task.tolerance };
    let strict = Subdivision::new(SplitRules::QUALITY).with_seam(usize::MAX);
    let good = |patch: &Patch| {
        let mut quads = patch.quads.iter().map(|q| q.map(|v| patch.point(&shown, v)));
        let poor = |p: &[Point2; 4]| !at_any_price && Corners::new(p).min_scaled() < LEAST_SJ;
        patch.children.is_empty()
            && (at_any_price || patch.n_fallbacks == 0)
            && quads.all(|p| !is_bad(&p, task.tolerance) && !poor(&p))
    };
    let by = |m: &dyn RegionMesher| m.mesh(&region).ok().filter(good);
    let patch = match by(&strict) {
        Some(patch) if !at_any_price || patch.quads.len() <= MOST * contour.len() => patch,
        many if at_any_price => {
            many.into_iter().chain(by(&Fallback)).min_by_key(|patch| patch.quads.len())?
        }
        _ => return None,
    };
    let n_mesh = ids.len() as u32;
    // Bridge nodes are new vertices: the first of them is NONE - 1, and so on downwards.
    let names = contour
        .ids
        .iter()
        .map(|&i| if i < n_mesh { ids[i as usize] } else { NONE - 1 - (i - n_mesh) })
        .collect();
    Some(Filling { names, bridges: bridged.new_points, patch })
}

/// Takes quads out, puts the fillings in, drops vertices that are not used any more and gives new numbers.
fn replace(
    mesh: &mut QuadMesh,
    fixed: &mut Vec<bool>,
    protected: &mut Vec<bool>,
    sets: &mut NamedSets,
    gone: &[bool],
    new: &[Filling],
    n_input: usize,
) {
    let n_old = mesh.n_vertices();
    let was_used = {
        let mut used = vec![false; n_old];
        mesh.quads.iter().flatten().for_each(|v| used[v.index()] = true);
        used
    };
    let mut number = vec![NONE; mesh.n_quads()];
    let mut quads = Vec::with_capacity(mesh.n_quads());
    let mut still_protected = Vec::with_capacity(mesh.n_quads());
    for q in (0..mesh.n_quads()).filter(|&q| !gone[q]) {
        number[q] = quads.len() as u32;
        quads.push(mesh.quads[q]);
        still_protected.push(protected[q]);
    }
    for filling in new {
        let first_bridge = mesh.points.len() as u32;
        mesh.points.extend_from_slice(&filling.bridges);
        let first = mesh.points.len() as u32;
        mesh.points.extend_from_slice(&filling.patch.points);
        let n = filling.names.len() as u32;
        let name = |v: u32| match filling.names.get(v as usize) {
            Some(&id) if (id as usize) < n_old => VertexId(id),
            Some(&id) => VertexId(first_bridge + (NONE - 1 - id)),
            None => VertexId(first + v - n),
        };
        quads.extend(filling.patch.quads.iter().map(|q| q.map(name)));
    }
    still_protected.resize(quads.len(), false);
    fixed.resize(mesh.points.len(), false);
    let mut used = vec![false; mesh.points.len()];
    quads.iter().flatten().for_each(|v| used[v.index()] = true);
    mesh.triangles.iter().flatten().for_each(|v| used[v.index()] = true);
    let stays = |v: usize| used[v] || v < n_input || (v < n_old && !was_used[v]);
    let mut vertex = vec![NONE; mesh.points.len()];
    let (mut points, mut still_fixed) = (Vec::new(), Vec::new());
    for v in (0..mesh.points.len()).filter(|&v| stays(v)) {
        vertex[v] = points.len() as u32;
        points.push(mesh.points[v]);
        still_fixed.push(fixed[v]);
    }
    for v in quads.iter_mut().flatten().chain(mesh.triangles.iter_mut().flatten()) {
        *v = VertexId(vertex[v.index()]);
    }
    (mesh.points, mesh.quads, *fixed, *protected) = (points, quads, still_fixed, still_protected);
    for (_, list) in &mut sets.quads {
        *list = list.iter().map(|q| number[q.index()]).filter(|&q| q != NONE).map(QuadId).collect();
    }
}
