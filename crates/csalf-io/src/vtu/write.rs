//! Writes `.vtu`, the arrays appended raw at the end (default) or in line as base64.
//!
//! ```text
//!   <UnstructuredGrid>
//!     <FieldData>   nset:NAME, eset:NAME (pairs), qset:NAME     sets, as vertex and cell numbers
//!     <Piece>       CellData, Points, Cells
//!   <AppendedData>  _ [u64 length][bytes] [u64 length][bytes] ...
//! ```

use super::{
    FORMAT, VTK_BIQUADRATIC_QUAD, VTK_QUAD, VTK_QUADRATIC_QUAD, VTK_QUADRATIC_TRIANGLE, VTK_TRIANGLE,
};
use crate::{IoError, MeshView, MidNodes, error::Place};
use base64::Engine as _;
use std::io::Write;

/// How the arrays are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum VtuEncoding {
    /// Raw bytes behind the XML: smallest and fastest.
    #[default]
    AppendedRaw,
    /// Base64 within the XML: a third larger, but valid XML.
    Base64,
}

/// One array to be written.
struct Array {
    head: String,
    bytes: Vec<u8>,
}

/// Little-endian bytes of a list of numbers.
macro_rules! bytes_of {
    ($values:expr, $n:expr, $t:ty) => {{
        let mut out = Vec::with_capacity($n * std::mem::size_of::<$t>());
        for v in $values {
            out.extend_from_slice(&(v as $t).to_le_bytes());
        }
        out
    }};
}

/// Writes a mesh with its sets and cell values.
///
/// # Errors
/// As [`write_as`].
pub fn write(out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    write_as(out, VtuEncoding::AppendedRaw, None, w)
}

/// Writes a mesh in the encoding asked for; with mid-side nodes quadratic cells. Cost O(n) time and memory.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] if a cell array is not as long as there are elements, or the
/// mesh has more than 2³¹ corners.
pub fn write_as(
    out: &MeshView<'_>,
    encoding: VtuEncoding,
    mid: Option<&MidNodes>,
    w: &mut dyn Write,
) -> Result<(), IoError> {
    let mesh = out.mesh;
    let n_cells = mesh.quads.len() + mesh.triangles.len();
    let fits = |n: usize| i32::try_from(n).is_ok();
    let n_points = mesh.points.len() + mid.map_or(0, MidNodes::n_nodes);
    let per_side = if mid.is_some() { 3 } else { 1 };
    if !fits(n_points) || !fits(per_side * (4 * mesh.quads.len() + 3 * mesh.triangles.len())) {
        return Err(IoError::unsupported(FORMAT, Place::Whole, "the mesh needs more than 31 bits"));
    }
    let (fields, values, geometry) = (field_arrays(out), cell_arrays(out, n_cells)?, grid_arrays(out, mid));
    let all: Vec<&Array> = fields.iter().chain(&values).chain(&geometry).collect();
    let raw = encoding == VtuEncoding::AppendedRaw && !confuses_meshio(&all);

    writeln!(w, "<?xml version=\"1.0\"?>")?;
    writeln!(w, "<!-- {} -->", comment(out.title))?;
    writeln!(
        w,
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">"
    )?;
    writeln!(w, "<UnstructuredGrid>")?;
    let mut offset = 0;
    let mut element = |a: &Array, w: &mut dyn Write| -> Result<(), IoError> {
        if raw {
            writeln!(w, "<DataArray {} format=\"appended\" offset=\"{offset}\"/>", a.head)?;
            offset += 8 + a.bytes.len();
        } else {
            let head = (a.bytes.len() as u64).to_le_bytes();
            let text = base64::engine::general_purpose::STANDARD.encode([&head[..], &a.bytes[..]].concat());
            writeln!(w, "<DataArray {} format=\"binary\">{text}</DataArray>", a.head)?;
        }
        Ok(())
    };
    if !fields.is_empty() {
        writeln!(w, "<FieldData>")?;
        fields.iter().try_for_each(|a| element(a, w))?;
        writeln!(w, "</FieldData>")?;
    }
    writeln!(w, "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{n_cells}\">", n_points)?;
    if !values.is_empty() {
        writeln!(w, "<CellData>")?;
        values.iter().try_for_each(|a| element(a, w))?;
        writeln!(w, "</CellData>")?;
    }
    let (points, cells) = geometry.split_at(1);
    writeln!(w, "<Points>")?;
    points.iter().try_for_each(|a| element(a, w))?;
    writeln!(w, "</Points>")?;
    writeln!(w, "<Cells>")?;
    cells.iter().try_for_each(|a| element(a, w))?;
    writeln!(w, "</Cells>")?;
    writeln!(w, "</Piece>")?;
    writeln!(w, "</UnstructuredGrid>")?;
    if raw {
        write!(w, "<AppendedData encoding=\"raw\">\n_")?;
        for a in &all {
            w.write_all(&(a.bytes.len() as u64).to_le_bytes())?;
            w.write_all(&a.bytes)?;
        }
        writeln!(w, "\n</AppendedData>")?;
    }
    writeln!(w, "</VTKFile>")?;
    Ok(())
}

/// Sets, as arrays of numbers that belong to the grid as a whole.
fn field_arrays(out: &MeshView<'_>) -> Vec<Array> {
    let array = |prefix: &str, name: &str, components: usize, bytes: Vec<u8>| Array {
        head: format!(
            "type=\"Int32\" Name=\"{prefix}:{}\" NumberOfComponents=\"{components}\" NumberOfTuples=\"{}\"",
            escape(name),
            bytes.len() / 4 / components
        ),
        bytes,
    };
    let sets = out.sets;
    let nodes = sets
        .nodes
        .iter()
        .map(|(name, v)| array("nset", name, 1, bytes_of!(v.iter().map(|v| v.0), v.len(), i32)));
    let edges = sets.edges.iter().map(|(name, e)| {
        array("eset", name, 2, bytes_of!(e.iter().flatten().map(|v| v.0), 2 * e.len(), i32))
    });
    let quads = sets
        .quads
        .iter()
        .map(|(name, q)| array("qset", name, 1, bytes_of!(q.iter().map(|q| q.0), q.len(), i32)));
    nodes.chain(edges).chain(quads).filter(|a| !a.bytes.is_empty()).collect()
}

fn cell_arrays(out: &MeshView<'_>, n_cells: usize) -> Result<Vec<Array>, IoError> {
    let mut arrays = Vec::new();
    for d in out.cell_data {
        if d.values.len() != n_cells {
            let message = format!("{} has {} values for {n_cells} elements", d.name, d.values.len());
            return Err(IoError::unsupported(FORMAT, Place::Whole, message));
        }
        arrays.push(Array {
            head: format!("type=\"Float64\" Name=\"{}\"", escape(&d.name)),
            bytes: bytes_of!(d.values.iter().copied(), n_cells, f64),
        });
    }
    Ok(arrays)
}

/// Points, connectivity, offsets, types.
fn grid_arrays(out: &MeshView<'_>, mid: Option<&MidNodes>) -> Vec<Array> {
    if let Some(mid) = mid {
        return quadratic_arrays(out, mid);
    }
    let (mesh, nq, nt) = (out.mesh, out.mesh.quads.len(), out.mesh.triangles.len());
    let xyz = out.xyz().flatten();
    let corners = mesh.quads.iter().flatten().chain(mesh.triangles.iter().flatten()).map(|v| v.0);
    let ends = (1..=nq).map(|i| 4 * i).chain((1..=nt).map(|i| 4 * nq + 3 * i));
    let types = std::iter::repeat_n(VTK_QUAD, nq).chain(std::iter::repeat_n(VTK_TRIANGLE, nt));
    let array = |head: &str, bytes: Vec<u8>| Array { head: head.to_owned(), bytes };
    vec![
        array(
            "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"",
            bytes_of!(xyz, 3 * mesh.points.len(), f64),
        ),
        array("type=\"Int32\" Name=\"connectivity\"", bytes_of!(corners, 4 * nq + 3 * nt, i32)),
        array("type=\"Int32\" Name=\"offsets\"", bytes_of!(ends, nq + nt, i32)),
        array("type=\"UInt8\" Name=\"types\"", types.collect()),
    ]
}

/// Points, connectivity, offsets, types of quadratic cells.
fn quadratic_arrays(out: &MeshView<'_>, mid: &MidNodes) -> Vec<Array> {
    let mesh = out.mesh;
    let xyz = out.all_xyz(Some(mid)).flatten();
    let (mut nodes, mut ends, mut types) = (Vec::new(), Vec::new(), Vec::new());
    for (i, q) in mesh.quads.iter().enumerate() {
        nodes.extend(mid.quad(i, q));
        ends.push(nodes.len());
        types.push(if mid.has_centres() { VTK_BIQUADRATIC_QUAD } else { VTK_QUADRATIC_QUAD });
    }
    for t in &mesh.triangles {
        nodes.extend(mid.triangle(t));
        ends.push(nodes.len());
        types.push(VTK_QUADRATIC_TRIANGLE);
    }
    let array = |head: &str, bytes: Vec<u8>| Array { head: head.to_owned(), bytes };
    vec![
        array(
            "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"",
            bytes_of!(xyz, 3 * (mesh.points.len() + mid.n_nodes()), f64),
        ),
        array("type=\"Int32\" Name=\"connectivity\"", bytes_of!(nodes.iter().map(|v| v.0), nodes.len(), i32)),
        array("type=\"Int32\" Name=\"offsets\"", bytes_of!(ends.iter().copied(), ends.len(), i32)),
        array("type=\"UInt8\" Name=\"types\"", types),
    ]
}

/// meshio finds an appended array by its offset after it has changed the offsets of the arrays before it (to those
/// of base64): true if it would then take one of those. Such a file is written in base64.
fn confuses_meshio(arrays: &[&Array]) -> bool {
    let (mut raw, mut base64) = (0, 0);
    let mut changed = Vec::new();
    for a in arrays {
        if changed.contains(&raw) {
            return true;
        }
        changed.push(base64);
        raw += 8 + a.bytes.len();
        base64 += (8 + a.bytes.len()).div_ceil(3) * 4;
        // The first array keeps offset 0, which no later one has.
    }
    false
}

/// A text as it may stand in an XML attribute.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// A text as it may stand in an XML comment: one line, no double hyphen.
fn comment(text: &str) -> String {
    let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    clean.replace('-', "\u{2010}")
}
