//! Meshing poor places again, across the seams that made them.
//!
//! ```text
//!    ┌──┬──┬──┬──┐        the quads within a few rings of a poor one are a disc; its rim, an even loop of quad
//!    ├──┼╲╱┼──┼──┤        sides, is flattened and meshed like any face; kept if the worst quad is better
//!    ├──┼╱╲┼──┼──┤
//!    └──┴──┴──┴──┘
//! ```
//!
//! Worst quads first, regions of one round are disjoint, so the order of work is fixed. Nodes that must stay,
//! sides of scars and quads of layers are never inside a region. Source: handbook 6.5 and 9.4.

use crate::face::mesh;
use crate::flatten::{Flattened, flatten};
use crate::locate::Locator;
use crate::patch::{Chart, NONE, Patch};
use crate::quality::{corners, measure};
use crate::sheet::{Ground, Sheet};
use crate::smooth::smooth;
use crate::{FaceMesh, Facets};
use csalf_core::{Job, Options};
use csalf_geom::{Domain, VertexId};
use csalf_mesh::QuadTopology;
use csalf_pave::LayerSpec;
use csalf_sizemap::SizeSpec;

/// Quads with a scaled Jacobian below this are seeds.
const POOR: f64 = 0.6;
/// Rings of quads of a region, in the order tried. Of 309 seeds in 42 models two rings healed 27, then three 8, then one
/// 13; four would heal 1 for as much time as all others take.
const RINGS: [usize; 3] = [2, 3, 1];
/// The worst quad must gain this much.
const GAIN: f64 = 0.05;
/// Most rounds.
const ROUNDS: usize = 3;
/// Most seeds tried per round, and most of them in vain: bounds the time on hopeless meshes.
const TRIALS: usize = 300;
/// See [`TRIALS`].
const IN_VAIN: usize = 50;

/// A region meshed anew: quads that go, and the quads that come, with new vertices counted from the end of
/// the sheet.
struct Region {
    old: Vec<u32>,
    rim: Vec<u32>,
    new: Vec<[u32; 4]>,
    inner: Sheet,
}

/// Heals the sheet; `out.rings` follow the renumbering of quads. Returns the number of regions.
pub(crate) fn heal(
    sheet: &mut Sheet,
    ground: &Ground<'_>,
    options: &Options,
    n_given: usize,
    out: &mut FaceMesh,
) -> usize {
    let mut n_healed = 0;
    // Seeds that were tried in vain are not tried again: of 107 second tries on a bladed wheel 103 were in vain, too.
    let mut hopeless = vec![false; sheet.quads.len()];
    for _ in 0..ROUNDS {
        let mut in_vain = 0;
        let topology = topology(sheet);
        let mut poor: Vec<(f64, u32)> = (0..sheet.quads.len() as u32)
            .map(|q| (worst(sheet, &sheet.quads[q as usize]), q))
            .filter(|x| x.0 < POOR && !hopeless[x.1 as usize])
            .collect();
        poor.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut blocked = vec![false; sheet.quads.len()];
        out.rings.iter().flat_map(|r| &r.quads).for_each(|&q| blocked[q as usize] = true);
        let mut dead = vec![false; sheet.quads.len()];
        let mut added: Vec<[u32; 4]> = Vec::new();
        let mut seeds = Vec::new();
        for &(_, seed) in poor.iter().take(TRIALS) {
            let found = RINGS
                .iter()
                .find_map(|&rings| region(sheet, ground, options, &topology, seed, rings, &blocked, n_given));
            let Some(r) = found else {
                hopeless[seed as usize] = true;
                in_vain += 1;
                if in_vain == IN_VAIN {
                    break;
                }
                continue;
            };
            for &q in &r.old {
                (dead[q as usize], blocked[q as usize]) = (true, true);
            }
            let first = sheet.points.len() as u32;
            let n_rim = r.rim.len() as u32;
            seeds.extend(&r.rim);
            seeds.extend(first..first + r.inner.points.len() as u32);
            sheet.points.extend(r.inner.points);
            sheet.normals.extend(r.inner.normals);
            sheet.anchors.extend(r.inner.anchors);
            sheet.fixed.extend(r.inner.fixed);
            let id = |v: u32| if v < n_rim { r.rim[v as usize] } else { first + v - n_rim };
            added.extend(r.new.iter().map(|q| q.map(id)));
            n_healed += 1;
        }
        if added.is_empty() {
            break;
        }
        compact(sheet, &dead, added, out, &mut seeds, n_given, &mut hopeless);
        smooth(sheet, ground, &self::topology(sheet), &seeds);
    }
    n_healed
}

fn topology(sheet: &Sheet) -> QuadTopology {
    let quads: Vec<[VertexId; 4]> = sheet.quads.iter().map(|q| q.map(VertexId)).collect();
    QuadTopology::new(sheet.points.len(), &quads)
}

/// Smallest scaled Jacobian of one quad.
fn worst(sheet: &Sheet, q: &[u32; 4]) -> f64 {
    let (_, s) = corners(q.map(|v| sheet.points[v as usize]), q.map(|v| sheet.normals[v as usize]));
    s.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Drops dead quads and unused vertices, appends the new quads; `hopeless` has an entry per quad.
fn compact(
    sheet: &mut Sheet,
    dead: &[bool],
    added: Vec<[u32; 4]>,
    out: &mut FaceMesh,
    seeds: &mut Vec<u32>,
    n_given: usize,
    hopeless: &mut Vec<bool>,
) {
    let mut new_quad = vec![NONE; dead.len()];
    let mut quads = Vec::with_capacity(dead.len());
    for (q, &d) in dead.iter().enumerate() {
        if !d {
            new_quad[q] = quads.len() as u32;
            hopeless[quads.len()] = hopeless[q];
            quads.push(sheet.quads[q]);
        }
    }
    hopeless.truncate(quads.len());
    quads.extend(added);
    hopeless.resize(quads.len(), false);
    out.rings.iter_mut().flat_map(|r| &mut r.quads).for_each(|q| *q = new_quad[*q as usize]);
    let mut used = vec![false; sheet.points.len()];
    used[..n_given].fill(true);
    quads.iter().flatten().for_each(|&v| used[v as usize] = true);
    let mut new = vec![NONE; used.len()];
    let mut n = 0;
    for (v, _) in used.iter().enumerate().filter(|x| *x.1) {
        new[v] = n as u32;
        sheet.points[n] = sheet.points[v];
        sheet.normals[n] = sheet.normals[v];
        sheet.anchors[n] = sheet.anchors[v];
        sheet.fixed[n] = sheet.fixed[v];
        n += 1;
    }
    sheet.points.truncate(n);
    sheet.normals.truncate(n);
    sheet.anchors.truncate(n);
    sheet.fixed.truncate(n);
    quads.iter_mut().flatten().for_each(|v| *v = new[*v as usize]);
    sheet.quads = quads;
    seeds.retain_mut(|v| {
        *v = new[*v as usize];
        *v != NONE
    });
}

/// The quads within `rings` of `seed`, ascending; `None` if one of them may not go.
fn grow(
    sheet: &Sheet,
    topology: &QuadTopology,
    seed: u32,
    rings: usize,
    blocked: &[bool],
) -> Option<Vec<u32>> {
    let mut list = vec![seed];
    for _ in 0..rings {
        let around = list.iter().flat_map(|&q| sheet.quads[q as usize]);
        let mut next: Vec<u32> =
            around.flat_map(|v| topology.star(VertexId(v)).iter().map(|h| h / 4)).collect();
        next.sort_unstable();
        next.dedup();
        list = next.into_iter().filter(|&q| !blocked[q as usize]).collect();
    }
    (list.binary_search(&seed).is_ok()).then_some(list)
}

#[allow(clippy::too_many_arguments, reason = "one call, and all of it is context")]
fn region(
    sheet: &Sheet,
    ground: &Ground<'_>,
    options: &Options,
    topology: &QuadTopology,
    seed: u32,
    rings: usize,
    blocked: &[bool],
    n_given: usize,
) -> Option<Region> {
    let old = grow(sheet, topology, seed, rings, blocked)?;
    // Local vertices, and the facets: each quad by its shorter diagonal.
    let mut ids: Vec<u32> = old.iter().flat_map(|&q| sheet.quads[q as usize]).collect();
    ids.sort_unstable();
    ids.dedup();
    let local = |v: u32| ids.binary_search(&v).map_or(NONE, |i| i as u32);
    let p = |v: u32| sheet.points[v as usize];
    let mut facets = Facets { points: ids.iter().map(|&v| p(v)).collect(), triangles: Vec::new() };
    for &q in &old {
        let [a, b, c, d] = sheet.quads[q as usize];
        let [la, lb, lc, ld] = [a, b, c, d].map(local);
        if p(a).distance_squared(p(c)) <= p(b).distance_squared(p(d)) {
            facets.triangles.extend([[la, lb, lc], [la, lc, ld]]);
        } else {
            facets.triangles.extend([[la, lb, ld], [lb, lc, ld]]);
        }
    }
    let patch = Patch::new(&facets).ok()?;
    let n = patch.triangles.len() as u32;
    let cut = vec![false; patch.twin.len()];
    let chart = Chart::new(&patch, &cut, (0..n).collect(), &mut vec![NONE; n as usize]);
    if chart.loops.len() != 1 || chart.genus() != 0 || chart.vertex.len() != ids.len() {
        return None;
    }
    let on_rim = {
        let mut on = vec![false; ids.len()];
        chart.loops[0].iter().for_each(|&h| on[chart.vertex[chart.tail(h) as usize] as usize] = true);
        on
    };
    if (0..ids.len()).any(|i| !on_rim[i] && sheet.fixed[ids[i] as usize]) {
        return None;
    }
    // A side inside between two given nodes may be on a scar.
    let inside = |v: u32| (v as usize) < n_given;
    for &q in &old {
        for k in 0..4 {
            let quad = sheet.quads[q as usize];
            let twin = topology.twin[(4 * q + k) as usize];
            let both = inside(quad[k as usize]) && inside(quad[((k + 1) & 3) as usize]);
            if both && twin != QuadTopology::NONE && old.binary_search(&(twin / 4)).is_ok() {
                return None;
            }
        }
    }
    let Flattened { flat, .. } = flatten(&chart, None, false)?;
    let rim: Vec<u32> =
        chart.loops[0].iter().map(|&h| ids[chart.vertex[chart.tail(h) as usize] as usize]).collect();
    let outline: Vec<_> = chart.loops[0].iter().map(|&h| flat[chart.tail(h) as usize]).collect();
    let n_rim = outline.len();
    // The rim is no wall: a ring along it only takes room.
    let no_rings = vec![("*".to_owned(), LayerSpec { count: 0, ..LayerSpec::default() })];
    let job =
        Job { domain: Domain::new(outline), size: SizeSpec::Boundary, layers: no_rings, ..Job::default() };
    let options = Options { gradation: None, ..options.clone() };
    let meshed = mesh(&job, &options).ok()?;
    let locator = Locator::new(&chart, &flat);
    let mut inner = Sheet::default();
    let mut last = 0;
    for &uv in meshed.mesh.points.get(n_rim..)? {
        let (t, bary) = locator.find(uv, last);
        last = t;
        let corners = chart.triangles[t as usize].map(|v| chart.points[v as usize]);
        let at = crate::locate::mix(corners, bary);
        let near = ids[chart.vertex[chart.triangles[t as usize][0] as usize] as usize];
        inner.add(ground, ground.nearest(sheet.anchors[near as usize], at));
    }
    let new: Vec<[u32; 4]> = meshed.mesh.quads.iter().map(|q| q.map(|v| v.0)).collect();
    let before: Vec<[u32; 4]> = old.iter().map(|&q| sheet.quads[q as usize]).collect();
    let b = measure(&sheet.points, &before, |v| sheet.normals[v as usize]);
    let all: Vec<_> =
        rim.iter().map(|&v| sheet.points[v as usize]).chain(inner.points.iter().copied()).collect();
    let normal = |v: u32| {
        let v = v as usize;
        if v < n_rim { sheet.normals[rim[v] as usize] } else { inner.normals[v - n_rim] }
    };
    let a = measure(&all, &new, normal);
    let better = a.min_sj > b.min_sj + GAIN && a.mean_sj > b.mean_sj - 0.02;
    better.then_some(Region { old, rim, new, inner })
}
