//! Feature recognition on loops: full circles and slots are holes, and get names that patterns can pick.

use super::{Face, FaceShape, Model};
use crate::geometry::{Curve, Frame, Surface};
use glam::DVec3;

/// The shape of a hole-like loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HoleShape {
    /// A full circle, of one edge or several.
    Circle {
        /// Diameter.
        diameter: f64,
    },
    /// Two half circles joined by two parallel lines.
    Slot {
        /// Width: the diameter of its ends.
        width: f64,
        /// Length over all.
        length: f64,
    },
}

impl HoleShape {
    /// The diameter of a circle, the width of a slot.
    pub const fn diameter(&self) -> f64 {
        match *self {
            Self::Circle { diameter } => diameter,
            Self::Slot { width, .. } => width,
        }
    }
}

/// A hole-like inner loop of a face.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopFeature {
    /// Name: `hole1`, `hole2`, ... in the order of faces and loops.
    pub name: String,
    /// The face.
    pub face: usize,
    /// The loop of the face.
    pub loop_index: usize,
    /// Its shape.
    pub shape: HoleShape,
    /// Its centre.
    pub center: DVec3,
}

/// Parts of lengths that count as equal: files carry six to eight digits.
const EQUAL: f64 = 1e-5;

/// All hole-like loops of a model: inner loops of planar faces that are full circles or slots. (The rims of a bore
/// in a curved face are no circles; they are found as inner loops of any shape only by the name `inner*`.)
pub fn loop_features(model: &Model) -> Vec<LoopFeature> {
    let mut features = Vec::new();
    for (f, face) in model.faces.iter().enumerate() {
        let FaceShape::Surface(Surface::Plane(_), _) = &face.shape else { continue };
        let outer = outer_loop(model, face);
        for (k, _) in face.loops.iter().enumerate().filter(|(k, _)| *k != outer) {
            if let Some((shape, center)) = shape_of(model, face, k) {
                let name = format!("hole{}", features.len() + 1);
                features.push(LoopFeature { name, face: f, loop_index: k, shape, center });
            }
        }
    }
    features
}

/// The loop of a face with the largest box; the first of equals.
pub(crate) fn outer_loop(model: &Model, face: &Face) -> usize {
    let size = |k: usize| {
        let points = face.loops[k].uses.iter().flat_map(|u| {
            let e = &model.edges[u.edge];
            (0..8_u32).map(move |i| e.at(f64::from(i) / 8.0).point)
        });
        let bounds = points
            .fold(None, |b, p| Some(b.map_or((p, p), |(lo, hi): (DVec3, DVec3)| (lo.min(p), hi.max(p)))));
        bounds.map_or(0.0, |(lo, hi)| lo.distance(hi))
    };
    (0..face.loops.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)).then(b.cmp(a))).unwrap_or(0)
}

fn shape_of(model: &Model, face: &Face, k: usize) -> Option<(HoleShape, DVec3)> {
    let edges: Vec<_> = face.loops[k].uses.iter().map(|u| &model.edges[u.edge]).collect();
    let arc = |e: &super::Edge| -> Option<(Frame, f64, f64)> {
        match e.curve {
            Curve::Ellipse { frame, a, b } if (a - b).abs() <= EQUAL * a => {
                Some((frame, a, (e.range[1] - e.range[0]).abs()))
            }
            _ => None,
        }
    };
    let arcs: Vec<_> = edges.iter().filter_map(|e| arc(e)).collect();
    let (frame, radius, _) = *arcs.first()?;
    if arcs.len() == edges.len() {
        let one = arcs.iter().all(|(f, r, _)| {
            f.origin.distance(frame.origin) <= EQUAL * radius && (r - radius).abs() <= EQUAL * radius
        });
        let turn: f64 = arcs.iter().map(|a| a.2).sum();
        let full = (turn - std::f64::consts::TAU).abs() <= EQUAL;
        return (one && full).then_some((HoleShape::Circle { diameter: 2.0 * radius }, frame.origin));
    }
    // A slot: arcs of one radius around two centres, half a turn each, and two lines.
    let lines = edges.iter().filter(|e| matches!(e.curve, Curve::Line { .. })).count();
    let far = arcs.iter().find(|(f, ..)| f.origin.distance(frame.origin) > EQUAL * radius)?.0.origin;
    let at_one = |f: &Frame| {
        f.origin.distance(frame.origin) <= EQUAL * radius || f.origin.distance(far) <= EQUAL * radius
    };
    let same = arcs.iter().all(|(f, r, _)| at_one(f) && (r - radius).abs() <= EQUAL * radius);
    let turn: f64 = arcs.iter().map(|a| a.2).sum();
    let slot = lines == 2
        && lines + arcs.len() == edges.len()
        && same
        && (turn - std::f64::consts::TAU).abs() <= EQUAL;
    let length = frame.origin.distance(far) + 2.0 * radius;
    slot.then_some((HoleShape::Slot { width: 2.0 * radius, length }, (frame.origin + far) * 0.5))
}
