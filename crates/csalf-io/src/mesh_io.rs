//! One door to all mesh formats.

use crate::{IoError, MeshData, MeshFormat, MeshView, Place, bdf, inp, msh, obj, picture, vtu};
use std::io::Write;
use std::path::Path;

/// Writes a mesh in a format. The sink should be buffered.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] for what the format cannot hold.
pub fn write_mesh(format: MeshFormat, out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    match format {
        MeshFormat::Vtu => vtu::write(out, w),
        MeshFormat::Msh41 => msh::write_41(out, w),
        MeshFormat::Msh22 => msh::write_22(out, w),
        MeshFormat::Inp => inp::write(out, w),
        MeshFormat::Bdf => bdf::write(out, w),
        MeshFormat::Obj => obj::write(out, w),
        MeshFormat::Svg => picture::write_svg(out, w),
        MeshFormat::Png => picture::write_png(out, w),
    }
}

/// Reads a mesh from bytes of a known format (both versions of `.msh` are read as either).
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
