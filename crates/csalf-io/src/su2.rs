//! SU2 meshes (`.su2`), written: `NELEM`, `NPOIN`, and a `MARKER_TAG` for every edge set on the boundary. Node and quad
//! sets and lines inside have no place in the format.

use crate::sides::Sides;
use crate::text::{Num, plain_name};
use crate::{IoError, MeshView};
use std::io::Write;

/// VTK's numbers of element types, which SU2 uses.
const LINE: u8 = 3;
const TRIANGLE: u8 = 5;
const QUAD: u8 = 9;

/// Writes a mesh.
///
/// # Errors
/// [`IoError::Write`].
pub fn write(out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    let mesh = out.mesh;
    writeln!(w, "NDIME= 2\nNELEM= {}", mesh.quads.len() + mesh.triangles.len())?;
    for (i, q) in mesh.quads.iter().enumerate() {
        writeln!(w, "{QUAD} {} {} {} {} {i}", q[0].0, q[1].0, q[2].0, q[3].0)?;
    }
    for (i, t) in mesh.triangles.iter().enumerate() {
        writeln!(w, "{TRIANGLE} {} {} {} {}", t[0].0, t[1].0, t[2].0, mesh.quads.len() + i)?;
    }
    writeln!(w, "NPOIN= {}", mesh.points.len())?;
    for (i, p) in mesh.points.iter().enumerate() {
        writeln!(w, "{} {} {i}", Num(p.x), Num(p.y))?;
    }
    let patches = Sides::new(mesh).patches(out);
    writeln!(w, "NMARK= {}", patches.len())?;
    for (name, sides) in &patches {
        writeln!(w, "MARKER_TAG= {}\nMARKER_ELEMS= {}", plain_name(name), sides.len())?;
        for s in sides {
            writeln!(w, "{LINE} {} {}", s.vertices[0], s.vertices[1])?;
        }
    }
    Ok(())
}
