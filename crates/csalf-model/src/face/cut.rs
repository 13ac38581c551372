//! The cut that opens a face between two loops that wind round its surface.
//!
//! ```text
//!   ◀──────────────   loop that winds -1        ┌──────────────┐
//!   material               ─cut─▶               │c            c'│   the cut's two copies have the same names
//!   ──────────────▶   loop that winds +1        └──────────────┘
//! ```
//!
//! The cut is straight in the parameters, from node to node; of those that cross no loop and keep clear of the holes the
//! shortest. Its nodes are as dense as those of the loops at its ends, and grow and shrink between them.

use super::NodeName;
use super::trim::{UvLoop, UvNode};
use crate::geometry::SurfacePoint;
use glam::DVec2;

/// Pairs of nodes that are tried, shortest first.
const TRIES: usize = 400;
/// A cut this many of its segments away from all holes is clear of them.
const CLEAR: f64 = 2.0;
/// Pieces of the cut by which it is measured.
const PIECES: usize = 64;
/// Most nodes of a cut.
const MOST: usize = 10_000;

/// What a cut must know of the face.
pub(super) struct Tube<'a> {
    /// The loop that winds +1.
    pub(super) low: &'a UvLoop,
    /// The loop that winds -1.
    pub(super) high: &'a UvLoop,
    /// Loops that do not wind.
    pub(super) holes: &'a [UvLoop],
    /// Length of a turn in u.
    pub(super) period: f64,
    /// The surface.
    pub(super) at: &'a dyn Fn(DVec2) -> SurfacePoint,
    /// The wanted length at a place, before it is graded.
    pub(super) size: &'a dyn Fn(&SurfacePoint) -> f64,
    /// Growth of the wanted length per length.
    pub(super) gradation: f64,
}

/// A cut from a node of the low loop to one of the high loop.
#[derive(Clone, Copy)]
struct Way {
    low: usize,
    high: usize,
    from: DVec2,
    to: DVec2,
}

impl Tube<'_> {
    /// Opens the tube: one loop that does not wind. New nodes are counted on in `n_own`.
    ///
    /// # Errors
    /// There is no cut.
    pub(super) fn open(&self, n_own: &mut u32) -> Result<UvLoop, String> {
        let way = self.way().ok_or("no cut between the two loops that wind round the surface was found")?;
        let (low, high, period) = (self.low, self.high, self.period);
        let shares = self.shares(&way);
        let n = shares.len() + 1;
        let first = *n_own;
        *n_own += shares.len() as u32;
        let on_cut = |k: usize, shift: f64| {
            let uv = way.from + (way.to - way.from) * shares[k - 1];
            UvNode {
                name: NodeName::Own(first + k as u32 - 1),
                uv: uv + DVec2::new(shift, 0.0),
                point: (self.at)(uv).point,
            }
        };
        let shifted = |m: &UvNode, s: f64| UvNode { uv: m.uv + DVec2::new(s, 0.0), ..*m };
        let mut nodes = Vec::new();
        let (nl, nh) = (low.nodes.len(), high.nodes.len());
        let (i, j) = (way.low, way.high);
        let turn = |past: bool| if past { period } else { 0.0 };
        nodes.extend((0..=nl).map(|k| shifted(&low.nodes[(i + k) % nl], turn(i + k >= nl))));
        nodes.extend((1..n).map(|k| on_cut(k, period)));
        let to = way.to.x + period - high.nodes[j].uv.x;
        nodes.extend((0..=nh).map(|k| shifted(&high.nodes[(j + k) % nh], to - turn(j + k >= nh))));
        nodes.extend((1..n).rev().map(|k| on_cut(k, 0.0)));
        Ok(UvLoop { nodes, winding: [0, 0], source: low.source })
    }

    /// The place next to `hint` by whole turns.
    fn near(&self, uv: DVec2, hint: DVec2) -> DVec2 {
        DVec2::new(uv.x + ((hint.x - uv.x) / self.period).round() * self.period, uv.y)
    }

    /// Lengths of the derivatives in the middle: makes distances in the parameters lengths, about.
    fn scale(&self) -> DVec2 {
        let s = (self.at)(0.5 * (self.low.nodes[0].uv + self.high.nodes[0].uv));
        DVec2::new(s.du.length().max(f64::MIN_POSITIVE), s.dv.length().max(f64::MIN_POSITIVE))
    }

    /// The shortest way that crosses nothing and is clear of the holes; if none is clear, the one that is most.
    fn way(&self) -> Option<Way> {
        let scale = self.scale();
        let mut pairs: Vec<(f64, Way)> = Vec::new();
        for (i, a) in self.low.nodes.iter().enumerate() {
            let to = |j: usize| self.near(self.high.nodes[j].uv, a.uv);
            let length = |j: usize| ((to(j) - a.uv) * scale).length_squared();
            let best =
                (0..self.high.nodes.len()).min_by(|j, k| length(*j).total_cmp(&length(*k)).then(j.cmp(k)));
            pairs.extend(best.map(|j| (length(j), Way { low: i, high: j, from: a.uv, to: to(j) })));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1.low, a.1.high).cmp(&(b.1.low, b.1.high))));
        let mut fallback: Option<(f64, Way)> = None;
        for (_, way) in pairs.into_iter().take(TRIES).filter(|p| self.is_free(&p.1)) {
            let clear = self.clearance(&way, scale) / self.ends(&way).0.max(self.ends(&way).1);
            if clear >= CLEAR {
                return Some(way);
            }
            if fallback.is_none_or(|f| clear > f.0) {
                fallback = Some((clear, way));
            }
        }
        fallback.map(|f| f.1)
    }

    /// Least distance from the way to a node of a hole.
    fn clearance(&self, way: &Way, scale: DVec2) -> f64 {
        let (a, d) = (way.from * scale, (way.to - way.from) * scale);
        let l = d.length_squared().max(f64::MIN_POSITIVE);
        let nodes = self.holes.iter().flat_map(|h| &h.nodes);
        let distance = |n: &UvNode| {
            let p = self.near(n.uv, 0.5 * (way.from + way.to)) * scale;
            (a + d * ((p - a).dot(d) / l).clamp(0.0, 1.0)).distance(p)
        };
        nodes.map(distance).fold(f64::INFINITY, f64::min)
    }

    /// Whether the way crosses no loop.
    fn is_free(&self, way: &Way) -> bool {
        // The ends touch their own loops: the cut is held against everything a little within.
        const WITHIN: f64 = 1e-6;
        let (a, b) = (way.from, way.to);
        let (p, q) = (a + (b - a) * WITHIN, b + (a - b) * WITHIN);
        let all = [self.low, self.high].into_iter().chain(self.holes);
        let mut segments = all.flat_map(|l| {
            let n = l.nodes.len();
            let last = move |i: usize| {
                // The closing segment of a loop that winds leads one period on.
                let next = l.nodes[(i + 1) % n].uv;
                let turns = f64::from(l.winding[0]);
                if i + 1 == n { next + DVec2::new(self.period * turns, 0.0) } else { next }
            };
            (0..n).map(move |i| (l.nodes[i].uv, last(i)))
        });
        !segments.any(|(s, t)| {
            [-2.0, -1.0, 0.0, 1.0, 2.0].iter().any(|k| {
                let d = DVec2::new(k * self.period, 0.0);
                cross(p, q, s + d, t + d)
            })
        })
    }

    /// Lengths of the segments at the two ends.
    fn ends(&self, way: &Way) -> (f64, f64) {
        let spacing = |l: &UvLoop, k: usize| {
            let n = l.nodes.len();
            let p = |k: usize| l.nodes[k % n].point;
            0.5 * (p(k).distance(p(k + 1)) + p(k).distance(p(k + n - 1)))
        };
        (spacing(self.low, way.low), spacing(self.high, way.high))
    }

    /// Shares of the way at which its inner nodes lie.
    fn shares(&self, way: &Way) -> Vec<f64> {
        let on: Vec<SurfacePoint> = (0..=PIECES)
            .map(|k| (self.at)(way.from + (way.to - way.from) * (k as f64 / PIECES as f64)))
            .collect();
        let mut length = vec![0.0];
        for w in on.windows(2) {
            length.push(length[length.len() - 1] + w[0].point.distance(w[1].point));
        }
        let (total, (a, b)) = (length[PIECES], self.ends(way));
        let size = |k: usize| {
            let from_ends = (a + self.gradation * length[k]).min(b + self.gradation * (total - length[k]));
            from_ends.min((self.size)(&on[k]).max(a.min(b)))
        };
        let mut sum = vec![0.0];
        for k in 1..=PIECES {
            sum.push(sum[k - 1] + 0.5 * (length[k] - length[k - 1]) * (1.0 / size(k - 1) + 1.0 / size(k)));
        }
        let n = if sum[PIECES].is_finite() { (sum[PIECES].round() as usize).clamp(1, MOST) } else { 1 };
        let mut k = 0;
        (1..n)
            .map(|i| {
                let wanted = sum[PIECES] * i as f64 / n as f64;
                while k + 2 < sum.len() && sum[k + 1] < wanted {
                    k += 1;
                }
                let within = ((wanted - sum[k]) / (sum[k + 1] - sum[k])).clamp(0.0, 1.0);
                (k as f64 + within) / PIECES as f64
            })
            .collect()
    }
}

/// Whether two segments cross properly or touch.
fn cross(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    use csalf_geom::predicates::orient2d;
    let s = |p, q, r| orient2d(p, q, r);
    let (x, y) = (s(a, b, c) * s(a, b, d), s(c, d, a) * s(c, d, b));
    x <= 0.0 && y <= 0.0 && (x < 0.0 || y < 0.0)
}
