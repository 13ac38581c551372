//! Reading and writing by name: `-` is standard input and output, the format follows from the extension or from
//! what the caller says.

use crate::exit::Failure;
use csalf_io::{IoError, JobFormat, JobInput, MeshData, MeshFormat, MeshView, WriteOptions};
use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// How a path is shown to people.
pub fn shown(path: &Path) -> String {
    if is_standard(path) { "standard input".into() } else { path.display().to_string() }
}

/// True of `-`.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// All bytes of a file, or of standard input.
///
/// # Errors
/// [`Failure::Files`].
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    if is_standard(path) {
        let mut bytes = Vec::new();
        std::io::stdin()
            .read_to_end(&mut bytes)
            .map_err(|e| Failure::Files(format!("cannot read standard input: {e}")))?;
        return Ok(bytes);
    }
    std::fs::read(path)
        .map_err(|source| Failure::of_file(&shown(path), &IoError::Open { path: path.to_owned(), source }))
}

/// The format called `name`, or else the one that the extension of `path` means.
///
/// # Errors
/// [`Failure::Usage`] if neither is known.
pub fn mesh_format(path: &Path, name: Option<&str>) -> Result<MeshFormat, Failure> {
    match name {
        Some(name) => MeshFormat::from_name(name).ok_or_else(|| {
            let known: Vec<_> = MeshFormat::ALL.iter().map(|f| f.name()).collect();
            Failure::Usage(format!("unknown mesh format '{name}'; known are {}", known.join(", ")))
        }),
        None if is_standard(path) => Ok(MeshFormat::Vtu),
        None => MeshFormat::from_path(path).map_err(|e| Failure::of_file(&shown(path), &e)),
    }
}

/// The format called `name`, or else the one that the extension of `path` means; standard input is JSON.
///
/// # Errors
/// [`Failure::Usage`] if neither is known.
pub fn job_format(path: &Path, name: Option<&str>) -> Result<JobFormat, Failure> {
    match name {
        Some(name) => JobFormat::from_name(name).ok_or_else(|| {
            let known: Vec<_> = JobFormat::ALL.iter().map(|f| f.name()).collect();
            Failure::Usage(format!("unknown input format '{name}'; known are {}", known.join(", ")))
        }),
        None if is_standard(path) => Ok(JobFormat::Json),
        None => JobFormat::from_path(path).map_err(|e| Failure::of_file(&shown(path), &e)),
    }
}

/// Reads meshing jobs; one without a name is named after its file.
///
/// # Errors
/// [`Failure::Files`], or [`Failure::Invalid`] if the content is not what the format asks for.
pub fn read_jobs(path: &Path, format: JobFormat) -> Result<JobInput, Failure> {
    let bytes = read(path)?;
    csalf_io::read_job_bytes(format, &bytes).map_err(|e| Failure::of_file(&shown(path), &e))
}

/// The name of a file without folders and extension; `job` for standard input.
pub fn stem(path: &Path) -> String {
    match path.file_stem() {
        Some(s) if !is_standard(path) => s.to_string_lossy().into_owned(),
        _ => "job".into(),
    }
}

/// Reads a mesh.
///
/// # Errors
/// As [`read_jobs`].
pub fn read_mesh(path: &Path, format: MeshFormat) -> Result<MeshData, Failure> {
    let bytes = read(path)?;
    csalf_io::read_mesh_bytes(format, &bytes).map_err(|e| Failure::of_file(&shown(path), &e))
}

/// A mesh file to be written: name and format, settled before any work is done.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Where to.
    pub path: PathBuf,
    /// In which format.
    pub format: MeshFormat,
}

/// Writes a mesh. A file that could not be written in full is removed again.
///
/// # Errors
/// [`Failure::Files`].
pub fn write_mesh(view: &MeshView<'_>, how: &WriteOptions<'_>, out: &Output) -> Result<(), Failure> {
    if out.format == MeshFormat::Foam && how.mid.is_none() && !is_standard(&out.path) {
        let name = out.path.display().to_string();
        return csalf_io::foam::write_case(view, &out.path).map_err(|e| Failure::of_file(&name, &e));
    }
    write(&out.path, |sink| csalf_io::write_mesh_with(out.format, view, how, sink))
}

/// Writes what `fill` gives to a file or to standard output.
///
/// # Errors
/// [`Failure::Files`].
pub fn write(path: &Path, fill: impl FnOnce(&mut dyn Write) -> Result<(), IoError>) -> Result<(), Failure> {
    if is_standard(path) {
        let mut sink = BufWriter::new(std::io::stdout().lock());
        return match fill(&mut sink).and_then(|()| Ok(sink.flush()?)) {
            Err(IoError::Write(e)) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
            Err(e) => Err(Failure::of_file("standard output", &e)),
            Ok(()) => Ok(()),
        };
    }
    let name = path.display().to_string();
    let file = File::create(path).map_err(|e| Failure::Files(format!("cannot write {name}: {e}")))?;
    let regular = file.metadata().is_ok_and(|m| m.is_file());
    let mut sink = BufWriter::new(file);
    fill(&mut sink).and_then(|()| Ok(sink.flush()?)).map_err(|e| {
        if regular {
            // The error that matters is the one at hand; a rest that stays is no worse than before.
            let _ = std::fs::remove_file(path);
        }
        Failure::of_file(&name, &e)
    })
}
