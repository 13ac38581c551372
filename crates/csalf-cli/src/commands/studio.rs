//! `csalf studio`: serves the page of csalf-studio on this machine until it is stopped.

use crate::args::StudioArgs;
use crate::exit::Failure;
use crate::{files, say};
use csalf_io::IoError;
use csalf_studio::engine::Refused;
use csalf_studio::server::{Studio, Unbound};

/// Prints the address, opens the browser, and serves.
///
/// # Errors
/// A [`Failure`]: the file cannot be read, the port not be bound.
pub fn run(args: &StudioArgs, level: i32) -> Result<(), Failure> {
    let file = match &args.file {
        None => None,
        Some(path) => {
            let shown = files::shown(path);
            files::job_format(path, None)?;
            Some((
                shown,
                path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                files::read(path)?,
            ))
        }
    };
    let start = file.as_ref().map(|(_, name, bytes)| (name.as_str(), bytes.as_slice()));
    let shown = file.as_ref().map_or("csalf studio", |f| f.0.as_str());
    let studio = Studio::bind(args.port, start).map_err(|e| match e {
        Unbound::File(Refused::Io(e)) => Failure::of_file(shown, &e),
        Unbound::File(e) => Failure::Invalid { input: shown.to_owned(), defects: vec![e.to_string()] },
        Unbound::Port(e) => Failure::of_file(&format!("port {}", args.port), &IoError::Write(e)),
    })?;
    let url = studio.url();
    say::out(&url)?;
    if level >= 0 {
        say::err("csalf studio runs at this address, for this machine alone; Ctrl-C ends it");
    }
    if !args.no_open
        && let Err(e) = open::that_detached(&url)
    {
        say::warning(&format!("no browser could be opened ({e}): open the address yourself"));
    }
    studio.serve().map_err(|e| Failure::Files(format!("csalf studio stopped: {e}")))
}
