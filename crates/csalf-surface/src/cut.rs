//! Where to cut a chart that cannot be flattened as it is.
//!
//! ```text
//!   tube (two loops or more)        cup, closed surface, handle
//!   ╭──────────╮                       A ╭─────╮ B
//!   │──cut─────│  shortest path          │  │  │   two far facets; the line of equal distance
//!   ╰──────────╯  between two loops      ╰──┼──╯   between them divides the chart in two
//! ```
//!
//! Cuts end at mesh nodes of the boundary or on other cuts, never between two nodes, and never run along
//! scars: facets that would allow it are kept together. Source: handbook 9.4.

use crate::patch::{Chart, NONE, Patch, components, next};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Rounds of averaging of the distance before the dividing line is taken: straightens it.
const ROUNDS: usize = 12;

/// What the cutter must know of the face.
#[derive(Debug)]
pub(crate) struct Bounds<'a> {
    /// Per vertex: a mesh node on the given boundary (or a scar node, or a hard point).
    pub(crate) is_node: &'a [bool],
    /// Per half-side: on a scar.
    pub(crate) on_scar: &'a [bool],
    /// Per vertex: on a scar.
    pub(crate) in_scar: &'a [bool],
}

/// Marks cuts inside the chart; false if there is no way.
pub(crate) fn cut_chart(patch: &Patch, chart: &Chart, bounds: &Bounds<'_>, cut: &mut [bool]) -> bool {
    if chart.loops.len() >= 2 && chart.genus() == 0 && along(patch, chart, bounds, cut) {
        return true;
    }
    across(patch, chart, bounds, cut)
}

/// Marks the side of local half-side `h`, both ways.
fn mark(patch: &Patch, chart: &Chart, h: u32, cut: &mut [bool]) {
    let g = 3 * chart.facets[h as usize / 3] + h % 3;
    cut[g as usize] = true;
    if patch.twin[g as usize] != NONE {
        cut[patch.twin[g as usize] as usize] = true;
    }
}

/// A key that orders finite distances >= 0.
fn key(x: f64) -> u64 {
    x.to_bits()
}

/// The shortest path between two loops.
fn along(patch: &Patch, chart: &Chart, bounds: &Bounds<'_>, cut: &mut [bool]) -> bool {
    let n = chart.vertex.len();
    let mut loop_of = vec![NONE; n];
    for (k, l) in chart.loops.iter().enumerate() {
        l.iter().for_each(|&h| loop_of[chart.tail(h) as usize] = k as u32);
    }
    // May a path end here: at a node, or at a vertex of which all boundary sides are cuts.
    let mut may_end = vec![true; n];
    for l in &chart.loops {
        for (i, &h) in l.iter().enumerate() {
            let g = l[(i + l.len() - 1) % l.len()];
            let real =
                |h: u32| patch.twin[3 * chart.facets[h as usize / 3] as usize + h as usize % 3] == NONE;
            let v = chart.tail(h) as usize;
            may_end[v] = bounds.is_node[chart.vertex[v] as usize] || !(real(h) || real(g));
        }
    }
    // The path starts at the shortest loop: few ways are tried.
    let start =
        (0..chart.loops.len() as u32).min_by_key(|&k| (chart.loops[k as usize].len(), k)).unwrap_or(0);
    let mut distance = vec![f64::INFINITY; n];
    let mut from = vec![NONE; n];
    let mut heap = BinaryHeap::new();
    for v in (0..n as u32).filter(|&v| loop_of[v as usize] == start && may_end[v as usize]) {
        distance[v as usize] = 0.0;
        heap.push(Reverse((key(0.0), v)));
    }
    let mut leaving: Vec<Vec<u32>> = vec![Vec::new(); n];
    for h in 0..chart.across.len() as u32 {
        if chart.across[h as usize] != NONE {
            leaving[chart.tail(h) as usize].push(h);
        }
    }
    while let Some(Reverse((d, v))) = heap.pop() {
        if d != key(distance[v as usize]) {
            continue;
        }
        let k = loop_of[v as usize];
        if k != NONE && k != start {
            let mut v = v;
            while from[v as usize] != NONE {
                mark(patch, chart, from[v as usize], cut);
                v = chart.tail(from[v as usize]);
            }
            return true;
        }
        for &h in &leaving[v as usize] {
            let w = chart.tail(next(h)) as usize;
            let global = chart.vertex[w] as usize;
            let blocked = match loop_of[w] {
                NONE => bounds.in_scar[global],
                k => k == start || !may_end[w],
            };
            let g = 3 * chart.facets[h as usize / 3] + h % 3;
            if blocked || bounds.on_scar[g as usize] {
                continue;
            }
            let far = distance[v as usize] + chart.points[v as usize].distance(chart.points[w]);
            if far < distance[w] {
                distance[w] = far;
                from[w] = h;
                heap.push(Reverse((key(far), w as u32)));
            }
        }
    }
    false
}

/// Distance of all facets from one, over centres; facets of one group are at no distance from each other.
fn distances(chart: &Chart, centres: &[glam::DVec3], from: usize) -> Vec<f64> {
    let mut d = vec![f64::INFINITY; centres.len()];
    d[from] = 0.0;
    let mut heap = BinaryHeap::from([Reverse((key(0.0), from as u32))]);
    while let Some(Reverse((k, t))) = heap.pop() {
        if k != key(d[t as usize]) {
            continue;
        }
        for h in 3 * t..3 * t + 3 {
            let g = chart.across[h as usize];
            if g != NONE {
                let s = g as usize / 3;
                let far = d[t as usize] + centres[t as usize].distance(centres[s]);
                if far < d[s] {
                    d[s] = far;
                    heap.push(Reverse((key(far), s as u32)));
                }
            }
        }
    }
    d
}

/// Facets that must stay together: fans of boundary vertices that are no nodes, both sides of scars.
fn groups(patch: &Patch, chart: &Chart, bounds: &Bounds<'_>) -> Vec<u32> {
    let mut root: Vec<u32> = (0..chart.triangles.len() as u32).collect();
    fn find(root: &mut [u32], mut t: u32) -> u32 {
        while root[t as usize] != t {
            root[t as usize] = root[root[t as usize] as usize];
            t = root[t as usize];
        }
        t
    }
    let mut join = |a: u32, b: u32| {
        let (a, b) = (find(&mut root, a), find(&mut root, b));
        root[a.max(b) as usize] = a.min(b);
    };
    let global = |h: u32| 3 * chart.facets[h as usize / 3] as usize + h as usize % 3;
    let mut first = vec![NONE; chart.vertex.len()];
    let mut keep = vec![false; chart.vertex.len()];
    for &h in chart.loops.iter().flatten() {
        let v = chart.tail(h) as usize;
        let w = chart.tail(next(h)) as usize;
        if patch.twin[global(h)] == NONE {
            for x in [v, w] {
                keep[x] |= !bounds.is_node[chart.vertex[x] as usize];
            }
        }
    }
    for (v, k) in keep.iter_mut().enumerate() {
        let g = chart.vertex[v] as usize;
        *k |= bounds.in_scar[g] && !bounds.is_node[g];
    }
    for (t, c) in chart.triangles.iter().enumerate() {
        for (k, v) in c.map(|v| v as usize).into_iter().enumerate() {
            if keep[v] {
                if first[v] == NONE {
                    first[v] = t as u32;
                }
                join(first[v], t as u32);
            }
            let h = (3 * t + k) as u32;
            if bounds.on_scar[global(h)] && chart.across[h as usize] != NONE {
                join(t as u32, chart.across[h as usize] / 3);
            }
        }
    }
    (0..root.len() as u32).map(|t| find(&mut root, t)).collect()
}

/// Divides the chart in two.
fn across(patch: &Patch, chart: &Chart, bounds: &Bounds<'_>, cut: &mut [bool]) -> bool {
    let n = chart.triangles.len();
    let centres: Vec<_> = chart
        .triangles
        .iter()
        .map(|t| {
            (chart.points[t[0] as usize] + chart.points[t[1] as usize] + chart.points[t[2] as usize]) / 3.0
        })
        .collect();
    let area: Vec<f64> = chart.facets.iter().map(|&t| patch.area_vector(t).length()).collect();
    let farthest = |d: &[f64]| (0..n).max_by(|&a, &b| d[a].total_cmp(&d[b]).then(b.cmp(&a))).unwrap_or(0);
    let a = farthest(&distances(chart, &centres, 0));
    let from_a = distances(chart, &centres, a);
    let b = farthest(&from_a);
    let from_b = distances(chart, &centres, b);
    let mut f: Vec<f64> = (0..n).map(|t| from_a[t] - from_b[t]).collect();
    for _ in 0..ROUNDS {
        let old = f.clone();
        for t in 0..n {
            let near = (3 * t..3 * t + 3).filter(|&h| chart.across[h] != NONE);
            let (mut sum, mut k) = (old[t], 1.0);
            for h in near {
                sum += old[chart.across[h] as usize / 3];
                k += 1.0;
            }
            f[t] = sum / k;
        }
    }
    let group = groups(patch, chart, bounds);
    let mut weight = vec![0f64; n];
    for t in 0..n {
        weight[group[t] as usize] += area[t] * f[t];
    }
    let mut right: Vec<bool> = group.iter().map(|&g| weight[g as usize] > 0.0).collect();
    // Islands go over to the other side, until both are connected.
    for _ in 0..4 {
        let parts = parts(chart, &right);
        let n_parts = parts.iter().copied().max().map_or(0, |m| m as usize + 1);
        let mut size = vec![0usize; n_parts];
        parts.iter().for_each(|&p| size[p as usize] += 1);
        let largest = |side: bool| {
            (0..n)
                .filter(|&t| right[t] == side)
                .map(|t| parts[t])
                .max_by_key(|&p| (size[p as usize], Reverse(p)))
        };
        let keep = [largest(false), largest(true)];
        let mut changed = false;
        let old = right.clone();
        for t in 0..n {
            if Some(parts[t]) != keep[usize::from(old[t])] {
                right[t] = !old[t];
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    let mut any = false;
    for h in 0..chart.across.len() as u32 {
        let g = chart.across[h as usize];
        if g != NONE && right[h as usize / 3] != right[g as usize / 3] {
            mark(patch, chart, h, cut);
            any = true;
        }
    }
    any && components(patch, cut, Some(&chart.facets)).len() > 1
}

/// Numbers the connected parts of equal side.
fn parts(chart: &Chart, right: &[bool]) -> Vec<u32> {
    let n = right.len();
    let mut part = vec![NONE; n];
    let mut count = 0;
    let mut stack = Vec::new();
    for t in 0..n {
        if part[t] != NONE {
            continue;
        }
        part[t] = count;
        stack.push(t);
        while let Some(t) = stack.pop() {
            for h in 3 * t..3 * t + 3 {
                let g = chart.across[h];
                if g != NONE && part[g as usize / 3] == NONE && right[g as usize / 3] == right[t] {
                    part[g as usize / 3] = count;
                    stack.push(g as usize / 3);
                }
            }
        }
        count += 1;
    }
    part
}
