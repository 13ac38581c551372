//! What `-v` shows: the events and spans of the libraries, on standard error.

use tracing::Level;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::format::FmtSpan;
use tracing_subscriber::prelude::*;

/// Installs the subscriber of this process: `verbosity` 0 and less shows nothing, 1 the stages of the pipeline,
/// 2 one line per patch, 3 and more everything. With `progress` the stages also go to the progress display.
pub fn install(verbosity: i32, progress: Option<crate::progress::Stages>) {
    let level = match verbosity {
        ..=0 => LevelFilter::OFF,
        1 => Level::INFO.into(),
        2 => Level::DEBUG.into(),
        3.. => Level::TRACE.into(),
    };
    let lines = (verbosity > 0).then(|| {
        tracing_subscriber::fmt::layer()
            .with_writer(std::io::stderr)
            .with_ansi(crate::say::colored())
            .with_span_events(FmtSpan::CLOSE)
            .with_target(false)
            .without_time()
            .with_filter(level)
    });
    // The end of each face of a model is told below the level of stages.
    let shown = Targets::new().with_default(Level::INFO).with_target("csalf::face", Level::DEBUG);
    let stages = progress.map(|p| p.with_filter(shown));
    if lines.is_none() && stages.is_none() {
        return;
    }
    // Only the first subscriber of a process counts; the program installs one.
    let _ = tracing_subscriber::registry().with(lines).with(stages).try_init();
}
