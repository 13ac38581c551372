//! Which scar segments must get a node so that all regions have an even number of segments.
//!
//! ```text
//!    ┌────────┬────────┐     A node added to a scar segment between two regions changes the parity of both. The
//!    │ odd    │   odd  │     regions are the nodes of a graph, the scars between them its edges; we look for a
//!    │        ×        │     set of edges that has an odd degree at exactly the odd regions: a T-join. A path of
//!    └────────┴────────┘     such edges between two odd regions is one.
//! ```
//!
//! 1. Of all scar segments between the same two regions, the longest is taken: halving it hurts least.
//! 2. Each odd region is joined to the nearest odd one by the fewest steps (breadth first).
//! 3. A segment that two paths use is not split at all: both changes cancel.
//!
//! Cost O(odd regions * region borders). Source: handbook 10.2 (there with weights and an optimal matching; scars
//! that cut off several odd regions are rare, so pairs are matched greedily).

use std::collections::BTreeSet;

/// A scar segment between two different regions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Border {
    /// The two regions, smaller first.
    pub(crate) regions: [u32; 2],
    /// Its length.
    pub(crate) length: f64,
    /// The caller's name for it; of equally long ones the smallest is taken.
    pub(crate) segment: u32,
}

/// For each pair of odd regions, the two regions and the segments that each get a node. An odd region without
/// partner is left out (the total is odd then).
pub(crate) fn pair_odd_regions(is_odd: &[bool], mut borders: Vec<Border>) -> Vec<([u32; 2], BTreeSet<u32>)> {
    borders.sort_by(|a, b| {
        a.regions.cmp(&b.regions).then(b.length.total_cmp(&a.length)).then(a.segment.cmp(&b.segment))
    });
    borders.dedup_by(|later, kept| later.regions == kept.regions);
    let n = is_odd.len();
    let mut neighbors: Vec<Vec<(u32, u32)>> = vec![Vec::new(); n];
    for b in &borders {
        let [r, s] = b.regions;
        neighbors[r as usize].push((s, b.segment));
        neighbors[s as usize].push((r, b.segment));
    }
    let mut waiting = is_odd.to_vec();
    let mut pairs = Vec::new();
    for from in 0..n {
        if !waiting[from] {
            continue;
        }
        waiting[from] = false;
        let mut came_by: Vec<Option<(u32, u32)>> = vec![None; n];
        let mut queue = vec![from as u32];
        let mut k = 0;
        let mut partner = None;
        while k < queue.len() && partner.is_none() {
            let r = queue[k];
            k += 1;
            for &(s, segment) in &neighbors[r as usize] {
                if s as usize != from && came_by[s as usize].is_none() {
                    came_by[s as usize] = Some((r, segment));
                    queue.push(s);
                    if waiting[s as usize] && partner.is_none() {
                        partner = Some(s);
                    }
                }
            }
        }
        let Some(to) = partner else { continue };
        waiting[to as usize] = false;
        let (mut path, mut r) = (BTreeSet::new(), to);
        while let Some((before, segment)) = came_by[r as usize] {
            path.insert(segment);
            r = before;
        }
        pairs.push(([from as u32, to], path));
    }
    pairs
}

/// The segments that get a node: those on an odd number of paths.
pub(crate) fn segments_to_split(pairs: &[([u32; 2], BTreeSet<u32>)]) -> BTreeSet<u32> {
    pairs.iter().fold(BTreeSet::new(), |all, (_, path)| &all ^ path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn border(r: u32, s: u32, length: f64, segment: u32) -> Border {
        Border { regions: [r, s], length, segment }
    }

    #[test]
    fn a_chain_of_regions_is_cured_end_to_end() {
        let borders = vec![border(0, 1, 1.0, 10), border(0, 1, 2.0, 11), border(1, 2, 1.0, 12)];
        let pairs = pair_odd_regions(&[true, false, true], borders);
        assert_eq!(pairs.len(), 1);
        assert_eq!(segments_to_split(&pairs).into_iter().collect::<Vec<_>>(), [11, 12]);
    }

    #[test]
    fn paths_that_cover_each_other_cancel() {
        // A star: all of 1..=4 hang on 0. Whatever the pairs are, every odd region ends up even.
        let borders: Vec<_> = (1..5).map(|r| border(0, r, 1.0, r)).collect();
        let pairs = pair_odd_regions(&[false, true, true, true, true], borders);
        assert_eq!(segments_to_split(&pairs).len(), 4);
        let pairs = pair_odd_regions(
            &[true, true, true, true, false],
            (1..5).map(|r| border(0, r, 1.0, r)).collect(),
        );
        let split = segments_to_split(&pairs);
        assert!(split.len() == 3 && !split.contains(&4));
    }

    #[test]
    fn an_odd_region_too_many_is_left_alone() {
        let pairs = pair_odd_regions(&[true, true, true], vec![border(0, 1, 1.0, 0), border(1, 2, 1.0, 1)]);
        assert_eq!(pairs.len(), 1);
    }
}
