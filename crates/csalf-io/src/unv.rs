//! I-DEAS universal files (`.unv`), written: nodes (data set 2411), elements (2412) and groups by name (2477). Edge sets
//! become rods, so that boundaries have elements of their own.

use crate::text::one_line;
use crate::{IoError, MeshView};
use csalf_geom::VertexId;
use std::io::Write;

/// I-DEAS' numbers of elements: rod, linear triangle and quad of a thin shell.
const ROD: u32 = 11;
const TRIANGLE: u32 = 91;
const QUAD: u32 = 94;

/// I-DEAS' numbers of entities in groups.
const NODE: u32 = 7;
const ELEMENT: u32 = 8;

/// A number as FORTRAN's D25.16 has it.
fn real(x: f64) -> String {
    let text = format!("{x:.16e}");
    let (m, e) = text.split_once('e').unwrap_or((&text, "0"));
    let (sign, digits) = e.strip_prefix('-').map_or(('+', e), |d| ('-', d));
    format!("{m}D{sign}{digits:0>2}")
}

/// Writes a mesh.
///
/// # Errors
/// [`IoError::Write`].
pub fn write(out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    let mesh = out.mesh;
    writeln!(w, "    -1\n  2411")?;
    for (i, [x, y, z]) in out.xyz().enumerate() {
        writeln!(w, "{:10}{:10}{:10}{:10}", i + 1, 1, 1, 11)?;
        writeln!(w, "{:>25}{:>25}{:>25}", real(x), real(y), real(z))?;
    }
    writeln!(w, "    -1\n    -1\n  2412")?;
    let mut number = 0u32;
    let mut element = |kind: u32, nodes: &[VertexId], w: &mut dyn Write| -> Result<u32, IoError> {
        number += 1;
        writeln!(w, "{number:10}{kind:10}{:10}{:10}{:10}{:10}", 1, 1, 7, nodes.len())?;
        if kind == ROD {
            writeln!(w, "{:10}{:10}{:10}", 0, 1, 1)?;
        }
        for v in nodes {
            write!(w, "{:10}", v.0 + 1)?;
        }
        writeln!(w)?;
        Ok(number)
    };
    for q in &mesh.quads {
        element(QUAD, q, w)?;
    }
    for t in &mesh.triangles {
        element(TRIANGLE, t, w)?;
    }
    let mut groups: Vec<(&str, u32, Vec<u32>)> = Vec::new();
    for (name, edges) in &out.sets.edges {
        let members: Result<Vec<u32>, IoError> = edges.iter().map(|e| element(ROD, e, w)).collect();
        groups.push((name, ELEMENT, members?));
    }
    for (name, nodes) in out.sets.nodes.iter().filter(|(n, _)| out.sets.edges.iter().all(|(e, _)| e != n)) {
        groups.push((name, NODE, nodes.iter().map(|v| v.0 + 1).collect()));
    }
    for (name, quads) in &out.sets.quads {
        groups.push((name, ELEMENT, quads.iter().map(|q| q.0 + 1).collect()));
    }
    writeln!(w, "    -1\n    -1\n  2477")?;
    for (k, (name, entity, members)) in groups.iter().enumerate() {
        writeln!(w, "{:10}{:10}{:10}{:10}{:10}{:10}{:10}{:10}", k + 1, 0, 0, 0, 0, 0, 0, members.len())?;
        writeln!(w, "{}", one_line(name))?;
        for pair in members.chunks(2) {
            for m in pair {
                write!(w, "{entity:10}{m:10}{:10}{:10}", 0, 0)?;
            }
            writeln!(w)?;
        }
    }
    Ok(writeln!(w, "    -1")?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_fortran_writes_them() {
        assert_eq!(real(1.0), "1.0000000000000000D+00");
        assert_eq!(real(-2.5e-7), "-2.4999999999999999D-07");
        assert!(real(-1e-300).len() <= 25);
    }
}
