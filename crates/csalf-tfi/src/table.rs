//! The frozen table of patterns.

use crate::pattern::{Pattern, PatternData};
use std::sync::OnceLock;

const fn data(
    name: &'static str,
    n_corners: u8,
    sides: &'static [u8],
    n_boundary: u8,
    quads: &'static [[u8; 4]],
) -> PatternData {
    PatternData { name, n_corners, sides, n_boundary, quads }
}

/// All patterns, by number of corners; mirror images are derived, not stored.
pub const TABLE: &[PatternData] = &[
    data(
        "disk",
        0,
        &[0, 1, 2, 3],
        4,
        &[[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]],
    ),
    data("tri", 3, &[0, 2, 4], 6, &[[0, 1, 6, 5], [2, 3, 6, 1], [4, 5, 6, 3]]),
    data("reg", 4, &[0, 1, 2, 3], 4, &[[0, 1, 2, 3]]),
    data(
        "pent",
        5,
        &[0, 2, 4, 6, 8],
        10,
        &[[0, 1, 10, 9], [2, 3, 10, 1], [4, 5, 10, 3], [6, 7, 10, 5], [8, 9, 10, 7]],
    ),
];

/// The patterns of `n` corners and their mirror images, derived once per process.
pub fn patterns(n: usize) -> &'static [Pattern] {
    static ALL: OnceLock<Vec<Vec<Pattern>>> = OnceLock::new();
    let all = ALL.get_or_init(|| {
        (0..=crate::pattern::MAX_SIDES)
            .map(|n| {
                let mut list: Vec<Pattern> = Vec::new();
                for d in TABLE.iter().filter(|d| usize::from(d.n_corners) == n) {
                    let p = Pattern::new(d);
                    let m = p.mirrored();
                    let symmetric = (0..p.n_boundary).any(|r| p.is_rotation_of(&m, r));
                    list.push(p);
                    if !symmetric {
                        list.push(m);
                    }
                }
                list
            })
            .collect()
    });
    all.get(n).map_or(&[], |v| v)
}
