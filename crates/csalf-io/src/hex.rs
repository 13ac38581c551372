//! Writes swept meshes of hexahedra: `.vtu` (in text), `.inp` (C3D8) and `.msh` 2.2.

use crate::{
    IoError, MeshFormat, Place,
    text::{Num, one_line, plain_name},
};
use csalf_mesh::HexMesh;
use std::io::Write;

/// VTK's and Gmsh's numbers of a hexahedron.
const VTK_HEX: u32 = 12;
const GMSH_HEX: u32 = 5;

/// Writes a mesh of hexahedra with its sets.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] of a format that is not for hexahedra.
pub fn write(format: MeshFormat, mesh: &HexMesh, title: &str, w: &mut dyn Write) -> Result<(), IoError> {
    match format {
        MeshFormat::Vtu => vtu(mesh, w),
        MeshFormat::Inp => inp(mesh, title, w),
        MeshFormat::Msh22 | MeshFormat::Msh41 => msh(mesh, w),
        other => {
            let message = "hexahedra are written as .vtu, .inp and .msh";
            Err(IoError::unsupported(other.name(), Place::Whole, message))
        }
    }
}

fn vtu(mesh: &HexMesh, w: &mut dyn Write) -> Result<(), IoError> {
    let n = mesh.hexes.len();
    writeln!(w, "<?xml version=\"1.0\"?>")?;
    writeln!(w, "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">")?;
    writeln!(
        w,
        "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{n}\">",
        mesh.points.len()
    )?;
    writeln!(w, "<CellData>")?;
    for (name, hexes) in &mesh.sets {
        let mut flags = vec![0_u8; n];
        for h in hexes {
            if let Some(f) = flags.get_mut(*h as usize) {
                *f = 1;
            }
        }
        let name = plain_name(name);
        writeln!(w, "<DataArray type=\"UInt8\" Name=\"{name}\" format=\"ascii\">")?;
        for f in flags {
            write!(w, "{f} ")?;
        }
        writeln!(w, "\n</DataArray>")?;
    }
    writeln!(w, "</CellData>\n<Points>")?;
    writeln!(w, "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">")?;
    for p in &mesh.points {
        writeln!(w, "{} {} {}", Num(p.x), Num(p.y), Num(p.z))?;
    }
    writeln!(w, "</DataArray>\n</Points>\n<Cells>")?;
    writeln!(w, "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">")?;
    for h in &mesh.hexes {
        write_corners(h.iter().map(|v| u64::from(v.0)), " ", w)?;
    }
    writeln!(w, "</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">")?;
    for k in 1..=n {
        write!(w, "{} ", 8 * k)?;
    }
    writeln!(w, "\n</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">")?;
    for _ in 0..n {
        write!(w, "{VTK_HEX} ")?;
    }
    writeln!(w, "\n</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")?;
    Ok(())
}

/// Numbers on one line.
fn write_corners(numbers: impl Iterator<Item = u64>, gap: &str, w: &mut dyn Write) -> Result<(), IoError> {
    let words: Vec<String> = numbers.map(|n| n.to_string()).collect();
    Ok(writeln!(w, "{}", words.join(gap))?)
}

fn inp(mesh: &HexMesh, title: &str, w: &mut dyn Write) -> Result<(), IoError> {
    writeln!(w, "*HEADING\n{}\n*NODE, NSET=NALL", one_line(title).replace('*', " "))?;
    for (i, p) in mesh.points.iter().enumerate() {
        writeln!(w, "{}, {}, {}, {}", i + 1, Num(p.x), Num(p.y), Num(p.z))?;
    }
    writeln!(w, "*ELEMENT, TYPE=C3D8, ELSET=EALL")?;
    for (i, h) in mesh.hexes.iter().enumerate() {
        let corners = h.iter().map(|v| u64::from(v.0) + 1);
        write_corners([i as u64 + 1].into_iter().chain(corners), ", ", w)?;
    }
    for (name, nodes) in &mesh.nodes {
        writeln!(w, "*NSET, NSET={}", plain_name(name))?;
        let numbers: Vec<u64> = nodes.iter().map(|v| u64::from(v.0) + 1).collect();
        numbers.chunks(10).try_for_each(|c| write_corners(c.iter().copied(), ", ", w))?;
    }
    for (name, hexes) in &mesh.sets {
        writeln!(w, "*ELSET, ELSET={}", plain_name(name))?;
        let numbers: Vec<u64> = hexes.iter().map(|h| u64::from(*h) + 1).collect();
        numbers.chunks(10).try_for_each(|c| write_corners(c.iter().copied(), ", ", w))?;
    }
    Ok(())
}

fn msh(mesh: &HexMesh, w: &mut dyn Write) -> Result<(), IoError> {
    // One group per element: the first set that holds it, or all the rest.
    let rest = mesh.sets.len() + 1;
    let mut group = vec![rest; mesh.hexes.len()];
    for (k, (_, hexes)) in mesh.sets.iter().enumerate().rev() {
        hexes.iter().for_each(|h| {
            if let Some(g) = group.get_mut(*h as usize) {
                *g = k + 1;
            }
        });
    }
    writeln!(w, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{rest}")?;
    for (k, (name, _)) in mesh.sets.iter().enumerate() {
        writeln!(w, "3 {} \"{}\"", k + 1, one_line(name).replace('"', "'"))?;
    }
    writeln!(w, "3 {rest} \"domain\"\n$EndPhysicalNames\n$Nodes\n{}", mesh.points.len())?;
    for (i, p) in mesh.points.iter().enumerate() {
        writeln!(w, "{} {} {} {}", i + 1, Num(p.x), Num(p.y), Num(p.z))?;
    }
    writeln!(w, "$EndNodes\n$Elements\n{}", mesh.hexes.len())?;
    for (i, (h, g)) in mesh.hexes.iter().zip(&group).enumerate() {
        write!(w, "{} {GMSH_HEX} 2 {g} {g} ", i + 1)?;
        write_corners(h.iter().map(|v| u64::from(v.0) + 1), " ", w)?;
    }
    writeln!(w, "$EndElements")?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_geom::VertexId;

    fn cube() -> HexMesh {
        let mut m = HexMesh::default();
        for z in [0.0, 1.0] {
            for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                m.points.push([x, y, z].into());
            }
        }
        m.hexes.push([0, 1, 2, 3, 4, 5, 6, 7].map(VertexId));
        m.sets.push(("all of it".into(), vec![0]));
        m.nodes.push(("source".into(), [0, 1, 2, 3].map(VertexId).to_vec()));
        m
    }

    fn text(format: MeshFormat) -> String {
        let mut out = Vec::new();
        write(format, &cube(), "a cube", &mut out).expect("it is written to memory");
        String::from_utf8(out).expect("it is text")
    }

    #[test]
    fn three_formats_have_the_cube() {
        let t = text(MeshFormat::Inp);
        assert!(
            t.contains("TYPE=C3D8")
                && t.contains("1, 1, 2, 3, 4, 5, 6, 7, 8")
                && t.contains("*NSET, NSET=source")
        );
        let t = text(MeshFormat::Msh22);
        assert!(t.contains("1 5 2 1 1 1 2 3 4 5 6 7 8") && t.contains("\"all of it\""));
        let t = text(MeshFormat::Vtu);
        assert!(t.contains("0 1 2 3 4 5 6 7") && t.contains("12 ") && t.contains("NumberOfCells=\"1\""));
        let mut out = Vec::new();
        assert!(write(MeshFormat::Obj, &cube(), "", &mut out).is_err());
    }
}
