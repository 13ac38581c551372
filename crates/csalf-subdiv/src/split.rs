//! The best split line of a contour.
//!
//! ```text
//!    ______k______
//!   |      :      |      j, k   occurrences of contour nodes, j < k
//!   | C_L  :  C_R |      n      nodes placed on the line, n = (k - j + 1) mod 2, so that both
//!   |______:______|             children have an even number of segments
//!          j
//! ```
//!
//! 1. Candidates: all pairs in small contours; in large ones the targets of rays shot from seed nodes (reflex
//!    nodes first, then nodes spread over the contour) in the directions that divide their angle evenly.
//! 2. The functional Φ ([`crate::functional`]), at first with a cheap guess of the node count.
//! 3. In order of Φ: the exact cone and visibility tests, the clearance from other nodes, the true node count
//!    from the integral of 1/h. The best few that pass are returned.
//!
//! Cost per contour of N nodes: O(N²) below [`SplitRules::all_pairs`], O(N + seeds · log N) above.
//! Source: paper 5.3; handbook 1.8, 4.3-4.6, 4.10.

use crate::closure;
use crate::functional::{Weights, angle_term};
use crate::grid::SegmentGrid;
use crate::view::{Nodes, View};
use csalf_geom::Point2;
use csalf_geom::angle::{interior_angle, rough_direction, wanted_quads};
use csalf_mesh::NodeFlags;
use csalf_sizemap::line::{LineSizes, count_error};
use csalf_sizemap::{Hint, SizeField};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Tuning of the splitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitRules {
    /// Weights of the functional.
    pub weights: Weights,
    /// Contours up to this size try all pairs of nodes. Larger: better splits, O(N²) time.
    pub all_pairs: usize,
    /// Seeds of larger contours.
    pub seeds: usize,
    /// Splits compared by lookahead, where there are companions.
    pub lookahead: usize,
    /// 0, or which of other choices to make among splits that are nearly as good: symmetric contours have many that are
    /// equal, and not all of them end well.
    pub variant: u32,
}

impl SplitRules {
    /// Rules of the default method.
    pub const QUALITY: Self =
        Self { weights: Weights::QUALITY, all_pairs: 64, seeds: 48, lookahead: 8, variant: 0 };
    /// The same without lookahead: about twice as fast, with more irregular vertices.
    pub const FAST: Self = Self { lookahead: 1, ..Self::QUALITY };
    /// Rules of the paper's functional, without lookahead.
    pub const PAPER: Self = Self { weights: Weights::PAPER, ..Self::FAST };
}

/// Sizes within this factor are integrated from three samples. At 1.5 the error of Simpson's rule is below 1 percent.
const EVEN: f64 = 1.5;
/// Lines of more segments are integrated with more samples.
const SHORT: f64 = 12.0;

/// How strict the tests of a candidate are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strictness {
    /// Smallest split angle, radians.
    min_angle: f64,
    /// Smallest distance of the line from other nodes, in units of the wanted size.
    clearance: f64,
    /// Smallest scaled Jacobian of the quads that close a child of four or six nodes.
    quad_sj: f64,
    /// All pairs up to this contour size.
    all_pairs: usize,
}

/// From what a good mesh asks for to anything that is visible.
pub(crate) const LADDER: [Strictness; 3] = [
    Strictness { min_angle: 0.44, clearance: 0.30, quad_sj: 0.25, all_pairs: 0 },
    Strictness { min_angle: 0.17, clearance: 0.10, quad_sj: 0.10, all_pairs: 256 },
    Strictness { min_angle: 0.02, clearance: 0.01, quad_sj: 0.02, all_pairs: 512 },
];

/// A split line from occurrence `j` to `k` > `j` with `segments` segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Split {
    pub(crate) j: usize,
    pub(crate) k: usize,
    pub(crate) segments: usize,
    pub(crate) phi: f64,
}

#[derive(Clone, Copy, Debug)]
struct Candidate {
    j: u32,
    k: u32,
    score: f64,
}

/// Sorts the best few candidates to the front, by score and then by nodes; returns how many. Most searches end before
/// the rest is needed.
fn sort_first(list: &mut [Candidate]) -> usize {
    const FEW: usize = 48;
    let by = |a: &Candidate, b: &Candidate| a.score.total_cmp(&b.score).then((a.j, a.k).cmp(&(b.j, b.k)));
    let n = list.len().min(FEW);
    if n < list.len() {
        list.select_nth_unstable_by(n - 1, by);
    }
    list[..n].sort_unstable_by(by);
    n
}

/// Reusable memory of the splitter.
#[derive(Debug, Default)]
pub(crate) struct Splitter {
    candidates: Vec<Candidate>,
    seeds: Vec<u32>,
    grid: SegmentGrid,
    has_grid: bool,
    pub(crate) found: Vec<Split>,
}

/// Number of segments nearest to `wanted` in ratio with the parity of `step` = k - j (so that both children are
/// even), at least `least`.
pub(crate) fn segments_for(wanted: f64, step: usize, least: usize) -> usize {
    let odd = step % 2;
    let mut low = wanted.floor().max(1.0) as usize;
    if low % 2 != odd {
        low = if low > 1 { low - 1 } else { low + 1 };
    }
    while low < least {
        low += 2;
    }
    let high = low + 2;
    // Nearest in ratio: high / wanted < wanted / low.
    if (high * low) as f64 <= wanted * wanted { high } else { low }
}

impl Splitter {
    /// Fills `found` with the best valid splits, best first: at most `wanted`.
    pub(crate) fn search(
        &mut self,
        view: &View,
        size: &dyn SizeField,
        hint: &mut Hint,
        rules: &SplitRules,
        strict: &Strictness,
        wanted: usize,
    ) {
        self.candidates.clear();
        self.found.clear();
        let n = view.len();
        let gridded = n > rules.all_pairs.max(strict.all_pairs);
        self.has_grid = n > rules.all_pairs;
        if self.has_grid {
            self.grid.build(view);
        }
        if gridded {
            self.by_rays(view, rules, strict);
        } else {
            self.by_pairs(view, rules, strict);
        }
        // With one wanted, no candidate much worse on the cheap score than the best so far can still win.
        let slack = if wanted == 1 { 0.02 } else { 0.30 };
        let mut examined = 0;
        let mut sorted = 0;
        for c in 0..self.candidates.len() {
            if c == sorted {
                sorted += sort_first(&mut self.candidates[c..]);
            }
            let Candidate { j, k, score } = self.candidates[c];
            if c > 0 && (self.candidates[c - 1].j, self.candidates[c - 1].k) == (j, k) {
                continue;
            }
            if self.found.len() >= wanted
                && (score > self.found[wanted - 1].phi + slack || examined >= 2 * wanted)
            {
                break;
            }
            let (j, k) = (j as usize, k as usize);
            let Some(clearance) = self.visible(view, j, k, strict) else { continue };
            let step = k - j;
            let (a, b) = (view.point[j], view.point[k]);
            let fitting = wanted_segments(view, j, k, size, hint);
            let segments = segments_for(fitting, step, least_segments(n, step));
            if !self.small_children_are_good(view, j, k, segments, strict) {
                continue;
            }
            let guess = 2.0 * a.distance(b) / (view.size[j] + view.size[k]);
            let w = rules.weights.count;
            let phi = score
                + whim(rules.variant, j, k)
                + w * (count_error(segments, fitting)
                    - rough_count_error(segments_for(guess, step, least_segments(n, step)), guess))
                + 0.3 * (0.6 - clearance).max(0.0);
            let at = self.found.partition_point(|s| s.phi <= phi);
            self.found.insert(at, Split { j, k, segments, phi });
            examined += 1;
        }
        self.found.truncate(wanted);
    }

    /// Score of a pair, or `None` if its angles are too small.
    fn score(&self, view: &View, j: usize, k: usize, rules: &SplitRules, min_angle: f64) -> Option<f64> {
        let n = view.len();
        let (a, b) = (view.point[j], view.point[k]);
        let d = b - a;
        let l = d.length();
        let phi = rough_direction(d);
        let norm = |t: f64| {
            if t < 0.0 {
                t + TAU
            } else if t >= TAU {
                t - TAU
            } else {
                t
            }
        };
        let a1 = norm(phi - view.heading[j]); // right of the line at j: from the outgoing segment to the line
        let a2 = view.theta[j] - a1;
        let a3 = norm(norm(phi + PI) - view.heading[k]);
        let a4 = view.theta[k] - a3;
        if a1.min(a2).min(a3).min(a4) < min_angle {
            return None;
        }
        let w = &rules.weights;
        let step = k - j;
        let guess = 2.0 * l / (view.size[j] + view.size[k]);
        let segments = segments_for(guess, step, least_segments(n, step));
        let mut s = w.angle * angle_term([a1, a2, a3, a4], w.multiples)
            + w.length * l / view.diagonal()
            + w.count * rough_count_error(segments, guess)
            + w.balance * (n as f64 - 2.0 * step as f64).abs() / n as f64;
        if w.charge > 0.0 {
            // a1 and a4 lie on the side of occurrences j+1 .. k-1 (the left child), a2 and a3 on the other.
            let ends = [wanted_quads(a1), wanted_quads(a2), wanted_quads(a4), wanted_quads(a3)];
            let (left, right) = view.child_charges(j, k, ends);
            s += w.charge * (left.abs() + right.abs() - view.charge().abs()) as f64 / 4.0;
        }
        Some(s)
    }

    fn by_pairs(&mut self, view: &View, rules: &SplitRules, strict: &Strictness) {
        let n = view.len();
        for j in 0..n {
            for k in j + 2..n.min(j + n - 1) {
                if n - (k - j) < 2 || view.node[j] == view.node[k] {
                    continue;
                }
                if let Some(score) = self.score(view, j, k, rules, strict.min_angle) {
                    self.candidates.push(Candidate { j: j as u32, k: k as u32, score });
                }
            }
        }
    }

    fn by_rays(&mut self, view: &View, rules: &SplitRules, strict: &Strictness) {
        let n = view.len();
        // Reflex nodes (up to half of the seeds, spread), then nodes spread over the contour.
        let mut seeds = std::mem::take(&mut self.seeds);
        seeds.clear();
        seeds.extend((0..n as u32).filter(|&i| view.wanted[i as usize] >= 3));
        let most = rules.seeds / 2;
        if seeds.len() > most {
            let m = seeds.len();
            for i in 0..most {
                seeds[i] = seeds[i * m / most];
            }
            seeds.truncate(most);
        }
        let spread = rules.seeds - seeds.len();
        seeds.extend((0..spread).map(|i| (i * n / spread) as u32));
        for &j in &seeds {
            let j = j as usize;
            let k = view.wanted[j].max(2) as usize;
            for i in 1..k {
                let angle = view.heading[j] + view.theta[j] * i as f64 / k as f64;
                let (s, c) = angle.sin_cos();
                let Some((hit, _)) = self.grid.shoot(view, j, Point2::new(c, s)) else { continue };
                for offset in 0..6 {
                    let t = (hit + n + offset - 2) % n;
                    let (lo, hi) = (j.min(t), j.max(t));
                    if hi - lo < 2 || n - (hi - lo) < 2 || view.node[lo] == view.node[hi] {
                        continue;
                    }
                    if let Some(score) = self.score(view, lo, hi, rules, strict.min_angle) {
                        self.candidates.push(Candidate { j: lo as u32, k: hi as u32, score });
                    }
                }
            }
        }
        self.seeds = seeds;
    }

    /// Exact cone and visibility tests; then the smallest distance of other nodes from the line in units of the
    /// wanted size, `None` if the line is invalid or that is below the strictness.
    fn visible(&self, view: &View, j: usize, k: usize, strict: &Strictness) -> Option<f64> {
        let (a, b) = (view.point[j], view.point[k]);
        if !view.enters(j, b) || !view.enters(k, a) {
            return None;
        }
        let d = b - a;
        let l2 = d.length_squared();
        let h = 0.5 * (view.size[j] + view.size[k]);
        let mut clearance = 1.0f64;
        let n = view.len();
        let mut test = |i: usize| {
            let p = view.point[i];
            let t = (p - a).dot(d) / l2;
            if t > 0.0 && t < 1.0 && p != a && p != b {
                // Nodes beside the ends are near the line by nature.
                let off = (p - a).perp_dot(d).abs() / l2.sqrt();
                if i.abs_diff(j) > 1 && i.abs_diff(k) > 1 && i.abs_diff(j) < n - 1 && i.abs_diff(k) < n - 1 {
                    clearance = clearance.min(off / h.min(view.size[i]));
                }
            }
            clearance < strict.clearance || view.blocks(i, j, k)
        };
        let blocked = if self.has_grid { self.grid.along(a, b, &mut test) } else { (0..n).any(&mut test) };
        if blocked { None } else { Some(clearance) }
    }

    /// If a child has only four or six nodes: the quads that close it are good enough.
    fn small_children_are_good(
        &self,
        view: &View,
        j: usize,
        k: usize,
        segments: usize,
        strict: &Strictness,
    ) -> bool {
        let n = view.len();
        let check = |from: usize, to: usize, step: usize| {
            let m = step + segments;
            if m > 6 {
                return true;
            }
            let mut rim = [Point2::ZERO; 6];
            for (s, slot) in rim[..m].iter_mut().enumerate() {
                *slot = if s <= step {
                    view.point[(from + s) % n]
                } else {
                    let t = (s - step) as f64 / segments as f64;
                    view.point[to].lerp(view.point[from], t)
                };
            }
            let mut wanted = [0.0; 6];
            for i in 0..m {
                wanted[i] = interior_angle(rim[(i + m - 1) % m], rim[i], rim[(i + 1) % m]) / FRAC_PI_2;
            }
            closure::can_reach(&rim[..m], &wanted[..m], strict.quad_sj)
        };
        check(j, k, k - j) && check(k, j, n - (k - j))
    }
}

/// What a split costs more in a variant: 0 in the first, up to [`WHIM`] in others.
fn whim(variant: u32, j: usize, k: usize) -> f64 {
    /// Differences of Φ below this mean little. *Arbitrary.*
    const WHIM: f64 = 0.05;
    if variant == 0 {
        return 0.0;
    }
    let mixed = (j as u64 ^ (k as u64) << 20 ^ u64::from(variant) << 40).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    WHIM * (mixed >> 40) as f64 / f64::from(1u32 << 24)
}

/// As [`count_error`], without a logarithm: 0 for a perfect fit, 1 for a factor of two.
fn rough_count_error(segments: usize, wanted: f64) -> f64 {
    let s = segments as f64;
    (s.max(wanted) / s.min(wanted) - 1.0).min(1.0)
}

/// How many segments fit on the line from `j` to `k`, by Simpson's rule where the sizes at both ends and the middle
/// differ little: the sizes at the ends are known.
fn wanted_segments(view: &View, j: usize, k: usize, size: &dyn SizeField, hint: &mut Hint) -> f64 {
    let (a, b) = (view.point[j], view.point[k]);
    if let Some(h) = size.constant() {
        return a.distance(b) / h;
    }
    let (ra, rb) = (1.0 / view.size[j], 1.0 / view.size[k]);
    let rm = 1.0 / size.h(a.midpoint(b), hint);
    let estimate = a.distance(b) * (ra + 4.0 * rm + rb) / 6.0;
    if ra.max(rm).max(rb) <= EVEN * ra.min(rm).min(rb) && estimate <= SHORT {
        estimate
    } else {
        LineSizes::new(a, b, size, hint).wanted_segments()
    }
}

/// Fewest segments of a split so that neither child has fewer than four.
fn least_segments(n: usize, step: usize) -> usize {
    4usize.saturating_sub(step.min(n - step)).max(1)
}

/// Places the nodes of a split and returns their ids, in order from j to k.
pub(crate) fn place(
    view: &View,
    split: &Split,
    nodes: &mut Nodes,
    size: &dyn SizeField,
    hint: &mut Hint,
    line: &mut Vec<u32>,
) {
    line.clear();
    let (a, b) = (view.point[split.j], view.point[split.k]);
    let inner = split.segments - 1;
    if inner == 0 {
        return;
    }
    let sizes = LineSizes::new(a, b, size, hint);
    for i in 1..=inner {
        let p = a.lerp(b, sizes.parameter(i, inner));
        let h = size.h(p, hint);
        line.push(nodes.push(p, h, NodeFlags::default()));
    }
}
