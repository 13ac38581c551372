//! VTKHDF (`.vtkhdf`), written: an unstructured grid in HDF5, as ParaView and VTK read it; with mid-side nodes quadratic
//! cells. Sets are arrays of `FieldData`, as in `.vtu`: `nset:NAME`, `eset:NAME` (pairs), `qset:NAME`. A `/` in a name,
//! which HDF5 cannot hold, becomes `|`. Source: *VTKHDF File Format*, Kitware, version 2.0.
//!
//! ```text
//!   /VTKHDF            Version, Type
//!     NumberOfPoints, NumberOfCells, NumberOfConnectivityIds     one number each: a file of one part
//!     Points (n, 3)    Connectivity, Offsets, Types
//!     CellData/NAME    FieldData/nset:NAME, ...
//! ```

use crate::vtu::{VTK_BIQUADRATIC_QUAD, VTK_QUAD, VTK_QUADRATIC_QUAD, VTK_QUADRATIC_TRIANGLE, VTK_TRIANGLE};
use crate::{IoError, MeshView, MidNodes, Place};
use hdf5_pure::{AttrValue, FileBuilder, GroupBuilder};
use std::io::Write;

const FORMAT: &str = "VTKHDF";

/// Writes a mesh. Cost O(n) time, and memory for one more copy of the mesh.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] if a cell array is not as long as there are elements.
pub fn write(out: &MeshView<'_>, mid: Option<&MidNodes>, w: &mut dyn Write) -> Result<(), IoError> {
    let mesh = out.mesh;
    let (nq, nt) = (mesh.quads.len(), mesh.triangles.len());
    let points: Vec<f64> = out.all_xyz(mid).flatten().collect();
    let (quad_kind, triangle_kind) = match mid {
        None => (VTK_QUAD, VTK_TRIANGLE),
        Some(m) if m.has_centres() => (VTK_BIQUADRATIC_QUAD, VTK_QUADRATIC_TRIANGLE),
        Some(_) => (VTK_QUADRATIC_QUAD, VTK_QUADRATIC_TRIANGLE),
    };
    let mut nodes: Vec<i64> = Vec::new();
    let mut ends: Vec<i64> = vec![0];
    for (i, q) in mesh.quads.iter().enumerate() {
        match mid {
            Some(m) => nodes.extend(m.quad(i, q).iter().map(|v| i64::from(v.0))),
            None => nodes.extend(q.iter().map(|v| i64::from(v.0))),
        }
        ends.push(nodes.len() as i64);
    }
    for t in &mesh.triangles {
        match mid {
            Some(m) => nodes.extend(m.triangle(t).iter().map(|v| i64::from(v.0))),
            None => nodes.extend(t.iter().map(|v| i64::from(v.0))),
        }
        ends.push(nodes.len() as i64);
    }
    let types: Vec<u8> =
        std::iter::repeat_n(quad_kind, nq).chain(std::iter::repeat_n(triangle_kind, nt)).collect();

    let mut file = FileBuilder::new();
    let mut root = file.create_group("VTKHDF");
    root.set_attr("Version", AttrValue::I64Array(vec![2, 0]));
    root.set_attr("Type", AttrValue::AsciiString("UnstructuredGrid".into()));
    let n_points = points.len() / 3;
    integers(&mut root, "NumberOfPoints", &[n_points as i64], 1);
    integers(&mut root, "NumberOfCells", &[types.len() as i64], 1);
    integers(&mut root, "NumberOfConnectivityIds", &[nodes.len() as i64], 1);
    root.create_dataset("Points").with_f64_data(&points).with_shape(&[n_points as u64, 3]);
    integers(&mut root, "Connectivity", &nodes, 1);
    integers(&mut root, "Offsets", &ends, 1);
    root.create_dataset("Types").with_u8_data(&types).with_shape(&[types.len() as u64]);
    let mut cells = root.create_group("CellData");
    for d in out.cell_data {
        if d.values.len() != types.len() {
            let message = format!("{} has {} values for {} elements", d.name, d.values.len(), types.len());
            return Err(IoError::unsupported(FORMAT, Place::Whole, message));
        }
        cells.create_dataset(&key(&d.name)).with_f64_data(&d.values).with_shape(&[types.len() as u64]);
    }
    root.add_group(cells.finish());
    let mut fields = root.create_group("FieldData");
    let ids = |v: &[csalf_geom::VertexId]| v.iter().map(|v| i64::from(v.0)).collect::<Vec<_>>();
    for (name, v) in out.sets.nodes.iter().filter(|s| !s.1.is_empty()) {
        integers(&mut fields, &key(&format!("nset:{name}")), &ids(v), 1);
    }
    for (name, e) in out.sets.edges.iter().filter(|s| !s.1.is_empty()) {
        integers(&mut fields, &key(&format!("eset:{name}")), &ids(e.as_flattened()), 2);
    }
    for (name, q) in out.sets.quads.iter().filter(|s| !s.1.is_empty()) {
        let q: Vec<i64> = q.iter().map(|q| i64::from(q.0)).collect();
        integers(&mut fields, &key(&format!("qset:{name}")), &q, 1);
    }
    root.add_group(fields.finish());
    file.add_group(root.finish());
    file.finish_to(w).map_err(|e| match e {
        hdf5_pure::Error::Io(e) => IoError::Write(e),
        other => IoError::unsupported(FORMAT, Place::Whole, other.to_string()),
    })
}

/// A dataset of whole numbers, in rows of `columns`.
fn integers(group: &mut GroupBuilder, name: &str, values: &[i64], columns: usize) {
    let rows = (values.len() / columns) as u64;
    let shape: &[u64] = if columns == 1 { &[rows] } else { &[rows, columns as u64] };
    group.create_dataset(name).with_i64_data(values).with_shape(shape);
}

/// A name as HDF5 takes it.
fn key(name: &str) -> String {
    crate::text::one_line(name).replace('/', "|")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CellData;
    use csalf_geom::{Point2, QuadId, VertexId};
    use csalf_mesh::{NamedSets, QuadMesh};
    use hdf5_pure::File;

    #[test]
    fn the_file_holds_mesh_sets_and_values() {
        let v = VertexId::new;
        let points = [(0., 0.), (1., 0.), (2., 0.5), (1., 1.), (0., 1.)].map(Point2::from).to_vec();
        let mesh =
            QuadMesh { points, quads: vec![[v(0), v(1), v(3), v(4)]], triangles: vec![[v(1), v(2), v(3)]] };
        let sets = NamedSets {
            nodes: vec![("a/b".into(), vec![v(4)]), ("empty".into(), vec![])],
            edges: vec![("low".into(), vec![[v(0), v(1)], [v(1), v(2)]])],
            quads: vec![("layer".into(), vec![QuadId(0)])],
        };
        let values = vec![CellData { name: "sj".into(), values: vec![1.0, 0.5] }];
        let heights = [0.25; 5];
        let view = MeshView { mesh: &mesh, heights: &heights, sets: &sets, cell_data: &values, title: "t" };
        let bytes = |view: &MeshView<'_>| {
            let mut b = Vec::new();
            write(view, None, &mut b).unwrap();
            b
        };
        let all = bytes(&view);
        assert_eq!(all, bytes(&view), "the same bytes on every run");
        let file = File::from_bytes(all).unwrap();
        let of = |name: &str| file.dataset(name).unwrap();
        assert_eq!(of("VTKHDF/Points").shape().unwrap(), [5, 3]);
        assert_eq!(of("VTKHDF/Points").read_f64().unwrap()[6..9], [2.0, 0.5, 0.25]);
        assert_eq!(of("VTKHDF/Offsets").read_i64().unwrap(), [0, 4, 7]);
        assert_eq!(of("VTKHDF/FieldData/eset:low").shape().unwrap(), [2, 2]);
        assert_eq!(of("VTKHDF/FieldData/nset:a|b").read_i64().unwrap(), [4]);
        assert_eq!(of("VTKHDF/CellData/sj").read_f64().unwrap(), [1.0, 0.5]);
        let short = vec![CellData { name: "sj".into(), values: vec![1.0] }];
        let wrong = MeshView { cell_data: &short, ..view };
        assert!(matches!(write(&wrong, None, &mut Vec::new()), Err(IoError::Unsupported { .. })));
    }
}
