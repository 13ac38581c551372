//! Finds everything that is wrong with a domain, in one pass.
//!
//! ```text
//!   Domain ─▶ gather ─▶ merge_nodes ─▶ meet_segments ─▶ nesting, scars, points ─▶ Checked | Vec<Defect>
//!             (counts,   (equal nodes,   (crossings,      (check/nesting.rs)
//!              NaN)       repeats)        touchings)
//! ```
//!
//! 1. `gather`: every loop and scar of finite nodes gives **slots** (its nodes) and **segments**; the others are
//!    reported and take no further part.
//! 2. `merge_nodes`: slots closer than [`Tolerance::merge`] become one node. Between scars and anything that is how
//!    curves are joined; between loops it is a defect.
//! 3. `find_orientation` ([`nesting`]): zero area and the way round of each loop.
//! 4. `meet_segments`: every pair of segments near each other is tested with exact predicates.
//! 5. [`nesting`]: what lies in what.
//! 6. [`close`]: notices of hard points very close to segments.
//!
//! Cost: O((n + k) log n) for n nodes and k near pairs, by a tree of bounding boxes.
//! Source: handbook 0.2 and 12.3 (1 to 4, 19, 20, 22).

mod close;
mod nesting;

pub(crate) use nesting::is_left_of;

use crate::boxtree::{Aabb, BoxTree};
use crate::defect::Notice;
use crate::predicates::{Meeting, meeting, on_segment};
use crate::{Defect, Domain, LoopKind, Place, Point2, Tolerance};
use std::collections::BTreeSet;

/// Most defects of segments listed; a garbled file can have millions. *Arbitrary.*
const MAX_LISTED: usize = 1000;
/// Coordinates beyond this, and domains smaller than its inverse, would overflow the exact predicates, whose
/// products are of degree four.
const MAX_COORDINATE: f64 = 1e70;

/// A domain without defects, its nodes numbered.
#[derive(Debug)]
pub(crate) struct Checked {
    pub(crate) points: Vec<Point2>,
    /// Outer counter-clockwise, holes clockwise.
    pub(crate) loops: Vec<Vec<u32>>,
    pub(crate) scars: Vec<Vec<u32>>,
    pub(crate) hard_points: Vec<u32>,
    pub(crate) tolerance: Tolerance,
    /// The defect of an odd total, which is no defect to all callers.
    pub(crate) odd_total: Option<Defect>,
    pub(crate) notices: Vec<Notice>,
}

/// What a curve is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Outer,
    Hole,
    Scar,
}

/// A loop or scar as the checks see it.
#[derive(Debug)]
struct Curve<'a> {
    name: &'a str,
    kind: Kind,
    /// Nodes, a repeated first one cut off.
    nodes: &'a [Point2],
    /// Slots of its nodes; empty if the curve is too broken to take part.
    slots: std::ops::Range<usize>,
    /// Still thought free of crossings with itself: sides and areas have a meaning.
    simple: bool,
    /// Runs the wrong way round, to be reversed.
    reversed: bool,
    /// A loop without area.
    flat: bool,
}

/// The state of the checks.
struct Checker<'a> {
    domain: &'a Domain,
    /// Loops, then scars.
    curves: Vec<Curve<'a>>,
    /// Position of each slot; after the merge, of its node.
    slots: Vec<Point2>,
    curve_of: Vec<u32>,
    /// Node of each slot.
    node_of: Vec<u32>,
    /// Slots of all loops come first.
    n_loop_slots: usize,
    /// Node positions.
    points: Vec<Point2>,
    /// Ends of each segment as slots; loops first.
    segments: Vec<[u32; 2]>,
    tree: BoxTree,
    tolerance: Tolerance,
    /// Pairs of curves, smaller first, that are known to cross or touch.
    entangled: BTreeSet<(u32, u32)>,
    defects: Vec<Defect>,
}

/// Checks all but the parity of regions. The defects are in order of the checks, within one check by place.
pub(crate) fn check(domain: &Domain, allow_odd: bool) -> Result<Checked, Vec<Defect>> {
    let mut c = Checker::gather(domain);
    c.merge_nodes();
    c.find_orientation();
    c.meet_segments();
    c.check_nesting();
    c.check_scars();
    let hard_points = c.place_points();
    let n_loops = domain.loops.len();
    let odd_total = c.odd_total().filter(|_| !allow_odd);
    if !c.defects.is_empty() {
        c.defects.extend(odd_total);
        return Err(c.defects);
    }
    let notices = c.notices(&hard_points);
    let nodes = |v: &Curve<'_>| {
        let mut ids = c.node_of[v.slots.clone()].to_vec();
        if v.reversed {
            ids[1..].reverse();
        }
        ids
    };
    Ok(Checked {
        loops: c.curves[..n_loops].iter().map(nodes).collect(),
        scars: c.curves[n_loops..].iter().map(nodes).collect(),
        points: c.points,
        hard_points,
        tolerance: c.tolerance,
        odd_total,
        notices,
    })
}

/// Nodes of a loop without a repetition of the first at the end.
fn without_closing_node(nodes: &[Point2], merge: f64) -> &[Point2] {
    match nodes {
        [first, .., last] if first == last || first.distance(*last) <= merge => &nodes[..nodes.len() - 1],
        _ => nodes,
    }
}

impl<'a> Checker<'a> {
    /// Takes in all curves that have enough finite nodes.
    fn gather(domain: &'a Domain) -> Self {
        let mut defects = Vec::new();
        let finite = |p: &&Point2| p.is_finite() && p.abs().max_element() <= MAX_COORDINATE;
        let tolerance =
            Tolerance::of_points(domain.loops.iter().flat_map(|l| &l.nodes).filter(finite).copied());
        let tiny = tolerance.diagonal() > 0.0 && tolerance.diagonal() < MAX_COORDINATE.recip();
        let first = domain.loops.iter().find_map(|l| Some((l, *l.nodes.first()?)));
        if let Some((l, p)) = first.filter(|f| tiny && f.1.is_finite()) {
            defects.push(Defect::Scale { at: Place { name: l.name.clone(), index: 0, x: p.x, y: p.y } });
        }

        let outer: Vec<_> = domain.loops.iter().filter(|l| l.kind == LoopKind::Outer).collect();
        match outer.len() {
            0 => defects.push(Defect::NoOuterLoop),
            1 => {}
            _ => defects
                .push(Defect::SeveralOuterLoops { names: outer.iter().map(|l| l.name.clone()).collect() }),
        }

        let loops = domain.loops.iter().map(|l| {
            let kind = if l.kind == LoopKind::Outer { Kind::Outer } else { Kind::Hole };
            (l.name.as_str(), kind, without_closing_node(&l.nodes, tolerance.merge()))
        });
        let scars = domain.scars.iter().map(|s| (s.name.as_str(), Kind::Scar, s.nodes.as_slice()));
        let (mut curves, mut slots, mut curve_of, mut segments) = (vec![], vec![], vec![], vec![]);
        let mut n_loop_slots = 0;
        for (name, kind, nodes) in loops.chain(scars) {
            let mut sound = true;
            if kind == Kind::Scar && nodes.len() < 2 {
                defects.push(Defect::ScarTooShort { scar_name: name.into(), n_nodes: nodes.len() });
                sound = false;
            } else if kind != Kind::Scar && nodes.len() < 3 {
                defects.push(Defect::TooFewNodes { loop_name: name.into(), n_nodes: nodes.len() });
                sound = false;
            }
            for (index, p) in nodes.iter().enumerate().filter(|(_, p)| !finite(p)) {
                let at = Place { name: name.into(), index, x: p.x, y: p.y };
                defects.push(if p.is_finite() { Defect::Scale { at } } else { Defect::NotFinite { at } });
                sound = false;
            }
            let from = slots.len();
            if sound {
                slots.extend_from_slice(nodes);
                curve_of.resize(slots.len(), curves.len() as u32);
                let open = usize::from(kind == Kind::Scar);
                for i in from..slots.len() - open {
                    let j = if i + 1 < slots.len() { i + 1 } else { from };
                    segments.push([i as u32, j as u32]);
                }
                if kind != Kind::Scar {
                    n_loop_slots = slots.len();
                }
            }
            let slots = from..slots.len();
            curves.push(Curve { name, kind, nodes, slots, simple: sound, reversed: false, flat: false });
        }
        // Half the merge length on each side: two boxes meet if the segments may be that near.
        let margin = 0.51 * tolerance.merge();
        let tree = BoxTree::new(
            segments
                .iter()
                .map(|&[i, j]: &[u32; 2]| Aabb::of_segment(slots[i as usize], slots[j as usize], margin)),
        );
        Self {
            domain,
            curves,
            slots,
            curve_of,
            node_of: Vec::new(),
            n_loop_slots,
            points: Vec::new(),
            segments,
            tree,
            tolerance,
            entangled: BTreeSet::new(),
            defects,
        }
    }

    /// An odd number of segments on all loops together, if they have one.
    fn odd_total(&self) -> Option<Defect> {
        let loops = &self.curves[..self.domain.loops.len()];
        let n_segments = loops.iter().map(|l| l.nodes.len()).sum::<usize>();
        let odd = loops.iter().filter(|l| l.nodes.len() % 2 == 1).map(|l| l.name.to_owned());
        (n_segments % 2 == 1).then(|| Defect::OddTotal { n_segments, loops: odd.collect() })
    }

    /// The place of a slot, at its position in the input.
    fn place(&self, slot: usize) -> Place {
        let c = &self.curves[self.curve_of[slot] as usize];
        let index = slot - c.slots.start;
        Place { name: c.name.into(), index, x: c.nodes[index].x, y: c.nodes[index].y }
    }

    fn entangle(&mut self, c: u32, d: u32) {
        self.entangled.insert((c.min(d), c.max(d)));
        if c == d {
            self.curves[c as usize].simple = false;
        }
    }

    fn are_entangled(&self, c: usize, d: usize) -> bool {
        self.entangled.contains(&(c.min(d) as u32, c.max(d) as u32))
    }

    /// Numbers the nodes: slots at one place (within the merge tolerance, transitively) are one node, at the
    /// position of the first of them. Reports nodes that may not be one.
    fn merge_nodes(&mut self) {
        let merge = self.tolerance.merge();
        let n = self.slots.len();
        let mut root: Vec<u32> = (0..n as u32).collect();
        fn find(root: &mut [u32], mut i: u32) -> u32 {
            while root[i as usize] != i {
                root[i as usize] = root[root[i as usize] as usize];
                i = root[i as usize];
            }
            i
        }
        let slots = &self.slots;
        let mut unite = |i: u32, j: u32| {
            if i != j && slots[i as usize].distance(slots[j as usize]) <= merge {
                let (a, b) = (find(&mut root, i), find(&mut root, j));
                root[a.max(b) as usize] = a.min(b);
            }
        };
        for &[i, j] in &self.segments {
            unite(i, j);
        }
        self.tree.pairs(&mut |s, t| {
            for i in self.segments[s as usize] {
                for j in self.segments[t as usize] {
                    unite(i, j);
                }
            }
            true
        });

        self.node_of = vec![0; n];
        let mut listed = 0;
        for i in 0..n {
            let r = find(&mut root, i as u32) as usize;
            if r == i {
                self.node_of[i] = self.points.len() as u32;
                self.points.push(self.slots[i]);
                continue;
            }
            self.node_of[i] = self.node_of[r];
            self.slots[i] = self.slots[r];
            let (c, d) = (self.curve_of[r], self.curve_of[i]);
            let is_scar = i >= self.n_loop_slots;
            let repeated = if is_scar {
                // A scar may come back to a node of its own, but not stay at it.
                i > self.curves[d as usize].slots.start && self.node_of[i - 1] == self.node_of[i]
            } else {
                c == d
            };
            if is_scar && !repeated {
                continue;
            }
            self.entangle(if is_scar { d } else { c }, d);
            if listed == MAX_LISTED {
                continue;
            }
            listed += 1;
            let second = self.place(i);
            let first = self.place(if is_scar { i - 1 } else { r });
            self.defects.push(if repeated {
                Defect::RepeatedNode { first, second }
            } else {
                Defect::CoincidentNodes { first, second }
            });
        }
        if listed == MAX_LISTED {
            self.defects.push(Defect::More { listed });
        }
    }

    /// Tests all pairs of segments that may meet.
    fn meet_segments(&mut self) {
        let mut met = Vec::new();
        self.tree.pairs(&mut |s, t| {
            self.meet(s, t, &mut met);
            met.len() < 2 * MAX_LISTED
        });
        met.sort_unstable();
        // A node on a segment is seen from both segments of the node.
        met.dedup();
        let cut = met.len() > MAX_LISTED;
        met.truncate(MAX_LISTED);
        for (s, what, t) in met {
            let (i, j) = (self.segments[s as usize][0] as usize, self.segments[t as usize][0] as usize);
            let (first, second) = (self.place(i), self.place(j));
            match what {
                Met::Cross => {
                    self.entangle(self.curve_of[i], self.curve_of[j]);
                    let Point2 { x, y } = self.crossing(s, t);
                    self.defects.push(if self.curve_of[i] == self.curve_of[j] {
                        Defect::SelfIntersection { first, second, x, y }
                    } else {
                        Defect::Crossing { first, second, x, y }
                    });
                }
                Met::Overlap => {
                    self.entangle(self.curve_of[i], self.curve_of[j]);
                    self.defects.push(Defect::Overlap { first, second });
                }
                Met::NodeOn(slot) => {
                    let slot = slot as usize;
                    self.entangle(self.curve_of[slot], self.curve_of[i]);
                    self.defects.push(Defect::Touching { node: self.place(slot), segment: first });
                }
            }
        }
        if cut {
            self.defects.push(Defect::More { listed: MAX_LISTED });
        }
    }

    /// Where two segments that cross do so, approximately.
    fn crossing(&self, s: u32, t: u32) -> Point2 {
        let [a, b] = self.segments[s as usize].map(|i| self.slots[i as usize]);
        let [c, d] = self.segments[t as usize].map(|i| self.slots[i as usize]);
        let det = (b - a).perp_dot(d - c);
        let f = if det == 0.0 { 0.5 } else { ((c - a).perp_dot(d - c) / det).clamp(0.0, 1.0) };
        a.lerp(b, f)
    }

    /// How segments `s` and `t` meet, if they may not.
    fn meet(&self, s: u32, t: u32, met: &mut Vec<(u32, Met, u32)>) {
        let (e, f) = (self.segments[s as usize], self.segments[t as usize]);
        let node = |i: u32| self.node_of[i as usize];
        let point = |i: u32| self.slots[i as usize];
        if node(e[0]) == node(e[1]) || node(f[0]) == node(f[1]) {
            return; // already reported as repeated nodes
        }
        let (c, d) = (self.curve_of[e[0] as usize], self.curve_of[f[0] as usize]);
        if c == d && self.curves[c as usize].flat {
            return; // already reported as without area
        }
        let shared = |i: u32| node(i) == node(e[0]) || node(i) == node(e[1]);
        match (shared(f[0]), shared(f[1])) {
            (true, true) => met.push((s, Met::Overlap, t)),
            (false, false) => {
                let ends = [(e[0], t, f), (e[1], t, f), (f[0], s, e), (f[1], s, e)];
                let n = met.len();
                for (i, seg, [a, b]) in ends {
                    if self.is_near(point(i), point(a), point(b)) {
                        met.push((seg, Met::NodeOn(i), seg));
                    }
                }
                let apart = || meeting(point(e[0]), point(e[1]), point(f[0]), point(f[1])) == Meeting::Apart;
                if met.len() == n && !apart() {
                    met.push((s, Met::Cross, t));
                }
            }
            (first_shared, _) => {
                let (v, q) = if first_shared { (f[0], f[1]) } else { (f[1], f[0]) };
                let p = if node(e[0]) == node(v) { e[1] } else { e[0] };
                let runs_along = |i: u32, [a, b]: [u32; 2]| self.is_near(point(i), point(a), point(b));
                if runs_along(q, e) || runs_along(p, f) {
                    met.push((s, Met::Overlap, t));
                }
            }
        }
    }

    /// True if `p` is on the segment `ab`, exactly or within the merge tolerance.
    fn is_near(&self, p: Point2, a: Point2, b: Point2) -> bool {
        let (d, merge) = (b - a, self.tolerance.merge());
        let f = ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
        a.lerp(b, f).distance(p) <= merge || on_segment(a, b, p)
    }
}

/// How two segments meet that should not.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Met {
    /// Inside both.
    Cross,
    /// Along each other.
    Overlap,
    /// This slot lies on the first segment.
    NodeOn(u32),
}
