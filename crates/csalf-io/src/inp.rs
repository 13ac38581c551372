//! Abaqus and CalculiX input (`.inp`): `*NODE`, `*ELEMENT`, `*NSET`, `*ELSET`. An edge set is written as the set of
//! its nodes, in order along the curve. Numbers have at most 20 characters: CalculiX reads no longer ones.

use crate::{
    IoError, MeshData, MeshView, MidNodes, Place, WriteOptions,
    builder::Builder,
    text::{Cursor, Num20, one_line, plain_name},
};
use std::io::Write;

const FORMAT: &str = "Abaqus";

/// Which elements quads and triangles become; of quadratic ones see [`write_with`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum InpElement {
    /// Shells: S4 and S3.
    #[default]
    Shell,
    /// Plane stress: CPS4 and CPS3.
    PlaneStress,
    /// Plane strain: CPE4 and CPE3.
    PlaneStrain,
    /// Bodies of revolution about the y axis: CAX4 and CAX3.
    Axisymmetric,
}

impl InpElement {
    /// Names of the quad and the triangle.
    const fn names(self, quadratic: bool) -> (&'static str, &'static str) {
        match (self, quadratic) {
            (Self::Shell, false) => ("S4", "S3"),
            (Self::PlaneStress, false) => ("CPS4", "CPS3"),
            (Self::PlaneStrain, false) => ("CPE4", "CPE3"),
            (Self::Axisymmetric, false) => ("CAX4", "CAX3"),
            (Self::Shell, true) => ("S8R", "S6"),
            (Self::PlaneStress, true) => ("CPS8", "CPS6"),
            (Self::PlaneStrain, true) => ("CPE8", "CPE6"),
            (Self::Axisymmetric, true) => ("CAX8", "CAX6"),
        }
    }
}

/// Writes a mesh of shells.
///
/// # Errors
/// [`IoError::Write`].
pub fn write(out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    write_with(out, &WriteOptions::default(), w)
}

/// Writes a mesh of the elements asked for; with mid-side nodes S8R, CPS8, CPE8 or CAX8, and the sets of edges hold
/// those, too.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] of elements with nine nodes.
pub fn write_with(out: &MeshView<'_>, how: &WriteOptions<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    let mesh = out.mesh;
    if how.mid.is_some_and(MidNodes::has_centres) {
        return Err(IoError::unsupported(
            FORMAT,
            Place::Whole,
            "there are no elements of nine nodes, ask for eight",
        ));
    }
    let (quad, triangle) = how.element.names(how.mid.is_some());
    writeln!(w, "*HEADING\n{}\n*NODE, NSET=NALL", one_line(out.title).replace('*', " "))?;
    for (i, [x, y, z]) in out.all_xyz(how.mid).enumerate() {
        writeln!(w, "{}, {}, {}, {}", i + 1, Num20(x), Num20(y), Num20(z))?;
    }
    if !mesh.quads.is_empty() {
        writeln!(w, "*ELEMENT, TYPE={quad}, ELSET=EALL")?;
    }
    for (i, q) in mesh.quads.iter().enumerate() {
        match how.mid {
            None => writeln!(w, "{}, {}, {}, {}, {}", i + 1, q[0].0 + 1, q[1].0 + 1, q[2].0 + 1, q[3].0 + 1)?,
            Some(m) => {
                write!(w, "{}, ", i + 1)?;
                write_list(m.quad(i, q).iter().map(|v| v.0 + 1), w)?;
            }
        }
    }
    if !mesh.triangles.is_empty() {
        writeln!(w, "*ELEMENT, TYPE={triangle}, ELSET=EALL")?;
    }
    for (i, t) in mesh.triangles.iter().enumerate() {
        let number = mesh.quads.len() + i + 1;
        match how.mid {
            None => writeln!(w, "{number}, {}, {}, {}", t[0].0 + 1, t[1].0 + 1, t[2].0 + 1)?,
            Some(m) => {
                write!(w, "{number}, ")?;
                write_list(m.triangle(t).iter().map(|v| v.0 + 1), w)?;
            }
        }
    }
    for (name, nodes) in node_sets(out, how.mid) {
        let unsorted = if out.sets.nodes.iter().any(|(n, _)| *n == name) { "" } else { ", UNSORTED" };
        writeln!(w, "*NSET, NSET={}{unsorted}", plain_name(&name))?;
        write_list(nodes.into_iter().map(|v| v + 1), w)?;
    }
    for (name, quads) in &out.sets.quads {
        writeln!(w, "*ELSET, ELSET={}", plain_name(name))?;
        write_list(quads.iter().map(|q| q.0 + 1), w)?;
    }
    Ok(())
}

/// Node sets, and edge sets of other names as sets of nodes. With mid-side nodes, those of edge sets take part.
pub(crate) fn node_sets(out: &MeshView<'_>, mid: Option<&MidNodes>) -> Vec<(String, Vec<u32>)> {
    let edges_of = |name: &str| out.sets.edges.iter().find(|(n, _)| n == name).map(|(_, e)| e.as_slice());
    let mut all = Vec::new();
    for (name, nodes) in &out.sets.nodes {
        let members = match (mid, edges_of(name)) {
            (Some(m), Some(edges)) => m.along(edges),
            _ => nodes.clone(),
        };
        all.push((name.clone(), members.iter().map(|v| v.0).collect()));
    }
    for (name, edges) in &out.sets.edges {
        if out.sets.nodes.iter().all(|(n, _)| n != name) {
            let members = match mid {
                Some(m) => m.along(edges).iter().map(|v| v.0).collect(),
                None => nodes_of_edges(edges),
            };
            all.push((name.clone(), members));
        }
    }
    all
}

/// The nodes of an edge set, in order, none twice in a row nor the first at the end again.
pub(crate) fn nodes_of_edges(edges: &[[csalf_geom::VertexId; 2]]) -> Vec<u32> {
    let mut nodes: Vec<u32> = edges.iter().flatten().map(|v| v.0).collect();
    nodes.dedup();
    if nodes.len() > 1 && nodes.first() == nodes.last() {
        nodes.pop();
    }
    nodes
}

/// Numbers, ten a line (16 are allowed), commas between.
fn write_list(numbers: impl Iterator<Item = u32>, w: &mut dyn Write) -> Result<(), IoError> {
    for (k, n) in numbers.enumerate() {
        match k {
            0 => write!(w, "{n}")?,
            k if k % 10 == 0 => write!(w, ",\n{n}")?,
            _ => write!(w, ", {n}")?,
        }
    }
    Ok(writeln!(w)?)
}

/// Corners and nodes of an element type, corners first; `None` of types that are not read.
fn corners_of(kind: &str) -> Option<(usize, usize)> {
    let kind = kind.to_ascii_uppercase();
    let base = kind.trim_end_matches(|c: char| !c.is_ascii_digit());
    match base {
        "S4" | "CPS4" | "CPE4" | "CAX4" | "CGAX4" | "M3D4" | "R3D4" | "DS4" | "DC2D4" | "DCAX4"
        | "SFM3D4" | "AC2D4" => Some((4, 4)),
        "S8" | "CPS8" | "CPE8" | "CAX8" | "CGAX8" | "M3D8" | "DS8" | "DC2D8" | "DCAX8" | "SFM3D8"
        | "AC2D8" => Some((4, 8)),
        "M3D9" | "S9" => Some((4, 9)),
        "S3" | "CPS3" | "CPE3" | "CAX3" | "CGAX3" | "M3D3" | "R3D3" | "DS3" | "DC2D3" | "DCAX3"
        | "SFM3D3" | "STRI3" | "AC2D3" => Some((3, 3)),
        "S6" | "STRI65" | "CPS6" | "CPE6" | "CAX6" | "CGAX6" | "M3D6" | "DS6" | "DC2D6" | "DCAX6"
        | "SFM3D6" | "AC2D6" => Some((3, 6)),
        "B21" | "B31" | "B23" | "B33" | "T2D2" | "T3D2" | "R2D2" => Some((2, 2)),
        _ => None,
    }
}

/// What the data lines of a keyword mean.
enum Block {
    Skip,
    Node { set: Option<usize> },
    Element { n_corners: usize, n_nodes: usize, set: Option<usize> },
    NodeSet { at: usize, generate: bool },
    ElementSet { at: usize, generate: bool },
}

/// The position of the set of this name (compared without case), made if it is new.
fn set_at(sets: &mut Vec<(String, Vec<u64>)>, name: &str) -> usize {
    sets.iter().position(|s| s.0.eq_ignore_ascii_case(name)).unwrap_or_else(|| {
        sets.push((name.to_owned(), Vec::new()));
        sets.len() - 1
    })
}

/// Reads nodes, shell and plane elements, beams and trusses (as edges) and sets. Parts and instances are read as if
/// they were one model.
///
/// # Errors
/// [`IoError::Syntax`] or [`IoError::Unsupported`], with the line.
pub fn read(bytes: &[u8]) -> Result<MeshData, IoError> {
    let mut text = Cursor::new(bytes, FORMAT);
    let mut out = Builder::new(FORMAT, Place::Line);
    let mut block = Block::Skip;
    let mut n_lines = 0;
    // An element's data may go on over several lines.
    let mut pending: Vec<u64> = Vec::new();
    while let Some(line) = text.line() {
        n_lines += 1;
        let fail = |m: String| IoError::syntax(FORMAT, Place::Line(n_lines), m);
        let line = String::from_utf8_lossy(line);
        let line = line.trim();
        if line.is_empty() || line.starts_with("**") {
            continue;
        }
        if let Some(keyword) = line.strip_prefix('*') {
            if !pending.is_empty() {
                return Err(fail("the element before this line is not complete".into()));
            }
            block = read_keyword(keyword, n_lines, &mut out)?;
            continue;
        }
        let fields = line.split(',').map(str::trim);
        let number = |w: &str| {
            w.parse::<u64>().map_err(|_| fail(format!("{w:?} is not a number of a node or element")))
        };
        match &block {
            Block::Skip => {}
            Block::Node { set } => {
                let mut fields = fields;
                let id = number(fields.next().unwrap_or(""))?;
                let mut xyz = [0.0; 3];
                for (k, w) in fields.take(3).enumerate().filter(|(_, w)| !w.is_empty()) {
                    xyz[k] = w.parse().map_err(|_| fail(format!("{w:?} is not a coordinate")))?;
                }
                out.node(id, xyz, n_lines)?;
                if let Some(s) = *set {
                    out.node_sets[s].1.push(id);
                }
            }
            Block::Element { n_corners, n_nodes, set } => {
                for w in fields.filter(|w| !w.is_empty()) {
                    pending.push(number(w)?);
                }
                if pending.len() > n_nodes + 1 {
                    return Err(fail(format!("an element with {} nodes", pending.len() - 1)));
                }
                if pending.len() == n_nodes + 1 {
                    let (corners, middles) = pending[1..].split_at(*n_corners);
                    out.element(pending[0], corners, n_lines);
                    out.middles(middles);
                    if let Some(s) = *set {
                        out.element_sets[s].1.push(pending[0]);
                    }
                    pending.clear();
                }
            }
            Block::NodeSet { at, generate } | Block::ElementSet { at, generate } => {
                let words: Vec<&str> = fields.filter(|w| !w.is_empty()).collect();
                let sets = match block {
                    Block::NodeSet { .. } => &mut out.node_sets,
                    _ => &mut out.element_sets,
                };
                if *generate {
                    let n: Vec<u64> = words.iter().map(|w| number(w)).collect::<Result<_, _>>()?;
                    let (&[from, to], step) =
                        (n.get(..2).and_then(|s| s.try_into().ok()).unwrap_or(&[1, 0]), n.get(2));
                    let step = step.copied().unwrap_or(1).max(1);
                    // A file that asks for far more members than it can have entities is broken.
                    if to.saturating_sub(from) / step > 16 * bytes.len() as u64 {
                        return Err(fail(format!("a set from {from} to {to}")));
                    }
                    let mut k = from;
                    while k <= to {
                        sets[*at].1.push(k);
                        k = match k.checked_add(step) {
                            Some(k) => k,
                            None => break,
                        };
                    }
                    continue;
                }
                for w in words {
                    if let Ok(n) = w.parse() {
                        sets[*at].1.push(n);
                    } else if let Some(other) = sets.iter().find(|s| s.0.eq_ignore_ascii_case(w)) {
                        let members = other.1.clone();
                        sets[*at].1.extend(members);
                    } else {
                        return Err(fail(format!("{w:?} is neither a number nor a set")));
                    }
                }
            }
        }
    }
    if !pending.is_empty() {
        return Err(IoError::syntax(FORMAT, Place::Line(n_lines), "the last element is not complete"));
    }
    // The sets of all are ours or of no use.
    out.node_sets.retain(|s| s.0 != "NALL");
    out.element_sets.retain(|s| s.0 != "EALL");
    out.finish()
}

fn read_keyword(keyword: &str, line: usize, out: &mut Builder) -> Result<Block, IoError> {
    let mut parts = keyword.split(',').map(str::trim);
    let name = parts.next().unwrap_or("").to_ascii_uppercase();
    let parameters: Vec<(String, &str)> = parts
        .map(|p| match p.split_once('=') {
            Some((k, v)) => (k.trim().to_ascii_uppercase(), v.trim().trim_matches('"')),
            None => (p.to_ascii_uppercase(), ""),
        })
        .collect();
    let get = |key: &str| parameters.iter().find(|p| p.0 == key).map(|p| p.1);
    let need = |key: &str| {
        get(key)
            .filter(|v| !v.is_empty())
            .ok_or_else(|| IoError::syntax(FORMAT, Place::Line(line), format!("*{name} without {key}")))
    };
    let generate = get("GENERATE").is_some();
    Ok(match name.as_str() {
        "NODE" => Block::Node { set: get("NSET").map(|s| set_at(&mut out.node_sets, s)) },
        "ELEMENT" => {
            let kind = need("TYPE")?;
            let (n_corners, n_nodes) = corners_of(kind).ok_or_else(|| {
                IoError::unsupported(FORMAT, Place::Line(line), format!("element type {kind}"))
            })?;
            Block::Element { n_corners, n_nodes, set: get("ELSET").map(|s| set_at(&mut out.element_sets, s)) }
        }
        "NSET" => Block::NodeSet { at: set_at(&mut out.node_sets, need("NSET")?), generate },
        "ELSET" => Block::ElementSet { at: set_at(&mut out.element_sets, need("ELSET")?), generate },
        "INCLUDE" => return Err(IoError::unsupported(FORMAT, Place::Line(line), "*INCLUDE")),
        _ => Block::Skip,
    })
}
