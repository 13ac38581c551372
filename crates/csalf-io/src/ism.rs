//! ISM-v2 (`.mesh`), written: the mesh of spectral elements that HOHQMesh writes and Trixi.jl, FLUXO and others read.
//! Nodes, edges with the elements on both sides, and per element its corners, which sides are curved, and the names of
//! its sides. With mid-side nodes the polynomial order is two and sides on curves have three points; otherwise all sides
//! are straight.
//!
//! ```text
//!        3               corners 1 2 3 4 counter-clockwise; sides run from 1 to 2, 2 to 3, 4 to 3, 1 to 4
//!     4─────▶3
//!   4 ▲      ▲ 2         an edge: its nodes, its elements, its side in each; a side that runs against the edge is
//!     1─────▶2           negative; beyond the boundary element and side are 0
//!        1
//! ```
//!
//! Names of sides are those of edge sets, for the boundary alone (`---` inside). Node and quad sets have no place in the
//! format. Source: *The HOHQMesh Mesh File Formats*; D. A. Kopriva, *Implementing Spectral Methods*, 2009, algorithm 148.

use crate::sides::Sides;
use crate::text::{Num, plain_name};
use crate::{IoError, MeshView, MidNodes, Place};
use csalf_geom::{Point2, VertexId};
use std::io::Write;

const FORMAT: &str = "ISM-v2";

/// Corners at start and end of the sides, from 0.
const ENDS: [[usize; 2]; 4] = [[0, 1], [1, 2], [3, 2], [0, 3]];

/// Where an edge lies: element and side, from 1; the side is negative if it runs against the edge.
type Beside = [i64; 2];

/// An edge while all are collected: the element and side that come to it first, its ends, and what lies beside it.
type Found = ((usize, usize), [u32; 2], [Beside; 2]);

/// Writes a mesh.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] of triangles and of nine nodes per quad.
pub fn write(out: &MeshView<'_>, mid: Option<&MidNodes>, w: &mut dyn Write) -> Result<(), IoError> {
    let mesh = out.mesh;
    let refuse = |message: &str| Err(IoError::unsupported(FORMAT, Place::Whole, message));
    if !mesh.triangles.is_empty() {
        return refuse("the format has no triangles");
    }
    if mid.is_some_and(MidNodes::has_centres) {
        return refuse("the format has no node inside a quad: leave the centres out");
    }
    if mesh.quads.iter().flatten().any(|v| v.index() >= mesh.points.len()) {
        return refuse("an element names a vertex that is not there");
    }
    let order = if mid.is_some() { 2 } else { 1 };
    let edges = edges(&mesh.quads);
    writeln!(w, "ISM-V2")?;
    writeln!(w, "{} {} {} {order}", mesh.points.len(), edges.len(), mesh.quads.len())?;
    for p in &mesh.points {
        place(*p, w)?;
    }
    for ([a, b], [left, right]) in &edges {
        writeln!(w, "{} {} {} {} {} {}", a + 1, b + 1, left[0], right[0], left[1], right[1])?;
    }
    let names = names(out);
    for (i, q) in mesh.quads.iter().enumerate() {
        writeln!(w, "{} {} {} {}", q[0].0 + 1, q[1].0 + 1, q[2].0 + 1, q[3].0 + 1)?;
        let middles = ENDS.map(|e| mid.and_then(|m| bent(out, m, e.map(|k| q[k]))));
        let flags = middles.map(|m| u8::from(m.is_some()));
        writeln!(w, "{} {} {} {}", flags[0], flags[1], flags[2], flags[3])?;
        for (e, middle) in ENDS.iter().zip(middles) {
            let Some(middle) = middle else { continue };
            for p in [mesh.points[q[e[0]].index()], middle, mesh.points[q[e[1]].index()]] {
                place(p, w)?;
            }
        }
        // Sides of the mesher run counter-clockwise; they are the same four.
        let name: [&str; 4] = std::array::from_fn(|k| names.get(4 * i + k).map_or("---", |n| n.as_str()));
        writeln!(w, "{} {} {} {}", name[0], name[1], name[2], name[3])?;
    }
    Ok(())
}

fn place(p: Point2, w: &mut dyn Write) -> Result<(), IoError> {
    Ok(writeln!(w, "{} {} 0.0", Num(p.x), Num(p.y))?)
}

/// The middle of a side, if it is not that of the chord.
fn bent(out: &MeshView<'_>, mid: &MidNodes, [a, b]: [VertexId; 2]) -> Option<Point2> {
    let points = &out.mesh.points;
    // As the mid-side nodes are made: the smaller vertex first.
    let (low, high) = (a.min(b), a.max(b));
    let m = mid.point(a, b)?.truncate();
    (m != points[low.index()].midpoint(points[high.index()])).then_some(m)
}

/// All edges in the order in which the elements come to them, with the elements beside them.
fn edges(quads: &[[VertexId; 4]]) -> Vec<([u32; 2], [Beside; 2])> {
    // Smaller vertex, larger vertex, element, side: sorted, the two uses of an edge are neighbours.
    let mut uses: Vec<(u32, u32, usize, usize)> = Vec::with_capacity(4 * quads.len());
    for (i, q) in quads.iter().enumerate() {
        for (k, e) in ENDS.iter().enumerate() {
            let (a, b) = (q[e[0]].0, q[e[1]].0);
            uses.push((a.min(b), a.max(b), i, k));
        }
    }
    uses.sort_unstable();
    let mut edges: Vec<Found> = Vec::new();
    let ends = |i: usize, k: usize| ENDS[k].map(|c| quads[i][c].0);
    let mut rest = uses.as_slice();
    while let [(a, b, i, k), tail @ ..] = rest {
        let own = ends(*i, *k);
        let first = [*i as i64 + 1, *k as i64 + 1];
        match tail {
            [(c, d, j, l), tail @ ..] if (c, d) == (a, b) => {
                let side = *l as i64 + 1;
                let sign = if ends(*j, *l) == own { 1 } else { -1 };
                edges.push(((*i, *k), own, [first, [*j as i64 + 1, sign * side]]));
                rest = tail;
            }
            _ => {
                edges.push(((*i, *k), own, [first, [0, 0]]));
                rest = tail;
            }
        }
    }
    edges.sort_unstable_by_key(|e| e.0);
    edges.into_iter().map(|(_, nodes, beside)| (nodes, beside)).collect()
}

/// Names of the sides of all quads, in their order.
fn names(out: &MeshView<'_>) -> Vec<String> {
    let mut names = vec!["---".to_owned(); 4 * out.mesh.quads.len()];
    for (name, sides) in Sides::new(out.mesh).patches(out) {
        for s in sides {
            names[4 * s.element + s.side] = plain_name(&name);
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_mesh::{NamedSets, QuadMesh};

    #[test]
    fn two_quads_as_the_format_wants_them() {
        let v = VertexId::new;
        let points = [(0., 0.), (1., 0.), (2., 0.), (0., 1.), (1., 1.), (2., 1.)].map(Point2::from).to_vec();
        // The second is turned so that its side 3 meets side 2 of the first.
        let quads = vec![[v(0), v(1), v(4), v(3)], [v(2), v(5), v(4), v(1)]];
        let mesh = QuadMesh { points, quads, triangles: Vec::new() };
        let edges = vec![("the wall".into(), vec![[v(0), v(1)], [v(1), v(2)]])];
        let sets = NamedSets { edges, ..NamedSets::default() };
        let view = MeshView { mesh: &mesh, heights: &[], sets: &sets, cell_data: &[], title: "" };
        let mut bytes = Vec::new();
        write(&view, None, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[..2], ["ISM-V2", "6 7 2 1"]);
        assert_eq!(lines[2], "0.0 0.0 0.0");
        // Side 2 of the first runs from 2 to 5, side 3 of the second from its fourth corner 2 to its third 5.
        assert_eq!(
            lines[8..15],
            [
                "1 2 1 0 1 0",
                "2 5 1 2 2 3",
                "4 5 1 0 3 0",
                "1 4 1 0 4 0",
                "3 6 2 0 1 0",
                "6 5 2 0 2 0",
                "3 2 2 0 4 0",
            ]
        );
        assert_eq!(lines[15..18], ["1 2 5 4", "0 0 0 0", "the_wall --- boundary boundary"]);
        assert_eq!(lines[18..], ["3 6 5 2", "0 0 0 0", "boundary boundary --- the_wall"]);
    }
}
