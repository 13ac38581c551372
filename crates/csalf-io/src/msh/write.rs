//! Writes `.msh` 4.1 and 2.2.
//!
//! 1. Elements of dimension 0 (node sets that are no edge sets), 1 (edge sets) and 2 (the mesh) get numbers in this
//!    order; dimension 2 keeps its order.
//! 2. Every run of elements that lie in the same sets is an entity (a "surface"); 4.1 gives it all their groups,
//!    2.2, which has room for one group per element, the first.

use super::{ALL, FORMAT};
use crate::{
    IoError, MeshView, MidNodes, Place,
    text::{Num, one_line},
};
use csalf_geom::VertexId;
use std::io::Write;

/// Gmsh's numbers of element types.
const POINT: u32 = 15;
const LINE: u32 = 1;
const TRIANGLE: u32 = 2;
const QUAD: u32 = 3;

/// A physical group.
struct Group {
    dim: u8,
    tag: usize,
    name: String,
}

/// Elements of one type on one entity.
struct Block<'a> {
    dim: u8,
    entity: usize,
    kind: u32,
    groups: Vec<usize>,
    elements: Vec<&'a [VertexId]>,
}

impl Block<'_> {
    /// Gmsh's number of the element type: of second order with mid-side nodes.
    fn number_of_kind(&self, mid: Option<&MidNodes>) -> u32 {
        match (self.kind, mid) {
            (LINE, Some(_)) => 8,
            (TRIANGLE, Some(_)) => 9,
            (QUAD, Some(m)) if m.has_centres() => 10,
            (QUAD, Some(_)) => 16,
            (kind, _) => kind,
        }
    }
}

/// Groups and blocks of a mesh.
fn layout<'a>(out: &MeshView<'a>) -> Result<(Vec<Group>, Vec<Block<'a>>), IoError> {
    let (mesh, sets) = (out.mesh, out.sets);
    let mut groups = Vec::new();
    let mut blocks = Vec::new();
    let lone = sets.nodes.iter().filter(|(name, _)| !sets.edges.iter().any(|(e, _)| e == name));
    for (k, (name, nodes)) in lone.enumerate() {
        groups.push(Group { dim: 0, tag: k + 1, name: name.clone() });
        let elements = nodes.iter().map(std::slice::from_ref).collect();
        blocks.push(Block { dim: 0, entity: k + 1, kind: POINT, groups: vec![k + 1], elements });
    }
    for (k, (name, edges)) in sets.edges.iter().enumerate() {
        groups.push(Group { dim: 1, tag: k + 1, name: name.clone() });
        let elements = edges.iter().map(|e| &e[..]).collect();
        blocks.push(Block { dim: 1, entity: k + 1, kind: LINE, groups: vec![k + 1], elements });
    }
    for (k, (name, _)) in sets.quads.iter().enumerate() {
        groups.push(Group { dim: 2, tag: k + 2, name: name.clone() });
    }
    groups.push(Group { dim: 2, tag: 1, name: ALL.into() });
    // Sets of each quad, as (quad, group) sorted by quad; then runs of equal lists.
    let mut member: Vec<(usize, usize)> = Vec::new();
    for (k, (name, quads)) in sets.quads.iter().enumerate() {
        if quads.iter().any(|q| q.index() >= mesh.quads.len()) {
            let message = format!("set {name} holds a quad that the mesh has not");
            return Err(IoError::unsupported(FORMAT, Place::Whole, message));
        }
        member.extend(quads.iter().map(|q| (q.index(), k + 2)));
    }
    member.sort_unstable();
    member.dedup();
    let mut of_quad = member.as_slice();
    let mut entities: std::collections::BTreeMap<Vec<usize>, usize> = std::collections::BTreeMap::new();
    let mut current: Option<Block<'a>> = None;
    for (q, corners) in mesh.quads.iter().enumerate() {
        let n = of_quad.iter().take_while(|m| m.0 == q).count();
        let (mine, rest) = of_quad.split_at(n);
        of_quad = rest;
        let same = current.as_ref().is_some_and(|b| {
            b.groups.len() == n + 1 && b.groups.iter().zip(mine.iter().map(|m| &m.1)).all(|(a, b)| a == b)
        });
        if !same {
            blocks.extend(current.take());
            // The group of all comes last, so that 2.2 takes a narrower one first.
            let groups: Vec<usize> = mine.iter().map(|m| m.1).chain([1]).collect();
            let next = entities.len() + 1;
            let entity = *entities.entry(groups.clone()).or_insert(next);
            current = Some(Block { dim: 2, entity, kind: QUAD, groups, elements: Vec::new() });
        }
        if let Some(b) = &mut current {
            b.elements.push(corners);
        }
    }
    blocks.extend(current);
    if !mesh.triangles.is_empty() {
        let next = entities.len() + 1;
        let entity = *entities.entry(vec![1]).or_insert(next);
        let elements = mesh.triangles.iter().map(|t| &t[..]).collect();
        blocks.push(Block { dim: 2, entity, kind: TRIANGLE, groups: vec![1], elements });
    }
    let n = mesh.points.len();
    if blocks.iter().flat_map(|b| &b.elements).any(|e| e.iter().any(|v| v.index() >= n)) {
        return Err(IoError::unsupported(
            FORMAT,
            Place::Whole,
            "an element or set holds a vertex that is not there",
        ));
    }
    Ok((groups, blocks))
}

fn write_head(version: &str, groups: &[Group], w: &mut dyn Write) -> Result<(), IoError> {
    writeln!(w, "$MeshFormat\n{version} 0 8\n$EndMeshFormat")?;
    writeln!(w, "$PhysicalNames\n{}", groups.len())?;
    for g in groups {
        writeln!(w, "{} {} \"{}\"", g.dim, g.tag, one_line(&g.name).replace('"', "'"))?;
    }
    writeln!(w, "$EndPhysicalNames")?;
    Ok(())
}

/// Three coordinates, as a line has them.
fn line([x, y, z]: [f64; 3]) -> String {
    let z = if z == 0.0 { "0".to_owned() } else { Num(z).to_string() };
    format!("{} {} {z}", Num(x), Num(y))
}

/// Writes version 4.1.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] if an element or set names what is not there.
pub fn write_41(out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    write_41_with(out, None, w)
}

/// Writes version 4.1; with mid-side nodes elements of second order.
///
/// # Errors
/// As [`write_41`].
pub fn write_41_with(out: &MeshView<'_>, mid: Option<&MidNodes>, w: &mut dyn Write) -> Result<(), IoError> {
    let (groups, blocks) = layout(out)?;
    write_head("4.1", &groups, w)?;
    let xyz: Vec<[f64; 3]> = out.xyz().collect();
    let first = xyz.first().copied().unwrap_or_default();
    let bound =
        |f: fn(f64, f64) -> f64| xyz.iter().fold(first, |b, p| [f(b[0], p[0]), f(b[1], p[1]), f(b[2], p[2])]);
    let (lo, hi) = (line(bound(f64::min)), line(bound(f64::max)));
    // One entity may have several blocks; it is declared once.
    let mut entities: Vec<&Block<'_>> = Vec::new();
    for b in &blocks {
        if !entities.iter().any(|e| (e.dim, e.entity) == (b.dim, b.entity)) {
            entities.push(b);
        }
    }
    entities.sort_by_key(|b| (b.dim, b.entity));
    let count = |dim: u8| entities.iter().filter(|b| b.dim == dim).count();
    writeln!(w, "$Entities\n{} {} {} 0", count(0), count(1), count(2).max(1))?;
    for b in &entities {
        write!(w, "{} ", b.entity)?;
        if b.dim == 0 {
            let p = b.elements.first().map_or_else(|| lo.clone(), |e| line(xyz[e[0].index()]));
            write!(w, "{p}")?;
        } else {
            write!(w, "{lo} {hi}")?;
        }
        write!(w, " {}", b.groups.len())?;
        for g in &b.groups {
            write!(w, " {g}")?;
        }
        writeln!(w, "{}", if b.dim == 0 { "" } else { " 0" })?;
    }
    if count(2) == 0 {
        writeln!(w, "1 {lo} {hi} 1 1 0")?;
    }
    let n = out.mesh.points.len() + mid.map_or(0, MidNodes::n_nodes);
    // All nodes belong to surface 1, so that they stay in their order.
    writeln!(w, "$EndEntities\n$Nodes\n1 {n} {} {n}\n2 1 0 {n}", n.min(1))?;
    for i in 1..=n {
        writeln!(w, "{i}")?;
    }
    for p in out.all_xyz(mid) {
        writeln!(w, "{}", line(p))?;
    }
    let n_elements: usize = blocks.iter().map(|b| b.elements.len()).sum();
    let n_blocks = blocks.iter().filter(|b| !b.elements.is_empty()).count();
    writeln!(w, "$EndNodes\n$Elements\n{n_blocks} {n_elements} {} {n_elements}", n_elements.min(1))?;
    let (mut number, mut quads) = (0, 0);
    for b in blocks.iter().filter(|b| !b.elements.is_empty()) {
        writeln!(w, "{} {} {} {}", b.dim, b.entity, b.number_of_kind(mid), b.elements.len())?;
        for e in &b.elements {
            number += 1;
            write!(w, "{number}")?;
            write_nodes(b, e, mid, &mut quads, w)?;
        }
    }
    writeln!(w, "$EndElements")?;
    write_cell_data(out, n_elements, w)
}

/// Writes version 2.2, without values per element (meshio cannot read those beside points and lines).
///
/// # Errors
/// As [`write_41`].
pub fn write_22(out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    write_22_with(out, None, w)
}

/// Writes version 2.2; with mid-side nodes elements of second order.
///
/// # Errors
/// As [`write_41`].
pub fn write_22_with(out: &MeshView<'_>, mid: Option<&MidNodes>, w: &mut dyn Write) -> Result<(), IoError> {
    let (groups, blocks) = layout(out)?;
    write_head("2.2", &groups, w)?;
    writeln!(w, "$Nodes\n{}", out.mesh.points.len() + mid.map_or(0, MidNodes::n_nodes))?;
    for (i, p) in out.all_xyz(mid).enumerate() {
        writeln!(w, "{} {}", i + 1, line(p))?;
    }
    let n_elements: usize = blocks.iter().map(|b| b.elements.len()).sum();
    writeln!(w, "$EndNodes\n$Elements\n{n_elements}")?;
    let (mut number, mut quads) = (0, 0);
    for b in &blocks {
        for e in &b.elements {
            number += 1;
            write!(
                w,
                "{number} {} 2 {} {}",
                b.number_of_kind(mid),
                b.groups.first().copied().unwrap_or(1),
                b.entity
            )?;
            write_nodes(b, e, mid, &mut quads, w)?;
        }
    }
    writeln!(w, "$EndElements")?;
    Ok(())
}

/// The nodes of an element; `quads` counts those of four corners, which are numbered as in the mesh.
fn write_nodes(
    block: &Block<'_>,
    corners: &[VertexId],
    mid: Option<&MidNodes>,
    quads: &mut usize,
    w: &mut dyn Write,
) -> Result<(), IoError> {
    let Some(m) = mid else { return write_corners(corners, w) };
    match (block.kind, corners) {
        (QUAD, &[a, b, c, d]) => {
            *quads += 1;
            write_corners(&m.quad(*quads - 1, &[a, b, c, d]), w)
        }
        (TRIANGLE, &[a, b, c]) => write_corners(&m.triangle(&[a, b, c]), w),
        (LINE, &[a, b]) => write_corners(&[a, b, m.of(a, b)], w),
        _ => write_corners(corners, w),
    }
}

fn write_corners(corners: &[VertexId], w: &mut dyn Write) -> Result<(), IoError> {
    for v in corners {
        write!(w, " {}", v.0 + 1)?;
    }
    Ok(writeln!(w)?)
}

/// Values per element; elements of dimension 2 are the last ones. Points and lines get 0: meshio wants a value for
/// every element.
fn write_cell_data(out: &MeshView<'_>, n_elements: usize, w: &mut dyn Write) -> Result<(), IoError> {
    let n_cells = out.mesh.quads.len() + out.mesh.triangles.len();
    for d in out.cell_data {
        if d.values.len() != n_cells {
            let message = format!("{} has {} values for {n_cells} elements", d.name, d.values.len());
            return Err(IoError::unsupported(FORMAT, Place::Whole, message));
        }
        let name = one_line(&d.name).replace('"', "'");
        writeln!(w, "$ElementData\n1\n\"{name}\"\n1\n0.0\n3\n0\n1\n{n_elements}")?;
        let lower = std::iter::repeat_n(&0.0, n_elements - n_cells);
        for (i, x) in lower.chain(&d.values).enumerate() {
            writeln!(w, "{} {}", i + 1, Num(*x))?;
        }
        writeln!(w, "$EndElementData")?;
    }
    Ok(())
}
