//! The validated planar graph of a domain: nodes numbered, loops oriented, regions as closed walks.
//!
//! ```text
//!      ┌─────────────────┐        A scar that hangs on a loop makes its walk run out and back (a-b-c-b-a);
//!      │   ┌┐  e──f      │        a floating scar is a walk of its own (e-f), a hole another one; scars from loop
//!      │   └┘            a        to loop cut the domain into regions, or join walks into one.
//!      │          c──b───┤
//!      └─────────────────┘
//! ```
//!
//! 1. `check`: numbers and merges nodes, orients loops, or reports all defects.
//! 2. `graph`: half-edges, faces, walks.
//! 3. `regions`: inner walks and hard points go to the region found by a ray to the left.
//! 4. `pair_odd_regions` (`parity`): the cure of odd regions.
//!
//! Guarantees: nodes bit-equal to the input; the same regions, in the same order, starting at the same nodes,
//! whatever the start nodes and orientations of the loops. Cost O(n log n). Source: handbook 0.2, 4.2, 10.2.

use crate::check::{Checked, check};
use crate::defect::Notice;
use crate::graph::{Graph, NO_WALK, Walk, left_to_right};
use crate::parity::{Border, pair_odd_regions, segments_to_split};
use crate::polygon::signed_area;
use crate::{Defect, Domain, Place, Point2, Tolerance};
use std::collections::BTreeSet;

/// What a caller accepts or wants repaired.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct CheckOptions {
    /// Accept odd totals and odd regions (quad-dominant meshes).
    pub allow_odd: bool,
    /// Add a node to scar segments so that all regions become even.
    pub repair_parity: bool,
}

/// A connected area to be meshed, as walks with the material on the left. A walk is a cyclic list of node
/// occurrences; it starts at its leftmost node (of several, the lowest).
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The walk around the region.
    pub outer: Vec<u32>,
    /// Walks round what lies in it: holes, floating scars (a scar of e segments has 2e occurrences), groups of
    /// them; a hard point is a walk of one node.
    pub inner: Vec<Vec<u32>>,
}

impl Region {
    /// Number of segments round the region; both sides of a scar count, hard points do not.
    pub fn n_segments(&self) -> usize {
        let n = |w: &Vec<u32>| if w.len() > 1 { w.len() } else { 0 };
        n(&self.outer) + self.inner.iter().map(n).sum::<usize>()
    }
}

/// The validated planar graph of a [`Domain`].
#[derive(Clone, Debug, PartialEq)]
pub struct Arrangement {
    /// Distinct nodes, bit-equal to the input: the nodes of the loops in order, then those of scars and hard points
    /// that are not on earlier ones, then nodes added by the repair of parity.
    pub points: Vec<Point2>,
    /// Nodes of each loop, in the order of `domain.loops`, starting at the same node; outer counter-clockwise, holes
    /// clockwise (reversed where the input is not).
    pub loops: Vec<Vec<u32>>,
    /// Nodes of each scar, in the order of the input. A node that lies on a loop or another scar is that one's.
    pub scars: Vec<Vec<u32>>,
    /// Node of each hard point; an earlier node if it lies on one.
    pub hard_points: Vec<u32>,
    /// Areas to be meshed, ordered by their leftmost node.
    pub regions: Vec<Region>,
    /// Nodes added by the repair of parity: number of the scar, node.
    pub added_nodes: Vec<(usize, u32)>,
    /// What is allowed but likely to give poor quads.
    pub notices: Vec<Notice>,
    /// Length thresholds of the domain.
    pub tolerance: Tolerance,
    /// Area of all regions, > 0.
    pub area: f64,
}

impl Domain {
    /// Everything that is wrong with the domain; empty if it can be meshed. Cost O(n log n).
    pub fn check(&self) -> Vec<Defect> {
        Arrangement::new(self, &CheckOptions::default()).err().unwrap_or_default()
    }
}

impl Arrangement {
    /// Checks a domain and builds its graph.
    ///
    /// # Errors
    /// All defects of the domain. Wrong orientation and a first node repeated at the end are no defects.
    pub fn new(domain: &Domain, options: &CheckOptions) -> Result<Self, Vec<Defect>> {
        let Checked { points, loops, scars, hard_points, tolerance, odd_total, notices } =
            check(domain, options.allow_odd)?;
        let mut defects: Vec<_> = odd_total.into_iter().collect();
        let area =
            loops.iter().map(|l| signed_area(&l.iter().map(|&v| points[v as usize]).collect::<Vec<_>>()));
        let mut out = Self {
            area: area.sum(),
            points,
            loops,
            scars,
            hard_points,
            regions: Vec::new(),
            added_nodes: Vec::new(),
            notices,
            tolerance,
        };
        let borders = out.regions(domain)?;
        let is_odd: Vec<_> = out.regions.iter().map(|r| r.n_segments() % 2 == 1).collect();
        if options.allow_odd || !is_odd.contains(&true) {
            return if defects.is_empty() { Ok(out) } else { Err(defects) };
        }
        let pairs = pair_odd_regions(&is_odd, borders);
        if options.repair_parity && defects.is_empty() {
            out.split(&segments_to_split(&pairs));
            out.regions(domain)?;
            return Ok(out);
        }
        if out.regions.len() > 1 {
            for (r, _) in is_odd.iter().enumerate().filter(|(_, odd)| **odd) {
                let path = pairs.iter().find(|(pair, _)| pair.contains(&(r as u32)));
                let cure =
                    path.map_or(Vec::new(), |(_, p)| p.iter().map(|&s| out.scar_place(domain, s)).collect());
                let Point2 { x, y } = out.points[out.regions[r].outer[0] as usize];
                defects.push(Defect::OddRegion { n_segments: out.regions[r].n_segments(), x, y, cure });
            }
        }
        if defects.is_empty() { Ok(out) } else { Err(defects) }
    }

    /// Scar and segment of it for a number that counts all scar segments in order.
    fn scar_segment(&self, number: u32) -> (usize, usize) {
        let mut i = number as usize;
        for (k, s) in self.scars.iter().enumerate() {
            if i + 1 < s.len() {
                return (k, i);
            }
            i -= s.len() - 1;
        }
        (0, 0)
    }

    fn scar_place(&self, domain: &Domain, number: u32) -> Place {
        let (k, i) = self.scar_segment(number);
        let Point2 { x, y } = self.points[self.scars[k][i] as usize];
        Place { name: domain.scars[k].name.clone(), index: i, x, y }
    }

    /// Adds a node in the middle of these scar segments.
    fn split(&mut self, segments: &BTreeSet<u32>) {
        // From the last on, so that the numbers of the others stay.
        for &segment in segments.iter().rev() {
            let (k, i) = self.scar_segment(segment);
            let scar = &mut self.scars[k];
            let middle = self.points[scar[i] as usize].midpoint(self.points[scar[i + 1] as usize]);
            let v = self.points.len() as u32;
            self.points.push(middle);
            scar.insert(i + 1, v);
            self.added_nodes.push((k, v));
        }
    }

    /// Finds the regions; returns the scar segments between two of them.
    fn regions(&mut self, domain: &Domain) -> Result<Vec<Border>, Vec<Defect>> {
        let graph = Graph::new(&self.points, &self.loops, &self.scars);
        let (walks, walk_of) = graph.walks();
        let tree = graph.tree();
        let nodes = |w: &Walk| w.half_edges.iter().map(|&h| graph.node(h)).collect::<Vec<_>>();

        let mut region_of_walk = vec![NO_WALK; walks.len()];
        let mut regions = Vec::new();
        for (k, w) in walks.iter().enumerate().filter(|(_, w)| !w.is_inner) {
            region_of_walk[k] = regions.len() as u32;
            regions.push(Region { outer: nodes(w), inner: Vec::new() });
        }
        let mut lost = Vec::new();
        let locate = |v: u32, region_of_walk: &[u32]| {
            let h = graph.locate(&tree, self.points[v as usize])?;
            let w = walk_of[h as usize];
            let r = if w == NO_WALK { NO_WALK } else { region_of_walk[w as usize] };
            (r != NO_WALK).then_some(r)
        };
        // Walks are sorted from left to right, so what a ray to the left meets is settled already.
        for (k, w) in walks.iter().enumerate().filter(|(_, w)| w.is_inner) {
            match locate(graph.node(w.half_edges[0]), &region_of_walk) {
                Some(r) => {
                    region_of_walk[k] = r;
                    regions[r as usize].inner.push(nodes(w));
                }
                None => lost.push(graph.node(w.half_edges[0])),
            }
        }
        let mut singles: Vec<u32> = Vec::new();
        let mut has_edge = vec![false; self.points.len()];
        for &v in self.loops.iter().chain(&self.scars).flatten() {
            has_edge[v as usize] = true;
        }
        for &v in &self.hard_points {
            if !has_edge[v as usize] {
                has_edge[v as usize] = true;
                singles.push(v);
            }
        }
        for v in singles {
            match locate(v, &region_of_walk) {
                Some(r) => regions[r as usize].inner.push(vec![v]),
                None => lost.push(v),
            }
        }
        if !lost.is_empty() {
            // Cannot happen after the checks; still no reason to crash.
            return Err(lost.into_iter().map(|v| self.outside(domain, v)).collect());
        }
        let at = |w: &Vec<u32>| self.points[w[0] as usize];
        for r in &mut regions {
            r.inner.sort_by(|a, b| left_to_right(at(a), at(b)));
        }

        let n_loop_edges: usize = self.loops.iter().map(Vec::len).sum();
        let mut borders = Vec::new();
        for (segment, w) in self.scars.iter().flat_map(|s| s.windows(2)).enumerate() {
            let h = 2 * (n_loop_edges + segment);
            let [a, b] = [walk_of[h], walk_of[h + 1]].map(|k| region_of_walk[k as usize]);
            if a != b {
                let length = self.points[w[0] as usize].distance(self.points[w[1] as usize]);
                borders.push(Border { regions: [a.min(b), a.max(b)], length, segment: segment as u32 });
            }
        }
        self.regions = regions;
        Ok(borders)
    }

    fn outside(&self, domain: &Domain, v: u32) -> Defect {
        let Point2 { x, y } = self.points[v as usize];
        let names = domain.loops.iter().map(|l| &l.name).chain(domain.scars.iter().map(|s| &s.name));
        let found = self.loops.iter().chain(&self.scars).zip(names).find_map(|(ids, name)| {
            Some(Place { name: name.clone(), index: ids.iter().position(|&u| u == v)?, x, y })
        });
        Defect::Outside { at: found.unwrap_or(Place { name: "point".into(), index: 0, x, y }) }
    }
}

#[cfg(test)]
mod tests;
