//! Raw geometry: loops and scars of curves, before any node is placed on them.

use crate::curve::Curve;
use crate::{HardPoint, LoopKind, Point2};

/// One curve of a loop or scar, with wishes for its nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Where it runs; it starts where the edge before it ends.
    pub curve: Curve,
    /// Keep its start as a node even if there is no kink.
    pub corner: bool,
    /// Number of segments, if it is prescribed; at least one for each part between kinks.
    pub count: Option<usize>,
}

impl From<Curve> for Edge {
    fn from(curve: Curve) -> Self {
        Self { curve, corner: false, count: None }
    }
}

/// A closed loop of curves. Either orientation is accepted.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveLoop {
    /// Outer or hole.
    pub kind: LoopKind,
    /// Name in files, reports and sets.
    pub name: String,
    /// Curves in order, each starting where the one before it ends.
    pub edges: Vec<Edge>,
}

/// An open chain of curves.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveScar {
    /// Name in files, reports and sets.
    pub name: String,
    /// Curves in order, each starting where the one before it ends.
    pub edges: Vec<Edge>,
}

/// The area to be meshed, by its curves.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Geometry {
    /// One outer loop and any number of holes, in any order.
    pub loops: Vec<CurveLoop>,
    /// Open chains inside. An end may lie on a loop.
    pub scars: Vec<CurveScar>,
    /// Points inside.
    pub points: Vec<HardPoint>,
}

impl Geometry {
    /// A geometry of one outer loop.
    pub fn new(outer: Vec<Curve>) -> Self {
        let edges = outer.into_iter().map(Edge::from).collect();
        Self {
            loops: vec![CurveLoop { kind: LoopKind::Outer, name: "outer".into(), edges }],
            ..Self::default()
        }
    }

    /// Adds a hole, named `holeK` in order of addition.
    pub fn with_hole(mut self, curves: Vec<Curve>) -> Self {
        let k = self.loops.iter().filter(|l| l.kind == LoopKind::Hole).count();
        let edges = curves.into_iter().map(Edge::from).collect();
        self.loops.push(CurveLoop { kind: LoopKind::Hole, name: format!("hole{k}"), edges });
        self
    }

    /// Adds a scar, named `scarK` in order of addition.
    pub fn with_scar(mut self, curves: Vec<Curve>) -> Self {
        let edges = curves.into_iter().map(Edge::from).collect();
        self.scars.push(CurveScar { name: format!("scar{}", self.scars.len()), edges });
        self
    }

    /// All chains of curves: name, edges, closed. Loops first.
    pub fn chains(&self) -> impl Iterator<Item = (&str, &[Edge], bool)> {
        let loops = self.loops.iter().map(|l| (l.name.as_str(), l.edges.as_slice(), true));
        loops.chain(self.scars.iter().map(|s| (s.name.as_str(), s.edges.as_slice(), false)))
    }

    /// Diagonal of a box around all curves, from samples of them: for tolerances.
    pub fn diagonal(&self) -> f64 {
        /// Samples per curve (and per span of it): enough for the size of a box. *Arbitrary.*
        const SAMPLES: u32 = 8;
        let curves = self.chains().flat_map(|(_, edges, _)| edges).map(|e| &e.curve);
        let points = curves.flat_map(|c| {
            let (t0, t1) = c.range();
            let even = (0..=SAMPLES).map(move |k| t0 + (t1 - t0) * f64::from(k) / f64::from(SAMPLES));
            even.chain(c.breaks()).map(|t| c.eval(t).point)
        });
        crate::polygon::bounds(points).map_or(0.0, |(lo, hi): (Point2, Point2)| lo.distance(hi))
    }

    /// Everything that is wrong with the curves as such; what is wrong with the loops is found when they are
    /// discretised. Cost O(number of curves).
    pub fn check(&self) -> Vec<GeometryDefect> {
        let gap = Self::MAX_GAP * self.diagonal();
        let mut defects = Vec::new();
        for (name, edges, closed) in self.chains() {
            if edges.is_empty() {
                defects.push(GeometryDefect::NoCurves { name: name.into() });
            }
            for (index, edge) in edges.iter().enumerate() {
                if !edge.curve.is_finite() {
                    defects.push(GeometryDefect::BadCurve { name: name.into(), index });
                }
                if edge.count == Some(0) {
                    defects.push(GeometryDefect::NoSegments { name: name.into(), index });
                }
                let next = (index + 1) % edges.len();
                if !closed && next == 0 {
                    continue;
                }
                let (a, b) = (edge.curve.end(), edges[next].curve.start());
                if a.distance(b) > gap {
                    let (name, distance) = (name.into(), a.distance(b));
                    defects.push(GeometryDefect::Gap { name, index, distance, x: a.x, y: a.y });
                }
            }
        }
        defects
    }

    /// Largest gap between successive curves that is closed silently, as a share of the diagonal. Larger: hides
    /// faults; smaller: refuses drawings whose arcs are written with few digits. *Arbitrary.*
    pub const MAX_GAP: f64 = 1e-6;
}

/// One thing that is wrong with curves.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeometryDefect {
    /// A loop or scar without curves.
    #[error("{name} has no curves: add some or remove it")]
    NoCurves {
        /// The loop or scar.
        name: String,
    },
    /// A curve with too few points or a number that is not finite.
    #[error("curve {index} of {name} has too few points or a number that is not finite")]
    BadCurve {
        /// The loop or scar.
        name: String,
        /// The curve, from 0.
        index: usize,
    },
    /// A prescribed count of zero.
    #[error("curve {index} of {name} is given 0 segments; it needs at least 1")]
    NoSegments {
        /// The loop or scar.
        name: String,
        /// The curve, from 0.
        index: usize,
    },
    /// A curve does not start where the one before it ends (or a loop is not closed).
    #[error("{name} has a gap of {distance} after curve {index}, at ({x}, {y}): close it")]
    Gap {
        /// The loop or scar.
        name: String,
        /// The curve before the gap, from 0.
        index: usize,
        /// Width.
        distance: f64,
        /// End of that curve.
        x: f64,
        /// End of that curve.
        y: f64,
    },
    /// The size field is not positive somewhere on a curve, or so small that the nodes are too many.
    #[error(
        "the size on {name} near ({x}, {y}) is not positive, or far too small for the length of the curve"
    )]
    BadSize {
        /// The loop or scar.
        name: String,
        /// Where.
        x: f64,
        /// Where.
        y: f64,
    },
    /// All counts are prescribed, and their sum is odd.
    #[error(
        "the prescribed numbers of segments sum to {n_segments}, which is odd: change one of them by one"
    )]
    OddCounts {
        /// The sum over all loops.
        n_segments: usize,
    },
}

impl GeometryDefect {
    /// Where it is, if it has a place.
    pub fn place(&self) -> Option<Point2> {
        match self {
            Self::Gap { x, y, .. } | Self::BadSize { x, y, .. } => Some(Point2::new(*x, *y)),
            Self::NoCurves { .. }
            | Self::BadCurve { .. }
            | Self::NoSegments { .. }
            | Self::OddCounts { .. } => None,
        }
    }
}
