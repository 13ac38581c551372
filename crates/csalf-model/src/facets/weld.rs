//! Points that are one become one; triangles are turned the same way.

use glam::DVec3;
use std::collections::BTreeMap;

/// Triangles with welded points.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Welded {
    pub(super) points: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Triangles left out: two corners are one point, or the triangle is there twice.
    pub(super) n_dropped: usize,
    /// Triangles turned over to agree with their neighbours.
    pub(super) n_turned: usize,
}

/// Welds points closer than `tolerance`: the lowest index within reach wins. Cost O(n log n).
pub(super) fn weld(points: &[DVec3], triangles: &[[u32; 3]], tolerance: f64) -> Welded {
    let size = if tolerance > 0.0 { 2.0 * tolerance } else { 1.0 };
    let cell = |p: DVec3| (p / size).floor().to_array().map(|x| x as i64);
    let mut cells: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    let mut out = Welded::default();
    let mut name = vec![0_u32; points.len()];
    for (i, &p) in points.iter().enumerate() {
        let c = cell(p);
        let mut found: Option<u32> = None;
        for d in 0..27_i64 {
            let near = [d % 3 - 1, d / 3 % 3 - 1, d / 9 - 1];
            let key = [0, 1, 2].map(|k| c[k].saturating_add(near[k]));
            for &j in cells.get(&key).map_or(&[][..], Vec::as_slice) {
                let close = out.points[j as usize].distance(p) <= tolerance || out.points[j as usize] == p;
                if close && found.is_none_or(|f| j < f) {
                    found = Some(j);
                }
            }
        }
        name[i] = found.unwrap_or_else(|| {
            out.points.push(p);
            let j = out.points.len() as u32 - 1;
            cells.entry(c).or_default().push(j);
            j
        });
    }
    let mut kept: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| name[v as usize])).collect();
    let before = kept.len();
    kept.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    // A triangle that is there twice, whichever way round, once.
    let mut keys: Vec<([u32; 3], usize)> = kept
        .iter()
        .enumerate()
        .map(|(i, t)| {
            let mut k = *t;
            k.sort_unstable();
            (k, i)
        })
        .collect();
    keys.sort_unstable();
    let mut first = vec![true; kept.len()];
    for w in keys.windows(2) {
        if w[0].0 == w[1].0 {
            first[w[1].1] = false;
        }
    }
    let mut i = 0;
    kept.retain(|_| {
        i += 1;
        first[i - 1]
    });
    out.n_dropped = before - kept.len();
    out.triangles = kept;
    out.n_turned = orient(&mut out.triangles);
    out
}

/// For each side k (corner k to k + 1) of each triangle the triangle across it, where exactly two meet.
pub(super) fn neighbours(triangles: &[[u32; 3]]) -> Vec<[Option<u32>; 3]> {
    let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], (3 * i + k) as u32));
        }
    }
    sides.sort_unstable();
    let mut out = vec![[None; 3]; triangles.len()];
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a), (_, b)] = run {
            out[(a / 3) as usize][(a % 3) as usize] = Some(b / 3);
            out[(b / 3) as usize][(b % 3) as usize] = Some(a / 3);
        }
    }
    out
}

/// [`neighbours`] that run along their side in opposite ways, as those of a surface with two faces do: all but along
/// one chain of sides of each Möbius strip. Only through these do the triangles at a point follow each other round it.
pub(super) fn agreeing_neighbours(triangles: &[[u32; 3]]) -> Vec<[Option<u32>; 3]> {
    let mut out = neighbours(triangles);
    for (t, across) in triangles.iter().zip(&mut out) {
        for (k, slot) in across.iter_mut().enumerate() {
            *slot = slot.filter(|&j| runs(&triangles[j as usize], t[(k + 1) % 3], t[k]));
        }
    }
    out
}

/// True if the triangle has the side from `a` to `b`.
fn runs(t: &[u32; 3], a: u32, b: u32) -> bool {
    (0..3).any(|k| t[k] == a && t[(k + 1) % 3] == b)
}

/// Turns triangles over so that neighbours agree; in each connected part the fewer are turned. Returns how many.
fn orient(triangles: &mut [[u32; 3]]) -> usize {
    let across = neighbours(triangles);
    let mut turned: Vec<Option<bool>> = vec![None; triangles.len()];
    let mut total = 0;
    for start in 0..triangles.len() {
        if turned[start].is_some() {
            continue;
        }
        turned[start] = Some(false);
        let mut part = vec![start];
        let mut at = 0;
        while let Some(&i) = part.get(at) {
            at += 1;
            let mine = turned[i] == Some(true);
            for k in 0..3 {
                let Some(j) = across[i][k].map(|j| j as usize) else { continue };
                let (a, b) = (triangles[i][k], triangles[i][(k + 1) % 3]);
                if turned[j].is_none() {
                    // Neighbours that agree run along their side in opposite directions.
                    turned[j] = Some(mine ^ runs(&triangles[j], a, b));
                    part.push(j);
                }
            }
        }
        let n = part.iter().filter(|i| turned[**i] == Some(true)).count();
        let flip = 2 * n > part.len();
        total += if flip { part.len() - n } else { n };
        for i in part {
            turned[i] = turned[i].map(|t| t ^ flip);
        }
    }
    for (t, turn) in triangles.iter_mut().zip(turned) {
        if turn == Some(true) {
            t.swap(1, 2);
        }
    }
    total
}
