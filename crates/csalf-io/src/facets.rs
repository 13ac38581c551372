//! Triangles in space: `.stl`, `.obj`, `.ply`. Polygons are cut into fans; what is no triangle in the end is left out.

use crate::{IoError, Place};
use std::io::Cursor;
use std::path::Path;

/// Formats of facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FacetFormat {
    /// Stereolithography, text or binary.
    Stl,
    /// Wavefront.
    Obj,
    /// Stanford polygons, text or binary.
    Ply,
}

impl FacetFormat {
    /// The format of this name or extension.
    pub fn from_name(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "stl" => Some(Self::Stl),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            _ => None,
        }
    }

    /// The format that the extension of a path means.
    pub fn from_path(path: &Path) -> Option<Self> {
        Self::from_name(&path.extension()?.to_string_lossy())
    }

    /// Its name in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stl => "STL",
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
        }
    }
}

/// Triangles as a file has them: not welded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FacetData {
    /// Coordinates.
    pub points: Vec<[f64; 3]>,
    /// Three points per triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads facets.
///
/// # Errors
/// [`IoError::Syntax`]; [`IoError::Unsupported`] of more points than 32 bits can number.
pub fn read(format: FacetFormat, bytes: &[u8]) -> Result<FacetData, IoError> {
    let mut data = match format {
        FacetFormat::Stl => stl(bytes),
        FacetFormat::Obj => obj(bytes),
        FacetFormat::Ply => ply(bytes),
    }
    .map_err(|m| IoError::syntax(format.name(), Place::Whole, m))?;
    if u32::try_from(data.points.len()).is_err() {
        return Err(IoError::unsupported(format.name(), Place::Whole, "more points than 32 bits can number"));
    }
    let n = data.points.len() as u32;
    let finite = |v: u32| data.points[v as usize].iter().all(|x| x.is_finite());
    data.triangles.retain(|t| t.iter().all(|&v| v < n && finite(v)));
    Ok(data)
}

fn stl(bytes: &[u8]) -> Result<FacetData, String> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let mut data = FacetData::default();
    data.points.extend(mesh.vertices.iter().map(|v| [v[0], v[1], v[2]].map(f64::from)));
    data.triangles.extend(mesh.faces.iter().map(|f| f.vertices.map(|v| v as u32)));
    Ok(data)
}

fn obj(bytes: &[u8]) -> Result<FacetData, String> {
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    let no_materials = |_: &Path| -> tobj::MTLLoadResult { Ok(Default::default()) };
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials).map_err(|e| e.to_string())?;
    let mut data = FacetData::default();
    for m in &models {
        let first = data.points.len() as u32;
        data.points.extend(m.mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        data.triangles.extend(
            m.mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|v| first.saturating_add(v))),
        );
    }
    Ok(data)
}

fn ply(bytes: &[u8]) -> Result<FacetData, String> {
    use ply_rs_bw::parser::Parser;
    use ply_rs_bw::ply::{DefaultElement, Property};
    let parser = Parser::<DefaultElement>::new();
    let ply = parser.read_ply(&mut Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let number = |p: Option<&Property>| match p {
        Some(Property::Float(x)) => f64::from(*x),
        Some(Property::Double(x)) => *x,
        Some(Property::Int(x)) => f64::from(*x),
        _ => f64::NAN,
    };
    let list = |p: &Property| -> Option<Vec<u32>> {
        match p {
            Property::ListInt(v) => v.iter().map(|&i| u32::try_from(i).ok()).collect(),
            Property::ListUInt(v) => Some(v.clone()),
            Property::ListShort(v) => v.iter().map(|&i| u32::try_from(i).ok()).collect(),
            Property::ListUShort(v) => Some(v.iter().map(|&i| u32::from(i)).collect()),
            Property::ListUChar(v) => Some(v.iter().map(|&i| u32::from(i)).collect()),
            _ => None,
        }
    };
    let mut data = FacetData::default();
    for v in ply.payload.get("vertex").into_iter().flatten() {
        data.points.push(["x", "y", "z"].map(|k| number(v.get(k))));
    }
    for f in ply.payload.get("face").into_iter().flatten() {
        let corners = ["vertex_indices", "vertex_index"].iter().find_map(|k| f.get(*k).and_then(list));
        let Some(c) = corners else { continue };
        data.triangles.extend((2..c.len()).map(|k| [c[0], c[k - 1], c[k]]));
    }
    Ok(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_three_read_a_triangle() {
        let stl = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
        let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\nf 1 2 4 3\n";
        let ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        let d = read(FacetFormat::Stl, stl).expect("STL");
        assert_eq!((d.points.len(), d.triangles.len()), (3, 1));
        let d = read(FacetFormat::Obj, obj).expect("OBJ");
        assert_eq!((d.points.len(), d.triangles.len()), (4, 2));
        assert!(d.points.contains(&[1.0, 1.0, 0.5]));
        let d = read(FacetFormat::Ply, ply).expect("PLY");
        assert_eq!((d.points[1], d.triangles[0]), ([1.0, 0.0, 0.0], [0, 1, 2]));
    }

    #[test]
    fn broken_files_are_errors_or_empty() {
        for f in [FacetFormat::Stl, FacetFormat::Obj, FacetFormat::Ply] {
            for bytes in [&b""[..], b"solid", b"f 1 2 3\n", b"ply\nformat ascii 1.0\n", &[0xff; 100]] {
                if let Ok(d) = read(f, bytes) {
                    assert!(d.triangles.iter().flatten().all(|&v| (v as usize) < d.points.len()));
                }
            }
        }
    }
}
