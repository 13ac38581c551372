//! Which edges change their count by one so that every face has an even total: a T-join of small weight.
//!
//! ```text
//!      ● odd ──e3── ○ ──e7── ● odd        faces are the vertices of the graph, edges shared by two faces its edges;
//!      change e3 and e7: all even         edges of one face lead to one more vertex, outside, without a condition
//! ```
//!
//! 1. Components of the graph over two-faced and one-faced edges.
//! 2. Edges of three and more faces join components: where components are odd and have no way outside, Gauss elimination
//!    over GF(2), cheap columns first.
//! 3. In each component, the odd faces are paired along shortest paths (Dijkstra): exactly by dynamic programming up to
//!    [`EXACT`] of them, else nearest pairs first.
//! 4. Edges on an odd number of the paths are changed.
//!
//! Handbook 10.2 (after Edmonds and Johnson 1973).

use crate::brep::EdgeUse;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Up to this many odd faces are paired optimally; the work is 2^n n.
const EXACT: usize = 14;

/// One edge, as parity sees it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    /// The faces that it flips: those that use it an odd number of times, ascending.
    pub(super) faces: Vec<usize>,
    /// What a change costs, > 0; `None` if it is frozen.
    pub(super) cost: Option<f64>,
}

/// The outcome.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Solution {
    /// Columns to change, ascending.
    pub(super) toggled: Vec<usize>,
    /// Components that stay odd, by their faces.
    pub(super) odd_components: Vec<Vec<usize>>,
}

/// Faces that use an edge an odd number of times, ascending.
pub(super) fn odd_faces(uses: &[(usize, EdgeUse)]) -> Vec<usize> {
    let mut faces: Vec<usize> = uses.iter().map(|u| u.0).collect();
    faces.sort_unstable();
    let runs = faces.chunk_by(|a, b| a == b).filter(|r| r.len() % 2 == 1);
    runs.filter_map(|r| r.first().copied()).collect()
}

/// Finds columns to change such that every face of `odd` becomes even.
pub(super) fn solve(n_faces: usize, columns: &[Column], odd: &[bool]) -> Solution {
    let mut odd = odd.to_vec();
    if !odd.contains(&true) {
        return Solution::default();
    }
    // The graph; vertex n_faces is the outside.
    let outside = n_faces;
    let mut graph: Vec<Vec<(usize, usize)>> = vec![Vec::new(); n_faces + 1];
    for (c, column) in columns.iter().enumerate().filter(|(_, c)| c.cost.is_some()) {
        let pair = match column.faces[..] {
            [a] => (a, outside),
            [a, b] => (a, b),
            _ => continue,
        };
        graph[pair.0].push((pair.1, c));
        graph[pair.1].push((pair.0, c));
    }
    let component = components(&graph, outside);
    let n_components = component.iter().copied().max().map_or(0, |m| m + 1);
    let mut open = vec![false; n_components];
    for &(f, _) in &graph[outside] {
        open[component[f]] = true;
    }
    let mut flips = join_components(n_faces, columns, &component, &open, &mut odd);
    // Each component on its own; the open ones may use the outside.
    let mut members = vec![Vec::new(); n_components];
    for f in 0..n_faces {
        members[component[f]].push(f);
    }
    let mut solution = Solution::default();
    for (k, faces) in members.into_iter().enumerate() {
        let mut terminals: Vec<usize> = faces.iter().copied().filter(|&f| odd[f]).collect();
        if terminals.len() % 2 == 1 {
            if open[k] {
                terminals.push(outside);
            } else {
                solution.odd_components.push(faces);
                // All but one can still be made even.
                terminals.pop();
            }
        }
        pair_up(&graph, columns, terminals, &mut flips);
    }
    solution.toggled = (0..columns.len()).filter(|&c| flips[c]).collect();
    solution
}

/// Number of the component of each face, the outside left out.
fn components(graph: &[Vec<(usize, usize)>], outside: usize) -> Vec<usize> {
    let mut of = vec![usize::MAX; outside];
    let mut n = 0;
    for start in 0..outside {
        if of[start] != usize::MAX {
            continue;
        }
        of[start] = n;
        let mut stack = vec![start];
        while let Some(f) = stack.pop() {
            for &(g, _) in &graph[f] {
                if g != outside && of[g] == usize::MAX {
                    of[g] = n;
                    stack.push(g);
                }
            }
        }
        n += 1;
    }
    of
}

/// Changes edges of three and more faces so that components without a way outside become even in total: elimination
/// over GF(2), cheap columns first as pivots. `odd` is brought up to date.
fn join_components(
    n_faces: usize,
    columns: &[Column],
    component: &[usize],
    open: &[bool],
    odd: &mut [bool],
) -> Vec<bool> {
    let mut flips = vec![false; columns.len()];
    let mut total = vec![false; open.len()];
    for f in 0..n_faces {
        total[component[f]] ^= odd[f];
    }
    let needs = (0..open.len()).any(|k| total[k] && !open[k]);
    let mut wide: Vec<usize> =
        (0..columns.len()).filter(|&c| columns[c].cost.is_some() && columns[c].faces.len() > 2).collect();
    if !needs || wide.is_empty() {
        return flips;
    }
    let cost = |c: usize| columns[c].cost.unwrap_or(f64::INFINITY);
    wide.sort_by(|a, b| cost(*a).total_cmp(&cost(*b)).then(a.cmp(b)));
    // Columns as sets of components; the basis is kept with its leading component, each with the columns it is made of.
    let rows = |c: usize| -> Vec<usize> {
        let mut r: Vec<usize> =
            columns[c].faces.iter().map(|&f| component[f]).filter(|&k| !open[k]).collect();
        r.sort_unstable();
        xor_runs(&r)
    };
    let mut basis: Vec<Option<(Vec<usize>, Vec<usize>)>> = vec![None; open.len()];
    let reduce = |basis: &[Option<(Vec<usize>, Vec<usize>)>], mut r: Vec<usize>, mut made: Vec<usize>| {
        let mut from = 0;
        while let Some(&lead) = r.get(from) {
            match &basis[lead] {
                Some((b, of)) => {
                    r = xor(&r, b);
                    made = xor(&made, of);
                    from = r.partition_point(|&k| k <= lead);
                }
                None => from += 1,
            }
        }
        (r, made)
    };
    for &c in &wide {
        let (r, made) = reduce(&basis, rows(c), vec![c]);
        if let Some(&lead) = r.iter().find(|&&k| basis[k].is_none()) {
            basis[lead] = Some((r, made));
        }
    }
    let wanted: Vec<usize> = (0..open.len()).filter(|&k| total[k] && !open[k]).collect();
    // What is left of the right side after the reduction stays odd and is reported by the caller.
    let (_, made) = reduce(&basis, wanted, Vec::new());
    for c in made {
        flips[c] = true;
        for &f in &columns[c].faces {
            odd[f] = !odd[f];
        }
    }
    flips
}

/// The members of a sorted list that occur an odd number of times.
fn xor_runs(sorted: &[usize]) -> Vec<usize> {
    sorted.chunk_by(|a, b| a == b).filter(|r| r.len() % 2 == 1).filter_map(|r| r.first().copied()).collect()
}

/// Symmetric difference of two sets.
fn xor(a: &[usize], b: &[usize]) -> Vec<usize> {
    let mut all: Vec<usize> = a.iter().chain(b).copied().collect();
    all.sort_unstable();
    xor_runs(&all)
}

/// Shortest paths from `start`: distance and the edge by which each vertex is reached.
struct Paths {
    distance: Vec<f64>,
    from: Vec<Option<(usize, usize)>>,
}

/// Dijkstra from the given starts; `owner` says which start a vertex belongs to.
fn dijkstra(graph: &[Vec<(usize, usize)>], columns: &[Column], starts: &[usize]) -> (Paths, Vec<usize>) {
    let n = graph.len();
    let mut p = Paths { distance: vec![f64::INFINITY; n], from: vec![None; n] };
    let mut owner = vec![usize::MAX; n];
    let mut heap = BinaryHeap::new();
    for (k, &s) in starts.iter().enumerate() {
        p.distance[s] = 0.0;
        owner[s] = k;
        heap.push((Reverse(0_u64), Reverse(s)));
    }
    while let Some((Reverse(bits), Reverse(v))) = heap.pop() {
        // Distances are not negative, so that their bits sort as they do.
        if bits != p.distance[v].to_bits() {
            continue;
        }
        for &(w, c) in &graph[v] {
            let d = p.distance[v] + columns[c].cost.unwrap_or(f64::INFINITY);
            if d < p.distance[w] {
                p.distance[w] = d;
                p.from[w] = Some((v, c));
                owner[w] = owner[v];
                heap.push((Reverse(d.to_bits()), Reverse(w)));
            }
        }
    }
    (p, owner)
}

/// Flips the edges of the path that ends in `v`.
fn flip_path(paths: &Paths, mut v: usize, flips: &mut [bool]) {
    while let Some((u, c)) = paths.from[v] {
        flips[c] = !flips[c];
        v = u;
    }
}

/// Pairs an even number of vertices of one component along short paths.
fn pair_up(graph: &[Vec<(usize, usize)>], columns: &[Column], mut terminals: Vec<usize>, flips: &mut [bool]) {
    while terminals.len() > EXACT {
        let before = terminals.len();
        // Grow around all at once; where two grown areas meet, the two are a candidate pair.
        let (paths, owner) = dijkstra(graph, columns, &terminals);
        let mut meetings: Vec<(f64, usize, usize, usize)> = Vec::new();
        for (v, list) in graph.iter().enumerate() {
            for &(w, c) in list.iter().filter(|(w, _)| *w > v) {
                let reached = owner[v] != usize::MAX && owner[w] != usize::MAX;
                if reached && owner[v] != owner[w] {
                    let d = paths.distance[v] + paths.distance[w] + columns[c].cost.unwrap_or(f64::INFINITY);
                    meetings.push((d, c, v, w));
                }
            }
        }
        meetings.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2, a.3).cmp(&(b.1, b.2, b.3))));
        let mut used = vec![false; terminals.len()];
        for (_, c, v, w) in meetings {
            if used[owner[v]] || used[owner[w]] {
                continue;
            }
            (used[owner[v]], used[owner[w]]) = (true, true);
            flips[c] = !flips[c];
            flip_path(&paths, v, flips);
            flip_path(&paths, w, flips);
        }
        let mut k = 0;
        terminals.retain(|_| {
            k += 1;
            !used[k - 1]
        });
        if terminals.len() == before {
            return;
        }
    }
    let n = terminals.len();
    if n < 2 {
        return;
    }
    let paths: Vec<Paths> = terminals.iter().map(|&t| dijkstra(graph, columns, &[t]).0).collect();
    let d = |i: usize, j: usize| paths[i].distance[terminals[j]];
    // best[set]: the least cost of pairing up the members of the set, and the last pair.
    let mut best = vec![(f64::INFINITY, (0, 0)); 1 << n];
    best[0] = (0.0, (0, 0));
    for set in 1_usize..1 << n {
        if set.count_ones() % 2 == 1 {
            continue;
        }
        let i = set.trailing_zeros() as usize;
        for j in (i + 1..n).filter(|j| set >> j & 1 == 1) {
            let cost = best[set & !(1 << i) & !(1 << j)].0 + d(i, j);
            if cost < best[set].0 {
                best[set] = (cost, (i, j));
            }
        }
    }
    let mut set = (1 << n) - 1;
    while set != 0 && best[set].0.is_finite() {
        let (i, j) = best[set].1;
        flip_path(&paths[i], terminals[j], flips);
        set &= !(1 << i) & !(1 << j);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn col(faces: &[usize], cost: f64) -> Column {
        Column { faces: faces.to_vec(), cost: Some(cost) }
    }

    fn after(n: usize, columns: &[Column], odd: &[bool], s: &Solution) -> Vec<usize> {
        let mut odd = odd.to_vec();
        for &c in &s.toggled {
            for &f in &columns[c].faces {
                odd[f] = !odd[f];
            }
        }
        (0..n).filter(|&f| odd[f]).collect()
    }

    #[test]
    fn two_odd_faces_change_the_cheap_path() {
        let columns = [col(&[0, 1], 1.0), col(&[1, 2], 1.0), col(&[0, 2], 3.0)];
        let s = solve(3, &columns, &[true, false, true]);
        assert_eq!(s.toggled, [0, 1]);
        assert!(s.odd_components.is_empty());
    }

    #[test]
    fn one_odd_face_uses_a_free_edge() {
        let columns = [col(&[0, 1], 1.0), col(&[1], 1.0)];
        let s = solve(2, &columns, &[true, false]);
        assert_eq!(s.toggled, [0, 1]);
    }

    #[test]
    fn frozen_edges_make_it_infeasible() {
        let columns = [Column { faces: vec![0], cost: None }];
        let s = solve(1, &columns, &[true]);
        assert_eq!(s.odd_components, [vec![0]]);
    }

    #[test]
    fn three_sheets_on_one_edge() {
        // Edge 0 is shared by three sheets whose other edges are frozen: all odd, one change cures all.
        let columns = [col(&[0, 1, 2], 1.0)];
        let s = solve(3, &columns, &[true, true, true]);
        assert_eq!(s.toggled, [0]);
        assert!(s.odd_components.is_empty());
        let s = solve(3, &columns, &[true, false, false]);
        assert!(!s.odd_components.is_empty());
    }

    proptest! {
        #[test]
        fn closed_surfaces_become_even(n in 4_usize..60, seed in 0_u64..1000) {
            // A ring of faces with chords: closed, so that an even number of odd faces can always be paired.
            let mut x = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let mut next = || { x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407); (x >> 33) as usize };
            let mut columns: Vec<Column> = (0..n).map(|i| { let mut f = vec![i, (i + 1) % n]; f.sort_unstable(); col(&f, 1.0) }).collect();
            for _ in 0..n {
                let (a, b) = (next() % n, next() % n);
                if a != b {
                    columns.push(col(&[a.min(b), a.max(b)], 0.1 + (next() % 100) as f64 / 50.0));
                }
            }
            let mut odd: Vec<bool> = (0..n).map(|_| next() % 2 == 0).collect();
            if odd.iter().filter(|o| **o).count() % 2 == 1 { odd[0] = !odd[0]; }
            let s = solve(n, &columns, &odd);
            prop_assert!(s.odd_components.is_empty());
            prop_assert_eq!(after(n, &columns, &odd, &s), Vec::<usize>::new());
        }
    }
}
