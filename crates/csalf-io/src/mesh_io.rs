//! One door to all mesh formats.

use crate::{IoError, MeshFormat, MeshView, Place, vtu};
use std::io::Write;

/// Writes a mesh in a format. The sink should be buffered.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] for what the format cannot hold.
pub fn write_mesh(format: MeshFormat, out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    match format {
        MeshFormat::Vtu => vtu::write(out, w),
        _ => Err(IoError::unsupported(format.name(), Place::Whole, "not built yet")),
    }
}
