//! Enumerates all quad meshes of a disk with few nodes: the source of the stencil table.
//!
//! The quad on the first side (p0, p1) of a polygon has two more corners, each a node of the polygon or a new one.
//! Cutting it off leaves polygons with fewer free nodes; the recursion over all choices meets every labelled mesh
//! once. Meshes that a rotation, reflection or renaming of inner nodes takes into each other are one class.

pub(super) type Quads = Vec<[u8; 4]>;

/// All classes of `n` rim nodes (0..n) and `inner` inner nodes (n..) of valence at least 3, each by its smallest
/// member, in ascending order.
pub(super) fn classes(n: u8, inner: u8) -> Vec<Quads> {
    let mut found = Vec::new();
    cut(vec![(0..n).collect()], n, n + inner, &mut Vec::new(), &mut found);
    let mut all: Vec<Quads> =
        found.into_iter().filter(|q| sound(q, n, inner)).map(|q| canonical(&q, n, inner)).collect();
    all.sort();
    all.dedup();
    all
}

/// Fills the open polygons in all ways. Inner nodes `next..end` are still unused; all must be used.
fn cut(mut open: Vec<Vec<u8>>, next: u8, end: u8, quads: &mut Quads, found: &mut Vec<Quads>) {
    let Some(p) = open.pop() else {
        if next == end {
            found.push(quads.clone());
        }
        return;
    };
    let n = p.len();
    let mut go = |x: u8, y: u8, parts: Vec<Vec<u8>>, next: u8| {
        if parts.iter().any(|q| q.len() % 2 == 1) {
            return;
        }
        let mut rest = open.clone();
        rest.extend(parts.into_iter().filter(|q| q.len() > 2));
        quads.push([p[0], p[1], x, y]);
        cut(rest, next, end, quads, found);
        quads.pop();
    };
    let part = |from: usize, to: usize, more: &[u8]| -> Vec<u8> {
        (from..=to).map(|i| p[i % n]).chain(more.iter().copied()).collect()
    };
    for j in 2..n {
        for k in j + 1..n {
            go(p[j], p[k], vec![part(1, j, &[]), part(j, k, &[]), part(k, n, &[])], next);
        }
        if next < end {
            go(next, p[j], vec![part(1, j, &[next]), part(j, n, &[])], next + 1);
            go(p[j], next, vec![part(1, j, &[]), part(j, n, &[next])], next + 1);
        }
    }
    if next + 1 < end {
        go(next, next + 1, vec![part(1, n, &[next + 1, next])], next + 2);
    }
}

/// No edge twice in one direction, no inner node of valence 2, no two quads with three common nodes.
fn sound(quads: &Quads, n: u8, inner: u8) -> bool {
    let mut sides: Vec<(u8, u8)> =
        quads.iter().flat_map(|q| (0..4).map(|k| (q[k], q[(k + 1) % 4]))).collect();
    sides.sort_unstable();
    let valence = |v: u8| quads.iter().filter(|q| q.contains(&v)).count();
    let common = |a: &[u8; 4], b: &[u8; 4]| a.iter().filter(|v| b.contains(v)).count();
    sides.windows(2).all(|w| w[0] != w[1])
        && (n..n + inner).all(|v| valence(v) >= 3)
        && (0..quads.len()).all(|i| (0..i).all(|j| common(&quads[i], &quads[j]) <= 2))
}

/// The smallest of all images under rotations, reflections and renamings.
fn canonical(quads: &Quads, n: u8, inner: u8) -> Quads {
    let mut best: Option<Quads> = None;
    for order in permutations(inner) {
        for reflect in [false, true] {
            for shift in 0..n {
                let image = place(quads, n, shift, reflect, &order);
                if best.as_ref().is_none_or(|b| image < *b) {
                    best = Some(image);
                }
            }
        }
    }
    best.unwrap_or_default()
}

/// The image of `quads`: rim node i goes to `shift + i` or `shift - i`, inner node k to `order[k]`.
fn place(quads: &Quads, n: u8, shift: u8, reflect: bool, order: &[u8]) -> Quads {
    let to = |v: u8| match v {
        v if v >= n => n + order[(v - n) as usize],
        v if reflect => (shift + n - v) % n,
        v => (shift + v) % n,
    };
    let mut image: Quads = quads
        .iter()
        .map(|q| {
            let mut q = q.map(to);
            if reflect {
                q.reverse();
            }
            let first = (0..4).min_by_key(|&k| q[k]).unwrap_or(0);
            q.rotate_left(first);
            q
        })
        .collect();
    image.sort_unstable();
    image
}

fn permutations(n: u8) -> Vec<Vec<u8>> {
    if n == 0 {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for rest in permutations(n - 1) {
        for at in 0..=rest.len() {
            let mut p = rest.clone();
            p.insert(at, n - 1);
            all.push(p);
        }
    }
    all
}

/// Number of different images of a mesh under rotations and reflections.
pub(super) fn images(quads: &Quads, n: u8, inner: u8) -> usize {
    let orders = permutations(inner);
    let mut all = Vec::new();
    for reflect in [false, true] {
        for shift in 0..n {
            all.push(orders.iter().map(|o| place(quads, n, shift, reflect, o)).min());
        }
    }
    all.sort();
    all.dedup();
    all.len()
}
