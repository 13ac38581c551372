//! One door to all mesh formats.

use crate::{
    IoError, MeshData, MeshFormat, MeshView, MidNodes, Place, bdf, exodus, inp, ism, msh, obj, picture, su2,
    unv, vtkhdf, vtu,
};
use std::io::Write;
use std::path::Path;

/// How a mesh is written, besides its format.
#[derive(Clone, Copy, Debug, Default)]
pub struct WriteOptions<'a> {
    /// Mid-side nodes: quadratic elements.
    pub mid: Option<&'a MidNodes>,
    /// Which elements `.inp` gets.
    pub element: inp::InpElement,
}

/// Writes a mesh in a format. The sink should be buffered.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] for what the format cannot hold.
pub fn write_mesh(format: MeshFormat, out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    write_mesh_with(format, out, &WriteOptions::default(), w)
}

/// Writes a mesh in a format, as `how` says. Pictures show straight sides.
///
/// # Errors
/// As [`write_mesh`]; [`IoError::Unsupported`] also for mid-side nodes in a format that has none.
pub fn write_mesh_with(
    format: MeshFormat,
    out: &MeshView<'_>,
    how: &WriteOptions<'_>,
    w: &mut dyn Write,
) -> Result<(), IoError> {
    let flat = [MeshFormat::Su2, MeshFormat::Foam, MeshFormat::Ism];
    if !out.heights.is_empty() && flat.contains(&format) {
        let message = "meshes in space are not written in this format";
        return Err(IoError::unsupported(format.name(), Place::Whole, message));
    }
    match format {
        MeshFormat::Vtu => vtu::write_as(out, vtu::VtuEncoding::default(), how.mid, w),
        MeshFormat::Msh41 => msh::write_41_with(out, how.mid, w),
        MeshFormat::Msh22 => msh::write_22_with(out, how.mid, w),
        MeshFormat::Inp => inp::write_with(out, how, w),
        MeshFormat::Bdf => bdf::write_with(out, how.mid, w),
        MeshFormat::Exodus => exodus::write(out, how.mid, w),
        MeshFormat::VtkHdf => vtkhdf::write(out, how.mid, w),
        MeshFormat::Ism => ism::write(out, how.mid, w),
        MeshFormat::Obj | MeshFormat::Unv | MeshFormat::Su2 if how.mid.is_some() => {
            Err(IoError::unsupported(format.name(), Place::Whole, "the format has no quadratic elements"))
        }
        MeshFormat::Obj => obj::write(out, w),
        MeshFormat::Unv => unv::write(out, w),
        MeshFormat::Su2 => su2::write(out, w),
        MeshFormat::Foam => {
            let message = "a case is a folder and cannot go into one stream: name a file";
            Err(IoError::unsupported(format.name(), Place::Whole, message))
        }
        MeshFormat::Svg => picture::write_svg(out, w),
        MeshFormat::Png => picture::write_png(out, w),
    }
}

/// Reads a mesh, plane or in space, from bytes of a known format (both versions of `.msh` are read as either).
///
/// # Errors
/// [`IoError::Syntax`] or [`IoError::Unsupported`].
pub fn read_mesh_bytes(format: MeshFormat, bytes: &[u8]) -> Result<MeshData, IoError> {
    match format {
        MeshFormat::Vtu => vtu::read(bytes),
        MeshFormat::Msh41 | MeshFormat::Msh22 => msh::read(bytes),
        MeshFormat::Inp => inp::read(bytes),
        MeshFormat::Bdf => bdf::read(bytes),
        MeshFormat::Obj => obj::read(bytes),
        MeshFormat::Exodus
        | MeshFormat::Unv
        | MeshFormat::Su2
        | MeshFormat::Foam
        | MeshFormat::VtkHdf
        | MeshFormat::Ism => {
            Err(IoError::unsupported(format.name(), Place::Whole, "this format is written, but not read"))
        }
        MeshFormat::Svg | MeshFormat::Png => {
            Err(IoError::unsupported(format.name(), Place::Whole, "meshes are not read from pictures"))
        }
    }
}

/// Reads a mesh from a file, in the format that its extension means.
///
/// # Errors
/// [`IoError::Open`], [`IoError::UnknownFormat`], and those of [`read_mesh_bytes`].
pub fn read_mesh(path: &Path) -> Result<MeshData, IoError> {
    let format = MeshFormat::from_path(path)?;
    let bytes = std::fs::read(path).map_err(|source| IoError::Open { path: path.to_owned(), source })?;
    read_mesh_bytes(format, &bytes)
}
