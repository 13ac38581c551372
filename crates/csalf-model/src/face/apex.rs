//! The apex of a cone inside a face: a cap of three or four quads around it is made here, and what is left is a tube.
//!
//! ```text
//!         ●───○───●         ● corners, ○ ends of the spokes, all on a ring around the apex A
//!        ╱    │    ╲        the quads are A ○ ● ○; the ring becomes a loop of the face, and the rest is unrolled
//!       ○──── A ────○       without distortion
//! ```
//!
//! A mesh through a chart with the apex inside has quads there that span half a turn and are turned over in space.

use super::NodeName;
use super::trim::{UvLoop, UvNode};
use crate::geometry::Surface;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Angle on the surface of a quad at the apex.
const QUAD: f64 = 0.5 * PI;
/// How much farther out the corners are than the spokes' ends.
const CORNER: f64 = 1.15;
/// The ring stays within this share of the distance from the apex to the nearest loop.
const ROOM: f64 = 0.35;

/// The cap.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cap {
    /// The node at the apex.
    pub(super) apex: NodeName,
    /// Where it is.
    pub(super) point: DVec3,
    /// The quads, the first corner at the apex, counter-clockwise against the surface's normal.
    pub(super) quads: Vec<[NodeName; 4]>,
}

/// Makes the cap and the loop that is left of it. `around` is the only loop that winds; `h` the wanted length at the apex.
/// `None` if the surface is no cone or there is no room.
pub(super) fn cap(
    surface: &Surface,
    loops: &[UvLoop],
    around: &UvLoop,
    apex: Option<UvNode>,
    h: f64,
    n_own: &mut u32,
) -> Option<(UvLoop, Cap)> {
    let Surface::Cone { angle, .. } = surface else { return None };
    let pole = surface.poles().into_iter().flatten().next()?;
    let sine = angle.sin().abs();
    let n_quads = ((TAU * sine / QUAD).round() as usize).clamp(3, 4);
    let n = 2 * n_quads;
    let all = loops.iter().chain([around]).flat_map(|l| &l.nodes);
    let room = ROOM * all.map(|n| (n.uv.y - pole).abs()).fold(f64::INFINITY, f64::min);
    let wanted = (n as f64 * h / (TAU * sine)).max(h);
    let distance = wanted.min(room);
    if !(distance > 0.0 && distance.is_finite()) {
        return None;
    }
    let side = if around.nodes.first()?.uv.y < pole { -1.0 } else { 1.0 };
    let winding = -around.winding[0];
    let start = around.nodes.first()?.uv.x;
    let first = *n_own;
    *n_own += n as u32;
    let nodes: Vec<UvNode> = (0..n)
        .map(|j| {
            let u = start + f64::from(winding) * TAU * j as f64 / n as f64;
            let d = if j % 2 == 0 { distance } else { distance * CORNER };
            let uv = DVec2::new(u, pole + side * d);
            UvNode { name: NodeName::Own(first + j as u32), uv, point: surface.eval(uv).point }
        })
        .collect();
    let name = apex.map_or_else(
        || {
            *n_own += 1;
            NodeName::Own(*n_own - 1)
        },
        |a| a.name,
    );
    let point = apex.map_or_else(|| surface.eval(DVec2::new(start, pole)).point, |a| a.point);
    let quads = (0..n_quads)
        .map(|k| {
            let at = |j: usize| nodes[(2 * k + j) % n];
            let quad = [at(0), at(1), at(2)].map(|n| n.name);
            // Against the surface's normal in the middle of the quad.
            let middle = surface.eval(at(1).uv).normal();
            let turned = (at(1).point - point).cross(at(2).point - at(0).point).dot(middle) < 0.0;
            if turned { [name, quad[2], quad[1], quad[0]] } else { [name, quad[0], quad[1], quad[2]] }
        })
        .collect();
    let ring = UvLoop { nodes, winding: [winding, 0], source: around.source };
    Some((ring, Cap { apex: name, point, quads }))
}
