//! The input of the mesher: already discretised loops, scars and hard points.

use crate::Point2;

pub use crate::defect::Defect;

/// What a loop bounds.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LoopKind {
    /// The loop around everything.
    Outer,
    /// The rim of a hole.
    Hole,
}

/// A closed, discretised boundary curve. Every node becomes a mesh vertex, every segment a mesh edge.
#[derive(Clone, PartialEq, Debug)]
pub struct Loop {
    /// Outer or hole.
    pub kind: LoopKind,
    /// Name in files, reports and sets: `outer`, `hole0`, ... or the caller's own.
    pub name: String,
    /// Nodes in order, the first not repeated. Either orientation is accepted.
    pub nodes: Vec<Point2>,
}

/// An open polyline that the mesh edges must follow. Its ends or inner nodes may be nodes of loops or other scars.
#[derive(Clone, PartialEq, Debug)]
pub struct Scar {
    /// Name in files, reports and sets: `scar0`, ...
    pub name: String,
    /// Nodes in order, at least two.
    pub nodes: Vec<Point2>,
}

/// A point inside the domain that must be a mesh vertex.
#[derive(Clone, PartialEq, Debug)]
pub struct HardPoint {
    /// Name in files, reports and sets: `point0`, ...
    pub name: String,
    /// Where it is.
    pub xy: Point2,
    /// Wanted edge length there, if the caller gives one.
    pub size: Option<f64>,
}

/// The area to be meshed: one outer loop, holes, scars and hard points. Plain data; [`Domain::check`] tells
/// everything that is wrong with it.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Domain {
    /// One outer loop and any number of holes, in any order.
    pub loops: Vec<Loop>,
    /// Open curves inside.
    pub scars: Vec<Scar>,
    /// Points inside.
    pub points: Vec<HardPoint>,
}

impl Domain {
    /// A domain of one outer loop.
    pub fn new(outer: Vec<Point2>) -> Self {
        Self {
            loops: vec![Loop { kind: LoopKind::Outer, name: "outer".into(), nodes: outer }],
            ..Self::default()
        }
    }

    /// Adds a hole, named `holeK` in order of addition.
    pub fn with_hole(mut self, nodes: Vec<Point2>) -> Self {
        let k = self.loops.iter().filter(|l| l.kind == LoopKind::Hole).count();
        self.loops.push(Loop { kind: LoopKind::Hole, name: format!("hole{k}"), nodes });
        self
    }

    /// Adds a scar, named `scarK` in order of addition.
    pub fn with_scar(mut self, nodes: Vec<Point2>) -> Self {
        self.scars.push(Scar { name: format!("scar{}", self.scars.len()), nodes });
        self
    }

    /// Adds a hard point, named `pointK` in order of addition.
    pub fn with_point(mut self, xy: Point2) -> Self {
        self.points.push(HardPoint { name: format!("point{}", self.points.len()), xy, size: None });
        self
    }
}
