//! What can be wrong with a domain: one variant per way, each with its place and its cure.

use crate::Point2;
use std::fmt;

/// A place in the input: a node (or the segment that starts at it) of a loop, scar or point.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Name of the loop, scar or point.
    pub name: String,
    /// Node, or segment by its first node, counted from 0 as in the input.
    pub index: usize,
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} [{}] ({}, {})", self.name, self.index, self.x, self.y)
    }
}

/// One thing that is wrong with a domain. `name [i] (x, y)` in the messages is node i, or segment i from node i to
/// the next.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Defect {
    /// A loop with fewer than three nodes.
    #[error("{loop_name} has {n_nodes} nodes; a loop needs at least 3: add nodes or remove it")]
    TooFewNodes {
        /// Name of the loop.
        loop_name: String,
        /// How many it has, a repeated first node not counted.
        n_nodes: usize,
    },
    /// A scar with fewer than two nodes.
    #[error("{scar_name} has {n_nodes} nodes; a scar needs at least 2: add nodes or make it a hard point")]
    ScarTooShort {
        /// Name of the scar.
        scar_name: String,
        /// How many it has.
        n_nodes: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("{at} is not a finite position: correct or remove it")]
    NotFinite {
        /// The node or point.
        at: Place,
    },
    /// A coordinate is so large, or the whole domain so small, that products of coordinates leave the range of f64.
    #[error("{at}: the coordinates are beyond the range of the arithmetic (1e-70 to 1e70): use another unit")]
    Scale {
        /// The node or point.
        at: Place,
    },
    /// No loop is of kind outer.
    #[error("there is no outer loop: give one loop the kind outer")]
    NoOuterLoop,
    /// More than one loop is of kind outer.
    #[error("{} loops are outer ({}): mesh them one by one, or make all but one holes", .names.len(), .names.join(", "))]
    SeveralOuterLoops {
        /// Their names.
        names: Vec<String>,
    },
    /// Two nodes of one loop, or two successive ones of a scar, are the same point within the merge tolerance.
    #[error("{second} repeats {first}: remove one of the two nodes")]
    RepeatedNode {
        /// The earlier node.
        first: Place,
        /// The later node.
        second: Place,
    },
    /// Nodes of two loops are the same point within the merge tolerance.
    #[error(
        "{first} and {second} are one point: two loops may not touch, move them apart or join them into one"
    )]
    CoincidentNodes {
        /// Node of the one loop.
        first: Place,
        /// Node of the other.
        second: Place,
    },
    /// Two segments of one loop or scar cross.
    #[error("segments {first} and {second} cross near ({x}, {y}): a curve may not cross itself")]
    SelfIntersection {
        /// The one segment.
        first: Place,
        /// The other segment.
        second: Place,
        /// Where, approximately.
        x: f64,
        /// Where, approximately.
        y: f64,
    },
    /// Segments of two different loops or scars cross.
    #[error(
        "segments {first} and {second} cross near ({x}, {y}): move them apart, or let scars meet at a node"
    )]
    Crossing {
        /// The one segment.
        first: Place,
        /// The other segment.
        second: Place,
        /// Where, approximately.
        x: f64,
        /// Where, approximately.
        y: f64,
    },
    /// A node lies on a segment (within the merge tolerance) of which it is no end.
    #[error(
        "node {node} lies on segment {segment}: move it away, or (for a scar) put a node of the other there"
    )]
    Touching {
        /// The node.
        node: Place,
        /// The segment.
        segment: Place,
    },
    /// Two segments that share a node run along each other, or are one segment given twice.
    #[error("segments {first} and {second} run along each other: remove one of them, or open the angle")]
    Overlap {
        /// The one segment.
        first: Place,
        /// The other segment.
        second: Place,
    },
    /// A loop without area: all its nodes lie on one line.
    #[error("{name} has no area, all its nodes lie on one line: remove it, or make it a scar")]
    ZeroArea {
        /// Name of the loop.
        name: String,
    },
    /// A hole, scar or point that is not inside the outer loop, or a scar or point in a hole.
    #[error("{at} lies outside the domain: move it inside or remove it")]
    Outside {
        /// A node outside; for a scar, the node where it leaves.
        at: Place,
    },
    /// A hole around the outer loop.
    #[error("{hole} surrounds {outer}: exchange their kinds")]
    HoleAroundOuter {
        /// Name of the hole.
        hole: String,
        /// Name of the outer loop.
        outer: String,
    },
    /// A hole inside another hole.
    #[error(
        "{inner} lies inside the hole {outer}: remove it, or mesh the part between as a domain of its own"
    )]
    HoleInHole {
        /// A node of the inner one.
        inner: Place,
        /// Name of the outer one.
        outer: String,
    },
    /// A hard point on a segment (within the merge tolerance), not at a node.
    #[error("point {point} lies on segment {segment}: make it a node of that curve, or move it away")]
    PointOnSegment {
        /// The point.
        point: Place,
        /// The segment.
        segment: Place,
    },
    /// The wanted size at a hard point is not a positive number.
    #[error("the size {size} at {at} must be a positive number")]
    BadSize {
        /// The point.
        at: Place,
        /// The size given.
        size: f64,
    },
    /// The loops have an odd number of segments in total; no mesh of quads alone exists (4Q = 2E + N).
    #[error(
        "the loops have {n_segments} segments in total, an odd number; quads alone need an even one: \
         add or remove one node{}", odd_loops(.loops)
    )]
    OddTotal {
        /// The total.
        n_segments: usize,
        /// Names of the loops with an odd number.
        loops: Vec<String>,
    },
    /// Scars cut off a region with an odd number of segments round it (both sides of a scar count).
    #[error("the region right of ({x}, {y}) has {n_segments} segments round it, an odd number: {}", cure_text(.cure))]
    OddRegion {
        /// How many segments bound it.
        n_segments: usize,
        /// Leftmost node of the region.
        x: f64,
        /// Leftmost node of the region.
        y: f64,
        /// Scar segments: one node added to each makes this region and its partner even. Empty if nothing on the
        /// scars helps because the total is odd.
        cure: Vec<Place>,
    },
    /// There are more defects of the same kinds; the list was cut off.
    #[error("there are more such faults than the {listed} listed: correct these first")]
    More {
        /// How many are listed.
        listed: usize,
    },
}

impl Defect {
    /// Where it is: the nodes, segments or points that the message names; empty if it has no place.
    pub fn places(&self) -> Vec<Point2> {
        let of = |p: &Place| Point2::new(p.x, p.y);
        match self {
            Self::NotFinite { at } | Self::Scale { at } | Self::Outside { at } | Self::BadSize { at, .. } => {
                vec![of(at)]
            }
            Self::SelfIntersection { x, y, .. }
            | Self::Crossing { x, y, .. }
            | Self::OddRegion { x, y, .. } => {
                vec![Point2::new(*x, *y)]
            }
            Self::RepeatedNode { first, second }
            | Self::CoincidentNodes { first, second }
            | Self::Overlap { first, second } => vec![of(first), of(second)],
            Self::Touching { node, .. } => vec![of(node)],
            Self::HoleInHole { inner, .. } => vec![of(inner)],
            Self::PointOnSegment { point, .. } => vec![of(point)],
            Self::TooFewNodes { .. }
            | Self::ScarTooShort { .. }
            | Self::NoOuterLoop
            | Self::SeveralOuterLoops { .. }
            | Self::ZeroArea { .. }
            | Self::HoleAroundOuter { .. }
            | Self::OddTotal { .. }
            | Self::More { .. } => Vec::new(),
        }
    }
}

/// Something that is allowed but likely to give poor quads.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Notice {
    /// A hard point nearer to a segment than 0.3 of its length.
    #[error(
        "{point} is only {share:.3} of a segment length away from {segment}: the quads between will be poor"
    )]
    ClosePoint {
        /// The point.
        point: Place,
        /// The segment.
        segment: Place,
        /// Distance over the length of the segment, 0 to 0.3.
        share: f64,
    },
}

fn odd_loops(names: &[String]) -> String {
    const SHOWN: usize = 5;
    let more = if names.len() > SHOWN { ", ..." } else { "" };
    match names {
        [] => String::new(),
        _ => format!(" (odd: {}{more})", names[..names.len().min(SHOWN)].join(", ")),
    }
}

fn cure_text(places: &[Place]) -> String {
    if places.is_empty() {
        return "make the total number of segments of the loops even".into();
    }
    let list: Vec<_> = places.iter().map(ToString::to_string).collect();
    format!("add one node to the scar segment {}", list.join(" and one to "))
}
