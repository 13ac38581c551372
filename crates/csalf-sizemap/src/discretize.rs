//! Places nodes on the curves of a [`Geometry`], as far apart as the size field says: gives a [`Domain`].
//!
//! ```text
//!     ●━━━━━━━━━●       ●  kept nodes: kinks, ends, curves with a prescribed count, ends of scars on the curve
//!     ┃         ┃       ━  pieces between them: n = round(N*), N* = ∫ ds/h, node i at W = i N* / n
//!     ●━━━━━●━━━●
//! ```
//!
//! 1. `join_scars`: ends of scars that lie on another curve cut it there.
//! 2. `Plan::pieces`: chains of curves are cut into pieces at the nodes to be kept.
//! 3. `Measure::new`: W = ∫ ds/h along each piece, by adaptive Gauss quadrature.
//! 4. `choose_counts`: counts, at least what turning asks for; if the sum over all loops is odd, the count whose
//!    relative size error grows least is changed by one.
//! 5. `Measure::place`: the inverse of W by Newton's method; every node is a point of its curve.
//!
//! Cost O(number of nodes + samples). Source: handbook 1.9, 8.3, 10.1; parity as 10.2 with one face.

mod measure;

use crate::{Hint, SizeField};
use csalf_geom::{Domain, Edge, Geometry, GeometryDefect, Loop, Point2, Scar};
use measure::{Measure, Span};
use std::f64::consts::FRAC_PI_4;

/// Most nodes on one piece: a field that asks for more is taken for an error.
const MAX_SEGMENTS: f64 = 1e8;
/// Fewest nodes on a closed curve without a kink.
const MIN_CLOSED: usize = 8;

/// Makes strongly curved parts finer: the wanted length is at most 2 r sin(angle / 2) and at most sqrt(8 chord r), r
/// the radius of curvature. (Handbook 8.3.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvatureLimit {
    /// Largest turn along one segment, radians, > 0.
    pub angle: f64,
    /// Largest distance between segment and curve, model units, > 0; infinite for none.
    pub chord: f64,
    /// The limit never goes below this length, > 0.
    pub floor: f64,
}

/// How curves are discretised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscretizeOptions {
    /// A turn larger than this (radians) is a corner and keeps its node. Larger: loses corners; smaller: nodes at
    /// every facet of a polyline that stands for a smooth curve.
    pub corner_angle: f64,
    /// Largest turn along one segment of a smooth curve, radians: a full circle gets at least 2π / this.
    pub max_turn: f64,
    /// Make the total over all loops even.
    pub even: bool,
    /// Finer where curves are strongly bent.
    pub curvature: Option<CurvatureLimit>,
}

impl Default for DiscretizeOptions {
    fn default() -> Self {
        Self { corner_angle: 30f64.to_radians(), max_turn: FRAC_PI_4, even: true, curvature: None }
    }
}

/// A part of a chain between two kept nodes.
#[derive(Debug)]
struct Piece {
    measure: Measure,
    /// The edge whose prescribed count this is a part of.
    fixed_by: Option<usize>,
    n_min: usize,
    n: usize,
}

/// One chain of curves with its pieces.
#[derive(Debug)]
struct Chain<'a> {
    name: &'a str,
    edges: &'a [Edge],
    closed: bool,
    pieces: Vec<Piece>,
}

/// Discretises a geometry. Names are kept; a loop starts at its first kept node. Sizes of hard points are no
/// concern here. Scars that cut the domain into regions may leave odd ones: see
/// [`CheckOptions::repair_parity`](csalf_geom::CheckOptions).
///
/// # Errors
/// All defects of the curves; what is wrong with the loops themselves is told by [`Domain::check`].
pub fn discretize(
    geometry: &Geometry,
    field: &dyn SizeField,
    options: &DiscretizeOptions,
) -> Result<Domain, Vec<GeometryDefect>> {
    let mut defects = geometry.check();
    if !defects.is_empty() {
        return Err(defects);
    }
    let joints = Joints::find(geometry);
    let mut chains: Vec<Chain<'_>> = geometry
        .chains()
        .map(|(name, edges, closed)| Chain { name, edges, closed, pieces: Vec::new() })
        .collect();
    for (k, chain) in chains.iter_mut().enumerate() {
        if let Err(p) = chain.cut(&joints.cuts[k], field, options) {
            defects.push(GeometryDefect::BadSize { name: chain.name.into(), x: p.x, y: p.y });
        }
    }
    if !defects.is_empty() {
        return Err(defects);
    }
    chains.iter_mut().for_each(|c| c.choose_counts());
    if options.even {
        make_even(&mut chains)?;
    }
    let mut hint = Hint::default();
    let mut nodes = chains.iter().map(|c| c.nodes(field, options, &mut hint));
    let loops = geometry.loops.iter().zip(nodes.by_ref());
    let loops = loops.map(|(l, nodes)| Loop { kind: l.kind, name: l.name.clone(), nodes }).collect();
    let scars = geometry.scars.iter().zip(nodes).zip(&joints.ends).map(|((s, mut nodes), ends)| {
        if let (Some(p), Some(first)) = (ends[0], nodes.first_mut()) {
            *first = p;
        }
        if let (Some(p), Some(last)) = (ends[1], nodes.last_mut()) {
            *last = p;
        }
        Scar { name: s.name.clone(), nodes }
    });
    let scars = scars.collect();
    Ok(Domain { loops, scars, points: geometry.points.clone() })
}

/// Where scars end on other curves.
#[derive(Debug)]
struct Joints {
    /// Per chain: edge and parameter at which it needs a node.
    cuts: Vec<Vec<(usize, f64)>>,
    /// Per scar: the point of the other curve at which its first and last node shall lie.
    ends: Vec<[Option<Point2>; 2]>,
}

impl Joints {
    fn find(geometry: &Geometry) -> Self {
        let gap = Geometry::MAX_GAP * geometry.diagonal();
        let chains: Vec<_> = geometry.chains().collect();
        let n_loops = geometry.loops.len();
        let mut out = Self { cuts: vec![Vec::new(); chains.len()], ends: Vec::new() };
        for s in n_loops..chains.len() {
            let edges = chains[s].1;
            let places = [edges.first().map(|e| e.curve.start()), edges.last().map(|e| e.curve.end())];
            let ends = places.map(|p| out.join(p?, s, &chains, gap));
            out.ends.push(ends);
        }
        out
    }

    /// Cuts the first chain but `scar` that passes `p`, and tells where.
    fn join(&mut self, p: Point2, scar: usize, chains: &[(&str, &[Edge], bool)], gap: f64) -> Option<Point2> {
        for (k, (_, edges, _)) in chains.iter().enumerate().filter(|(k, _)| *k != scar) {
            for (e, edge) in edges.iter().enumerate() {
                let t = measure::nearest(&edge.curve, p);
                let q = edge.curve.eval(t).point;
                if q.distance(p) > gap {
                    continue;
                }
                let (t0, t1) = edge.curve.range();
                let next = edges.get((e + 1) % edges.len()).filter(|_| e + 1 < edges.len() || chains[k].2);
                let (start, end) = (edge.curve.start(), edge.curve.end());
                return Some(if q.distance(start) <= gap {
                    self.cuts[k].push((e, t0));
                    start
                } else if q.distance(end) <= gap {
                    // The node there is the start of the next curve, if there is one.
                    self.cuts[k].push(if next.is_some() {
                        ((e + 1) % edges.len(), f64::NEG_INFINITY)
                    } else {
                        (e, t1)
                    });
                    next.map_or(end, |n| n.curve.start())
                } else {
                    self.cuts[k].push((e, t));
                    q
                });
            }
        }
        None
    }
}

impl Chain<'_> {
    /// Finds the pieces. The error is a place where the size is not usable.
    fn cut(
        &mut self,
        cuts: &[(usize, f64)],
        field: &dyn SizeField,
        options: &DiscretizeOptions,
    ) -> Result<(), Point2> {
        // All spans in order, and whether each starts at a kept node.
        let mut spans: Vec<Span> = Vec::new();
        let mut keeps: Vec<bool> = Vec::new();
        let n_edges = self.edges.len();
        for (e, edge) in self.edges.iter().enumerate() {
            let (t0, t1) = edge.curve.range();
            let mut ts: Vec<(f64, bool)> = edge.curve.breaks().into_iter().map(|t| (t, false)).collect();
            ts.push((t0, false));
            ts.extend(cuts.iter().filter(|c| c.0 == e && c.1 < t1).map(|c| (c.1.max(t0), true)));
            ts.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            ts.dedup_by(|later, kept| later.0 == kept.0);
            let before = (e > 0 || self.closed).then(|| &self.edges[(e + n_edges - 1) % n_edges]);
            let wished = edge.corner || edge.count.is_some() || before.is_none_or(|b| b.count.is_some());
            for (i, &(t, kept)) in ts.iter().enumerate() {
                let to = ts.get(i + 1).map_or(t1, |n| n.0);
                spans.push(Span { edge: e, t0: t, t1: to });
                keeps.push(kept || i == 0 && wished);
            }
        }
        let n = spans.len();
        let dir_in = |s: &Span| self.edges[s.edge].curve.direction(s.t0, s.t1);
        let dir_out = |s: &Span| -self.edges[s.edge].curve.direction(s.t1, s.t0);
        for i in 0..n {
            if i > 0 || self.closed {
                let (u, v) = (dir_out(&spans[(i + n - 1) % n]), dir_in(&spans[i]));
                keeps[i] |= u.perp_dot(v).atan2(u.dot(v)).abs() > options.corner_angle;
            }
        }
        let first = keeps.iter().position(|k| *k);
        let smooth_closed = self.closed && first.is_none();
        spans.rotate_left(first.unwrap_or(0));
        keeps.rotate_left(first.unwrap_or(0));

        let mut from = 0;
        for i in 1..=n {
            if i < n && !keeps[i] {
                continue;
            }
            let part = &spans[from..i];
            let measure = Measure::new(self.edges, part, field, options)?;
            let by_turn = (measure.turning / options.max_turn - 0.01).ceil().max(1.0);
            let n_min = (by_turn as usize).max(if smooth_closed { MIN_CLOSED } else { 1 });
            let fixed_by = self.edges[part[0].edge].count.map(|_| part[0].edge);
            self.pieces.push(Piece { measure, fixed_by, n_min, n: 0 });
            from = i;
        }
        Ok(())
    }

    fn choose_counts(&mut self) {
        for p in &mut self.pieces {
            p.n = (p.measure.wanted().round() as usize).max(p.n_min);
        }
        // Prescribed counts, shared among the pieces of their edge: one each, then always to the longest.
        for (e, count) in self.edges.iter().enumerate().filter_map(|(e, edge)| Some((e, edge.count?))) {
            let own: Vec<usize> =
                (0..self.pieces.len()).filter(|&i| self.pieces[i].fixed_by == Some(e)).collect();
            own.iter().for_each(|&i| self.pieces[i].n = 1);
            for _ in own.len()..count {
                let load = |i: usize| self.pieces[i].measure.wanted() / self.pieces[i].n as f64;
                // The first of equals.
                let most = own.iter().copied().reduce(|a, b| if load(b) > load(a) { b } else { a });
                if let Some(i) = most {
                    self.pieces[i].n += 1;
                }
            }
        }
        // A loop needs three segments.
        while self.closed && self.pieces.iter().map(|p| p.n).sum::<usize>() < 3 {
            let free = self.pieces.iter_mut().filter(|p| p.fixed_by.is_none());
            let Some(p) = free.reduce(|a, b| if b.measure.wanted() > a.measure.wanted() { b } else { a })
            else {
                break;
            };
            p.n += 1;
            p.n_min = p.n;
        }
    }

    /// Nodes of the chain, each piece with its start; of an open chain also the end.
    fn nodes(&self, field: &dyn SizeField, options: &DiscretizeOptions, hint: &mut Hint) -> Vec<Point2> {
        let mut out = Vec::with_capacity(self.pieces.iter().map(|p| p.n).sum::<usize>() + 1);
        for p in &self.pieces {
            p.measure.place(self.edges, p.n, field, options, hint, &mut out);
        }
        if let (false, Some(last)) = (self.closed, self.edges.last()) {
            out.push(last.curve.end());
        }
        out
    }
}

/// Changes one count of the loops by one if their sum is odd: the one whose error |ln(n / N*)| grows least.
fn make_even(chains: &mut [Chain<'_>]) -> Result<(), Vec<GeometryDefect>> {
    let loops = || chains.iter().enumerate().filter(|(_, c)| c.closed);
    let pieces = || loops().flat_map(|(c, l)| l.pieces.iter().enumerate().map(move |(i, p)| (c, i, p)));
    let n_segments = pieces().map(|(_, _, p)| p.n).sum::<usize>();
    if n_segments % 2 == 0 {
        return Ok(());
    }
    let mut best: Option<(f64, usize, usize, usize)> = None;
    for (c, i, p) in pieces().filter(|(_, _, p)| p.fixed_by.is_none()) {
        let error = |n: usize| (n as f64 / p.measure.wanted()).ln().abs();
        // The larger first: of equals the finer is taken.
        for n in [p.n + 1, p.n - 1] {
            let cost = error(n) - error(p.n);
            let enough = chains[c].pieces.iter().map(|p| p.n).sum::<usize>() + n >= 3 + p.n;
            if n >= p.n_min && enough && best.is_none_or(|b| cost < b.0) {
                best = Some((cost, c, i, n));
            }
        }
    }
    let Some((_, c, i, n)) = best else { return Err(vec![GeometryDefect::OddCounts { n_segments }]) };
    chains[c].pieces[i].n = n;
    Ok(())
}

#[cfg(test)]
mod tests;
