//! Small disks: all quadrangulations of a rim of 4 to 10 vertices with few inner vertices.
//!
//! ```text
//!      4: one quad        6: three cuts, two stars of three        8: twelve cuts, stars of 3 and 4, ...
//!      o───o                 o──o      o──o
//!      │   │                /│  │\    /  / \                        the quad on the rim edge 0-1 is chosen, and
//!      o───o               o │  │ o  o──o───o                       what is left is cut in the same way
//!                           \│  │/    \  \ /
//!                            o──o      o──o
//! ```
//!
//! 1. The quad on the first edge of a polygon has its other two corners on the polygon or new inside; up to three
//!    smaller polygons remain. Every quadrangulation is met exactly once.
//! 2. Those with an inner vertex of two quads are dropped.
//! 3. That takes milliseconds, so the result is a table ([`table`]); a test makes it anew and compares.
//!
//! All rotations and reflections are in the list: nobody has to turn a rim. Source: handbook 4.9 (the classes up to
//! symmetry, here re-derived) and 6.3.

mod table;

use std::sync::OnceLock;

/// Largest rim.
pub const MAX_RIM: usize = 10;
/// One quadrangulation of a rim. Names below the length of the rim are its vertices, counter-clockwise.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Disk {
    /// Number of quads at each rim vertex.
    pub rim: [u8; MAX_RIM],
    /// Number of quads at each inner vertex.
    pub inner: Vec<u8>,
    /// The quads, counter-clockwise.
    pub quads: &'static [[u8; 4]],
}

/// All disks with a rim of `n` vertices; none if `n` is odd, below 4 or above [`MAX_RIM`].
pub fn disks(n: usize) -> &'static [Disk] {
    static DISKS: OnceLock<[Vec<Disk>; table::DISKS.len()]> = OnceLock::new();
    let all = DISKS.get_or_init(|| {
        std::array::from_fn(|k| table::DISKS[k].iter().map(|quads| Disk::new(quads, 2 * k + 4)).collect())
    });
    if n.is_multiple_of(2) && n >= 4 { all.get(n / 2 - 2).map_or(&[], Vec::as_slice) } else { &[] }
}

impl Disk {
    /// A disk by its quads on a rim of `n` vertices.
    fn new(quads: &'static [[u8; 4]], n: usize) -> Self {
        let mut out = Self { rim: [0; MAX_RIM], inner: Vec::new(), quads };
        for &v in quads.iter().flatten() {
            let v = usize::from(v);
            if v < n {
                out.rim[v] += 1;
            } else {
                out.inner.resize(out.inner.len().max(v + 1 - n), 0);
                out.inner[v - n] += 1;
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Most inner vertices, by half the rim's length: beyond, a disk is no local change any more, and the list grows
    /// tenfold with each.
    const MOST_INNER: [usize; MAX_RIM / 2 + 1] = [0, 0, 0, 2, 2, 1];

    fn make(n: usize) -> Vec<Vec<[u8; 4]>> {
        let mut out = Vec::new();
        let most = n + MOST_INNER[n / 2];
        grow(vec![(0..n as u8).collect()], n, most, &mut Vec::new(), n, &mut out);
        // Fewest quads first: of equals the first is taken.
        out.sort_by_key(Vec::len);
        out
    }

    /// Fills the open polygons, the last first; vertices up to `most` may be made, `next` have been.
    fn grow(
        mut open: Vec<Vec<u8>>,
        next: usize,
        most: usize,
        quads: &mut Vec<[u8; 4]>,
        n: usize,
        out: &mut Vec<Vec<[u8; 4]>>,
    ) {
        let Some(p) = open.pop() else {
            out.extend(finished(quads, n, next));
            return;
        };
        let m = p.len();
        let mut go = |open: Vec<Vec<u8>>, quad: [u8; 4], next: usize| {
            quads.push(quad);
            grow(open, next, most, quads, n, out);
            quads.pop();
        };
        // What is left of the polygon if it is more than an edge.
        let rest = |open: &[Vec<u8>], parts: &[Vec<u8>]| -> Vec<Vec<u8>> {
            open.iter().chain(parts.iter().filter(|q| q.len() > 2)).cloned().collect()
        };
        let closing = |k: usize| -> Vec<u8> { p[k..].iter().copied().chain([p[0]]).collect() };
        for j in (2..m).step_by(2) {
            for k in (j + 1..m).step_by(2) {
                let parts = [p[1..=j].to_vec(), p[j..=k].to_vec(), closing(k)];
                go(rest(&open, &parts), [p[0], p[1], p[j], p[k]], next);
            }
        }
        let new = next as u8;
        if next < most {
            for j in (2..m).step_by(2) {
                let mut b = closing(j);
                b.push(new);
                go(rest(&open, &[p[1..=j].to_vec(), b]), [p[0], p[1], p[j], new], next + 1);
            }
            for k in (3..m).step_by(2) {
                let mut a = p[1..=k].to_vec();
                a.push(new);
                go(rest(&open, &[a, closing(k)]), [p[0], p[1], new, p[k]], next + 1);
            }
        }
        if next + 1 < most {
            let mut a = closing(1);
            a.extend([new + 1, new]);
            go(rest(&open, &[a]), [p[0], p[1], new, new + 1], next + 2);
        }
    }

    /// The quads, if there is no inner vertex of two of them.
    fn finished(quads: &[[u8; 4]], n: usize, n_vertices: usize) -> Option<Vec<[u8; 4]>> {
        let at = |v: usize| quads.iter().flatten().filter(|&&w| usize::from(w) == v).count();
        (n..n_vertices).all(|v| at(v) >= 3).then(|| quads.to_vec())
    }

    #[test]
    fn the_table_is_what_the_rules_make() {
        for n in [4, 6, 8, 10] {
            let made = make(n);
            assert!(disks(n).iter().map(|d| d.quads).eq(made.iter().map(Vec::as_slice)), "{n}");
        }
    }

    #[test]
    fn counts_without_inner_vertices_are_known() {
        // Quadrangulations of a polygon: 1, 3, 12, 55 (ternary trees).
        for (n, want) in [(4, 1), (6, 3), (8, 12), (10, 55)] {
            assert_eq!(disks(n).iter().filter(|d| d.inner.is_empty()).count(), want, "{n}");
        }
        assert!(disks(5).is_empty() && disks(2).is_empty() && disks(12).is_empty());
        // Two stars of three in a hexagon.
        assert_eq!(disks(6).iter().filter(|d| d.inner == [3]).count(), 2);
    }

    #[test]
    fn every_disk_is_a_disk() {
        for n in [4, 6, 8, 10] {
            for (i, d) in disks(n).iter().enumerate() {
                // Each inner edge twice, once in each direction; each rim edge once.
                let mut edges: Vec<(u8, u8)> =
                    d.quads.iter().flat_map(|q| (0..4).map(|k| (q[k], q[(k + 1) & 3]))).collect();
                edges.sort_unstable();
                assert!(edges.windows(2).all(|w| w[0] != w[1]), "{n} {i}");
                let once = edges.iter().filter(|&&(a, b)| edges.binary_search(&(b, a)).is_err()).count();
                assert_eq!(once, n, "{n} {i}");
                assert!((0..n as u8).all(|v| edges.binary_search(&(v, (v + 1) % n as u8)).is_ok()));
                // Euler, and the charge of a disk.
                assert_eq!(2 * d.quads.len() + 2, n + 2 * d.inner.len());
                let charge: i32 = d.inner.iter().map(|&v| 4 - i32::from(v)).sum::<i32>()
                    + d.rim[..n].iter().map(|&v| 2 - i32::from(v)).sum::<i32>();
                assert_eq!(charge, 4, "{n} {i}");
                assert!(disks(n)[..i].iter().all(|o| {
                    let key = |d: &Disk| {
                        let mut q: Vec<_> = d.quads.to_vec();
                        q.iter_mut().for_each(|q| {
                            let k = (0..4).min_by_key(|&k| q[k]).unwrap_or(0);
                            q.rotate_left(k);
                        });
                        q.sort_unstable();
                        q
                    };
                    key(o) != key(d)
                }));
            }
        }
    }
}
