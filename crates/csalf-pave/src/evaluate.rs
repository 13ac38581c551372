//! Loop-front evaluators: may this ring stand?
//!
//! | # | test | when | source |
//! |---|---|---|---|
//! | 1 | neighbouring fronts differ by no more than 1.5 in length, one in eight excepted (paper's rules) | before | eq. (5) |
//! | 2 | fronts are neither far finer nor far coarser than the size field | before | handbook 3.6 |
//! | 3 | every quad strictly convex (exact), scaled Jacobian at least 0.25 (asked layers 0.10), no node folded | after | |
//! | 4 | the new loop touches no front, nor itself, and no front lies in a quad (exact) | after | Algorithm I |
//! | 5 | area of the outer loop at least 0.2 of the old one | after | eq. (3) |
//! | 6 | perimeter within 0.45 to 2 of the old, and within 15 % of the Steiner forecast | after | eq. (4) |
//! | 7 | growth of the fronts within a factor of 2.5 | after | eq. (6) |
//! | 8 | a corridor of 0.75 edges to other fronts remains (asked layers 0.5) | after | handbook 3.6 |
//!
//! Tests 3 and 4 suffice for a valid ring: positive quads make the ring locally one-to-one, borders that are simple
//! and apart make it so altogether. Layers that the user asked for need only 3, 4 and 8. Handbook 1.3 to 1.6, 3.6.

use crate::PavingRules;
use crate::build::{Candidate, Failure, LoopState, NEW};
use crate::index::{Index, Segment, distance};
use crate::ring::Ring;
use csalf_geom::predicates::{Meeting, meeting, orient2d};
use csalf_geom::{Point2, polygon};
use csalf_mesh::quality::scaled_jacobian;
use csalf_mesh::validate::is_strictly_convex;
use csalf_sizemap::{Hint, SizeField};

/// Why the layers of a loop end.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Stop {
    /// The loop, or the one that would remain, has too few nodes.
    #[error("the loop is too short")]
    Short,
    /// A finger one quad wide.
    #[error("the loop has a finger too narrow for a layer")]
    Narrow,
    /// Test 1.
    #[error("neighbouring segments differ too much in length")]
    UnevenFronts,
    /// Test 2.
    #[error("the segments are far from the wanted size")]
    FarFromSize,
    /// Test 3, convexity and quality.
    #[error("quads of the layer would be too distorted")]
    Distorted,
    /// Test 3, folds.
    #[error("the layer would fold over itself")]
    Folded,
    /// Test 4.
    #[error("the layer would meet another front or itself")]
    Crossing,
    /// Test 8.
    #[error("too little room would be left between fronts")]
    Gap,
    /// Test 5.
    #[error("too little area would be left")]
    Area,
    /// Test 6.
    #[error("the perimeter would change too much")]
    Perimeter,
    /// Test 7.
    #[error("the segments would grow too unevenly")]
    Growth,
    /// Less than half of the loop could be covered.
    #[error("too little of the loop could be covered")]
    LittleLeft,
    /// A layer was made thinner than wanted, or leaves some of the loop uncovered.
    #[error("there is room only for a layer that is thinner or covers a part of the loop")]
    Reduced,
    /// Layers that nobody asked for end where they would become coarser than the size field.
    #[error("the next layer would be thicker than the wanted size")]
    Thick,
    /// Layers that nobody asked for end where their front would be much finer than the size field.
    #[error("the front of the next layer would be finer than the wanted size")]
    Fine,
}

/// Test 3 on every quad; `all` holds the points of existing nodes by id. Cost O(q).
pub(crate) fn own_quads(c: &Candidate, all: &[Point2], user: bool) -> Result<(), Failure> {
    let floor = if user { 0.10 } else { 0.25 };
    let mut at = Vec::new();
    for (q, &i) in c.quads.iter().zip(&c.quad_at) {
        let p = q.map(|v| if v >= NEW { c.points[(v - NEW) as usize] } else { all[v as usize] });
        if !is_strictly_convex(&p) || scaled_jacobian::value(&p) < floor {
            at.push(i);
        }
    }
    if at.is_empty() { Ok(()) } else { Err(Failure { stop: Stop::Distorted, at }) }
}

/// Folds: at nodes with three and more quads of the ring their angles must add up to less than a full turn, and at
/// the nodes of the loop to no more than its angle allows. Returns the nodes of the (peeled) loop whose quads fail.
/// Positive quads at nodes with two need no such test: two angles below 180 degrees add up to less than a turn.
pub(crate) fn angle_sums(ring: &Ring, old: &[Point2], new: &[Point2]) -> Result<(), Vec<u32>> {
    let n = ring.n;
    let at = |v: u32| if (v as usize) < n { old[v as usize] } else { new[v as usize - n] };
    let mut count = vec![0u8; n + ring.n_new];
    for v in ring.quads.iter().flatten() {
        count[*v as usize] = count[*v as usize].saturating_add(1);
    }
    let mut sums: Vec<(u32, u32, f64)> = Vec::new();
    for (q, &i) in ring.quads.iter().zip(&ring.quad_node) {
        for k in 0..4 {
            if count[q[k] as usize] >= 3 {
                let (u, v) = (at(q[(k + 1) & 3]) - at(q[k]), at(q[(k + 3) & 3]) - at(q[k]));
                sums.push((q[k], i, csalf_geom::angle::turn(u, v)));
            }
        }
    }
    sums.sort_by_key(|s| (s.0, s.1));
    let mut bad = Vec::new();
    // Sums of a few angles are good to 1e-15; a full turn can only be missed by whole turns.
    let limit = std::f64::consts::TAU * (1.0 + Tolerances::TURN);
    for node in sums.chunk_by(|a, b| a.0 == b.0) {
        if node.iter().map(|s| s.2).sum::<f64>() > limit {
            bad.extend(node.iter().map(|s| s.1));
        }
    }
    if bad.is_empty() { Ok(()) } else { Err(bad) }
}

struct Tolerances;
impl Tolerances {
    /// Relative slack of a full turn: larger than rounding, far smaller than the next full turn.
    const TURN: f64 = 1e-9;
}

/// Tests 1 (paper's rules only: the corrected ones smooth the thickness and judge the quads) and 2, for layers that
/// nobody asked for.
pub(crate) fn before(
    s: &LoopState,
    field: &dyn SizeField,
    rules: PavingRules,
    hint: &mut Hint,
) -> Result<(), Stop> {
    let n = s.nodes.len();
    let length = |i: usize| s.points[i].distance(s.points[if i + 1 == n { 0 } else { i + 1 }]);
    let mut uneven = 0;
    let mut far = 0;
    let mut last = length(n - 1);
    for i in 0..n {
        let l = length(i);
        let h = field.h(s.points[i], hint);
        uneven += usize::from(l > 1.5 * last || last > 1.5 * l);
        far += usize::from(l < 0.3 * h || l > 3.0 * h);
        last = l;
    }
    if rules == PavingRules::Paper && 8 * uneven > n + 8 {
        return Err(Stop::UnevenFronts);
    }
    // 15 % of the fronts may be anything.
    if 100 * far > 15 * n { Err(Stop::FarFromSize) } else { Ok(()) }
}

/// Test 7 blames fronts that grow by this factor more or less than the middle one: two such may differ by 2.5.
const MOST_APART: f64 = 1.58;

/// Tests 5 to 7, for layers that nobody asked for.
pub(crate) fn after(old: &LoopState, c: &Candidate, outer: bool) -> Result<(), Failure> {
    if outer {
        let ratio = polygon::signed_area(&c.next.points) / polygon::signed_area(&old.points);
        if ratio < 0.20 {
            return Err(Stop::Area.into());
        }
    }
    let (p0, p1) = (polygon::perimeter(&old.points), polygon::perimeter(&c.next.points));
    if !(0.45..2.0).contains(&(p1 / p0)) && old.nodes.len() > 8 {
        return Err(Stop::Perimeter.into());
    }
    let n = old.nodes.len();
    let m = c.next.nodes.len();
    let mut growth: Vec<(f64, u32)> = Vec::new();
    for k in 0..m {
        let j = if k + 1 == m { 0 } else { k + 1 };
        let (i, i1) = (c.origin[k] as usize, c.origin[j] as usize);
        if (i + 1) % n != i1 || !c.next.open[k] {
            continue;
        }
        let q = c.next.points[k].distance(c.next.points[j]) / old.points[i].distance(old.points[i1]);
        growth.push((q, i as u32));
    }
    growth.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    if let (Some(low), Some(high)) = (growth.first(), growth.last())
        && high.0 > 2.5 * low.0
    {
        // All that are far from what most do.
        let middle = growth[growth.len() / 2].0;
        let far = growth.iter().filter(|g| g.0 > MOST_APART * middle || MOST_APART * g.0 < middle);
        return Err(Failure { stop: Stop::Growth, at: far.map(|g| g.1).collect() });
    }
    Ok(())
}

/// Who stands and who is proposed, when one ring is tested against all others.
pub(crate) struct Others<'a> {
    pub(crate) index: &'a Index,
    /// The loop whose ring is tested.
    pub(crate) own: u32,
    /// Loops whose proposed ring has been committed since the index was built.
    pub(crate) committed: &'a [bool],
    /// Corridor that must remain, in lengths of the new fronts.
    pub(crate) gap: f64,
}

/// Tests 4 and 8. `corners` gives the points of a quad of the candidate. Cost O((q + hits) log n).
pub(crate) fn against(
    c: &Candidate,
    old: &LoopState,
    others: &Others<'_>,
    corners: impl Fn(usize) -> [Point2; 4],
) -> Result<(), Failure> {
    const CHUNK: usize = 8;
    let m = c.next.nodes.len();
    let next = |k: usize| if k + 1 >= m { 0 } else { k + 1 };
    // Segments near a chunk, each with its box.
    let mut near: Vec<(Point2, Point2, Segment)> = Vec::new();
    let stands = |s: &Segment| {
        if s.owner == others.own { true } else { s.proposed == others.committed[s.owner as usize] }
    };
    let mut crossing = Vec::new();
    let mut gap = Vec::new();
    for from in (0..m).step_by(CHUNK) {
        let to = m.min(from + CHUNK);
        let (mut lo, mut hi, mut length) = (Point2::INFINITY, Point2::NEG_INFINITY, 0.0f64);
        for k in from..to {
            let (a, b) = (c.next.points[k], c.next.points[next(k)]);
            lo = lo.min(a).min(b);
            hi = hi.max(a).max(b);
            length = length.max(a.distance(b));
        }
        let reach = others.gap * length;
        near.clear();
        others.index.query(lo - reach, hi + reach, |s| {
            if stands(s) {
                near.push((s.a.min(s.b), s.a.max(s.b), *s));
            }
        });
        for k in from..to {
            if !c.next.open[k] && c.next.nodes[k] < NEW && c.next.nodes[next(k)] < NEW {
                continue; // an uncovered edge of the old loop
            }
            let (a, b) = (c.next.points[k], c.next.points[next(k)]);
            let length = a.distance(b);
            let (lo, hi) = (a.min(b), a.max(b));
            let far = others.gap * length;
            for (s_lo, s_hi, s) in &near {
                let far = if s.owner == others.own && !s.proposed { 0.0 } else { far };
                if s_lo.x > hi.x + far || s_lo.y > hi.y + far || s_hi.x < lo.x - far || s_hi.y < lo.y - far {
                    continue;
                }
                // What lies between two fronts has lengths between theirs.
                let reach = others.gap * 0.5 * (length + length.min(s.a.distance(s.b)));
                if s.owner == others.own {
                    own_pair(c, old, k, a, b, s, reach, &mut crossing, &mut gap);
                } else if meeting(a, b, s.a, s.b) != Meeting::Apart {
                    crossing.push(c.origin[k]);
                } else if distance(a, s.a, s.b).min(distance(s.a, a, b)).min(distance(s.b, a, b)) < reach {
                    gap.push(c.origin[k]);
                }
            }
        }
    }
    swallowed(c, old, others, &stands, &corners, &mut crossing);
    for (stop, at) in [(Stop::Crossing, crossing), (Stop::Gap, gap)] {
        if !at.is_empty() {
            return Err(Failure { stop, at });
        }
    }
    Ok(())
}

/// Edge k of the new loop, from `a` to `b`, against segment `s` of the same loop, old or new.
#[allow(clippy::too_many_arguments, reason = "one pair test, called from one place")]
fn own_pair(
    c: &Candidate,
    old: &LoopState,
    k: usize,
    a: Point2,
    b: Point2,
    s: &Segment,
    reach: f64,
    crossing: &mut Vec<u32>,
    gap: &mut Vec<u32>,
) {
    let m = c.next.nodes.len();
    let j = s.at as usize;
    if !s.proposed {
        // The old loop: only ends of chains are shared with it.
        let n = old.nodes.len();
        let ends = [old.nodes[j], old.nodes[(j + 1) % n]];
        let mine = [c.next.nodes[k], c.next.nodes[(k + 1) % m]];
        if !mine.iter().any(|v| ends.contains(v)) && meeting(a, b, s.a, s.b) != Meeting::Apart {
            crossing.push(c.origin[k]);
        }
        return;
    }
    let apart = k.abs_diff(j).min(m - k.abs_diff(j));
    if apart <= 1 {
        return;
    }
    let mine = [c.next.nodes[k], c.next.nodes[(k + 1) % m]];
    let theirs = [c.next.nodes[j], c.next.nodes[(j + 1) % m]];
    if mine.iter().any(|v| theirs.contains(v)) {
        return; // two occurrences of one node (a slit)
    }
    if meeting(a, b, s.a, s.b) != Meeting::Apart {
        crossing.push(c.origin[k]);
    } else if apart > 3
        && distance(a, s.a, s.b).min(distance(s.a, a, b)).min(distance(s.b, a, b)) < 0.8 * reach
    {
        gap.push(c.origin[k]);
    }
}

/// Fronts that lie wholly in the new quads: one end in or on a quad.
fn swallowed(
    c: &Candidate,
    old: &LoopState,
    others: &Others<'_>,
    stands: &impl Fn(&Segment) -> bool,
    corners: &impl Fn(usize) -> [Point2; 4],
    crossing: &mut Vec<u32>,
) {
    const CHUNK: usize = 8;
    let mut near: Vec<Point2> = Vec::new();
    if c.quads.len() <= 16 * CHUNK {
        // A short ring usually has nobody near at all.
        let all = old.points.iter().chain(&c.points);
        let (mut lo, mut hi) = (Point2::INFINITY, Point2::NEG_INFINITY);
        for p in all {
            lo = lo.min(*p);
            hi = hi.max(*p);
        }
        let mut alone = true;
        others.index.query(lo, hi, |s| alone &= s.owner == others.own || !stands(s));
        if alone {
            return;
        }
    }
    let mut quads: Vec<[Point2; 4]> = Vec::with_capacity(CHUNK);
    for from in (0..c.quads.len()).step_by(CHUNK) {
        quads.clear();
        quads.extend((from..c.quads.len().min(from + CHUNK)).map(corners));
        let (mut lo, mut hi) = (Point2::INFINITY, Point2::NEG_INFINITY);
        for p in quads.iter().flatten() {
            lo = lo.min(*p);
            hi = hi.max(*p);
        }
        near.clear();
        others.index.query(lo, hi, |s| {
            if s.owner != others.own && stands(s) {
                near.push(s.a);
            }
        });
        if near.is_empty() {
            continue;
        }
        for (k, q) in quads.iter().enumerate() {
            let inside = |p: Point2| (0..4).all(|i| orient2d(q[i], q[(i + 1) & 3], p) >= 0.0);
            if near.iter().any(|p| inside(*p)) {
                crossing.push(c.quad_at[from + k]);
            }
        }
    }
}
