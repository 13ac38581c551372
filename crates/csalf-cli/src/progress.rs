//! A line that tells that something is going on: only on a terminal, only after a second.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc;
use std::time::Duration;
use tracing::Event;
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id};
use tracing_subscriber::layer::{Context, Layer};

/// Runs shorter than this show nothing.
const SILENT: Duration = Duration::from_secs(1);

/// Redraws of the line.
const TICK: Duration = Duration::from_millis(100);

/// True if a progress line makes sense: nobody asked for quiet or for logs, and a person is watching.
pub fn wanted(verbosity: i32) -> bool {
    verbosity == 0 && std::io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|v| v != "dumb")
}

/// The progress line of one run. It disappears when dropped.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    done: Option<mpsc::Sender<()>>,
    drawer: Option<std::thread::JoinHandle<()>>,
}

impl Progress {
    /// A line that appears on standard error after a second.
    pub fn start() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        bar.set_style(style("{spinner} {elapsed} {msg}"));
        let (done, wait) = mpsc::channel();
        let line = bar.clone();
        let drawer = std::thread::spawn(move || {
            if matches!(wait.recv_timeout(SILENT), Err(mpsc::RecvTimeoutError::Timeout)) {
                line.set_draw_target(ProgressDrawTarget::stderr());
                line.enable_steady_tick(TICK);
            }
        });
        Self { bar, done: Some(done), drawer: Some(drawer) }
    }

    /// What feeds the names of the stages to this line.
    pub fn stages(&self) -> Stages {
        Stages { bar: self.bar.clone() }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        drop(self.done.take());
        if let Some(drawer) = self.drawer.take() {
            let _ = drawer.join();
        }
        self.bar.finish_and_clear();
    }
}

/// The style of this template.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_spinner())
}

/// The span in which the faces of a model are meshed, and the target of the event at the end of each.
const FACES: (&str, &str) = ("csalf.faces", "csalf::face");

/// Shows each stage that the libraries enter (spans) or report as done (the field `stage` of events); of a model, a bar
/// that counts faces.
#[derive(Debug)]
pub struct Stages {
    bar: ProgressBar,
}

impl<S: tracing::Subscriber> Layer<S> for Stages {
    fn on_new_span(&self, span: &Attributes<'_>, _: &Id, _: Context<'_, S>) {
        if self.bar.length().is_some() {
            return;
        }
        self.bar.set_message(span.metadata().name());
        if span.metadata().name() == FACES.0 {
            span.record(&mut Faces(&self.bar));
        }
    }

    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        if event.metadata().target() == FACES.1 {
            self.bar.inc(1);
        } else if self.bar.length().is_none() {
            event.record(&mut StageName(&self.bar));
        }
    }
}

/// Takes the field `stage` out of an event.
struct StageName<'a>(&'a ProgressBar);

impl Visit for StageName<'_> {
    fn record_str(&mut self, field: &Field, value: &str) {
        if field.name() == "stage" {
            self.0.set_message(format!("{value} done"));
        }
    }

    fn record_debug(&mut self, _: &Field, _: &dyn std::fmt::Debug) {}
}

/// Takes the number of faces out of their span.
struct Faces<'a>(&'a ProgressBar);

impl Visit for Faces<'_> {
    fn record_u64(&mut self, field: &Field, value: u64) {
        if field.name() == "n_faces" {
            self.0.set_style(style("{spinner} {elapsed} [{bar:40}] {pos} of {len} faces"));
            self.0.set_length(value);
        }
    }

    fn record_debug(&mut self, _: &Field, _: &dyn std::fmt::Debug) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracing_subscriber::prelude::*;

    #[test]
    fn faces_are_counted() {
        let line = Progress::start();
        let subscriber = tracing_subscriber::registry().with(line.stages());
        tracing::subscriber::with_default(subscriber, || {
            let _span = tracing::info_span!("csalf.faces", n_faces = 3_usize).entered();
            tracing::debug!(target: "csalf::face", face = 0_usize);
            tracing::info_span!("fill").in_scope(|| ());
        });
        assert_eq!((line.bar.length(), line.bar.position()), (Some(3), 1));
    }

    #[test]
    fn stages_are_shown_and_the_line_ends() {
        let line = Progress::start();
        let subscriber = tracing_subscriber::registry().with(line.stages());
        tracing::subscriber::with_default(subscriber, || {
            let _span = tracing::info_span!("pave").entered();
            assert_eq!(line.bar.message(), "pave");
            tracing::info!(stage = "fill", seconds = 1.0, "done");
            assert_eq!(line.bar.message(), "fill done");
        });
        let bar = line.bar.clone();
        drop(line);
        assert!(bar.is_finished());
    }
}
