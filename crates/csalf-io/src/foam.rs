//! OpenFOAM cases: the mesh extruded by one cell, as `constant/polyMesh` beside the file `NAME.foam` by which ParaView
//! opens a case.
//!
//! ```text
//!        d'────c'      z = thickness       faces: sides between cells, by owner then neighbour;
//!       /│    /│                           sides on the boundary, a patch for each edge set;
//!      a'────b'│       point i + n is      bottoms and tops, the patch frontAndBack (empty)
//!      │ d───│─c       above point i
//!      a────b          z = 0               normals point from the owner outwards
//! ```
//!
//! Quad sets become cell zones.

use crate::sides::{Side, Sides};
use crate::text::{Num, plain_name};
use crate::{IoError, MeshView};
use csalf_geom::polygon::bounds;
use std::fs;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Thickness, as a part of the larger side of the box. *Arbitrary*: fluxes through `empty` patches are not computed.
const THICKNESS: f64 = 0.05;

/// Writes the case that `path` (`CASE/NAME.foam`) stands in.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_case(out: &MeshView<'_>, path: &Path) -> Result<(), IoError> {
    let folder = path.parent().unwrap_or(Path::new("")).join("constant").join("polyMesh");
    fs::create_dir_all(&folder)?;
    let (mesh, n) = (out.mesh, out.mesh.points.len());
    let (low, high) = bounds(mesh.points.iter().copied()).unwrap_or_default();
    let z = THICKNESS * (high - low).max_element();
    let n_cells = mesh.quads.len() + mesh.triangles.len();

    write(&folder, "points", "vectorField", |w| {
        writeln!(w, "{}\n(", 2 * n)?;
        for z in [0.0, z] {
            for p in &mesh.points {
                writeln!(w, "({} {} {})", Num(p.x), Num(p.y), Num(z))?;
            }
        }
        Ok(writeln!(w, ")")?)
    })?;

    let sides = Sides::new(mesh);
    let across = |s: &Side| sides.find(s.vertices[1], s.vertices[0]).map(|o| o.element);
    let mut inner: Vec<(usize, usize, Side)> = sides
        .iter()
        .filter_map(|s| Some((s.element, across(s)?, *s)))
        .filter(|(owner, neighbour, _)| owner < neighbour)
        .collect();
    inner.sort_unstable();
    let patches = sides.patches(out);
    let of_patches = || patches.iter().flat_map(|(_, list)| list);
    let n_faces = inner.len() + of_patches().count() + 2 * n_cells;

    write(&folder, "faces", "faceList", |w| {
        writeln!(w, "{n_faces}\n(")?;
        for s in inner.iter().map(|f| &f.2).chain(of_patches()) {
            let [a, b] = s.vertices.map(|v| v as usize);
            writeln!(w, "4({a} {b} {} {})", b + n, a + n)?;
        }
        for q in &mesh.quads {
            let v = q.map(|v| v.index());
            writeln!(w, "4({} {} {} {})", v[3], v[2], v[1], v[0])?;
            writeln!(w, "4({} {} {} {})", v[0] + n, v[1] + n, v[2] + n, v[3] + n)?;
        }
        for t in &mesh.triangles {
            let v = t.map(|v| v.index());
            writeln!(w, "3({} {} {})", v[2], v[1], v[0])?;
            writeln!(w, "3({} {} {})", v[0] + n, v[1] + n, v[2] + n)?;
        }
        Ok(writeln!(w, ")")?)
    })?;
    write(&folder, "owner", "labelList", |w| {
        writeln!(w, "{n_faces}\n(")?;
        let owners = inner.iter().map(|f| f.0).chain(of_patches().map(|s| s.element));
        for c in owners.chain((0..n_cells).flat_map(|c| [c, c])) {
            writeln!(w, "{c}")?;
        }
        Ok(writeln!(w, ")")?)
    })?;
    write(&folder, "neighbour", "labelList", |w| {
        writeln!(w, "{}\n(", inner.len())?;
        inner.iter().try_for_each(|f| writeln!(w, "{}", f.1))?;
        Ok(writeln!(w, ")")?)
    })?;
    write(&folder, "boundary", "polyBoundaryMesh", |w| {
        writeln!(w, "{}\n(", patches.len() + 1)?;
        let mut start = inner.len();
        let front = ("frontAndBack".to_owned(), 2 * n_cells, "empty");
        for (name, count, kind) in
            patches.iter().map(|(n, list)| (plain_name(n), list.len(), "patch")).chain([front])
        {
            writeln!(w, "    {name}\n    {{\n        type {kind};\n        nFaces {count};")?;
            writeln!(w, "        startFace {start};\n    }}")?;
            start += count;
        }
        Ok(writeln!(w, ")")?)
    })?;
    write(&folder, "cellZones", "regIOobject", |w| {
        writeln!(w, "{}\n(", out.sets.quads.len())?;
        for (name, quads) in &out.sets.quads {
            writeln!(w, "{}\n{{\n    type cellZone;", plain_name(name))?;
            writeln!(w, "    cellLabels List<label> {}\n    (", quads.len())?;
            quads.iter().try_for_each(|q| writeln!(w, "{}", q.0))?;
            writeln!(w, "    );\n}}")?;
        }
        Ok(writeln!(w, ")")?)
    })?;
    Ok(fs::write(path, "")?)
}

fn write(
    folder: &Path,
    object: &str,
    class: &str,
    body: impl FnOnce(&mut dyn Write) -> Result<(), IoError>,
) -> Result<(), IoError> {
    let mut w = BufWriter::new(fs::File::create(folder.join(object))?);
    writeln!(w, "FoamFile\n{{\n    version 2.0;\n    format ascii;\n    class {class};")?;
    writeln!(w, "    location \"constant/polyMesh\";\n    object {object};\n}}\n")?;
    body(&mut w)?;
    Ok(w.flush()?)
}
