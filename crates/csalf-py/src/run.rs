//! Meshing on a thread of its own.
//!
//! ```text
//!   Python's thread   ──work─▶  worker: csalf_core::mesh_watched, or the faces of a model
//!     waits without the GIL;      │
//!     every 50 ms: signals?  ◀────┤ stage begins
//!     calls the callback     ◀────┘ mesh or error
//! ```
//!
//! On Ctrl-C, or if the callback raises, the exception goes up at once. The worker is told, and ends by itself at the
//! next stage or contour; its result is dropped.

use crate::errors;
use crate::job::Job;
use crate::mesh::Mesh;
use csalf_core::{MeshError, Method, Options, Preset, Watch};
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Time between two looks for signals. Longer: Ctrl-C feels slow; shorter: wakes for nothing.
const LOOK: Duration = Duration::from_millis(50);

/// News of the worker.
enum News<T> {
    Stage(&'static str),
    Done(Box<T>),
}

/// Sends stages, hears of the end.
struct Line<T> {
    news: Mutex<mpsc::Sender<News<T>>>,
    cancelled: Arc<AtomicBool>,
}

impl<T: Send> Watch for Line<T> {
    fn stage(&self, name: &'static str) {
        if let Ok(news) = self.news.lock() {
            // Nobody listens any more: the flag says so, too.
            let _ = news.send(News::Stage(name));
        }
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Sets the flag when it is dropped, on whichever way.
struct CancelOnDrop(Arc<AtomicBool>);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Meshes a job. `watch` is called with the name of each stage as it begins; if it returns `False`, the run ends with
/// `Cancelled`.
#[pyfunction]
#[pyo3(signature = (job, *, method, preset, threads, gradation, allow_triangles, repair_parity, watch))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn mesh(
    py: Python<'_>,
    job: &Job,
    method: &str,
    preset: &str,
    threads: usize,
    gradation: Option<f64>,
    allow_triangles: bool,
    repair_parity: bool,
    watch: Option<Bound<'_, PyAny>>,
) -> PyResult<Mesh> {
    let (method, preset) = means(method, preset)?;
    let options = Options { method, preset, threads, gradation, allow_triangles, repair_parity };
    let geometry = job.geometry.clone();
    let job = Arc::new(job.job.clone());
    let (worker_job, worker_options) = (Arc::clone(&job), options.clone());
    let work = move |line: &dyn Watch| csalf_core::mesh_watched(&worker_job, &worker_options, line);
    let meshed = follow(py, watch.as_ref(), work)?.map_err(|e| errors::of_meshing(py, &e))?;
    Ok(Mesh::new(meshed, Arc::unwrap_or_clone(job), options, geometry))
}

/// Method and preset by their names.
pub(crate) fn means(method: &str, preset: &str) -> PyResult<(Method, Preset)> {
    let method = match method {
        "csalf" => Method::Csalf,
        "paper" => Method::Paper,
        "tqm" => Method::Tqm,
        other => return Err(errors::value(format!("method '{other}': known are csalf, paper, tqm"))),
    };
    let preset = match preset {
        "quality" => Preset::Quality,
        "fast" => Preset::Fast,
        other => return Err(errors::value(format!("preset '{other}': known are quality, fast"))),
    };
    Ok((method, preset))
}

/// Runs `work` on a thread of its own, so that signals and stages reach Python.
pub(crate) fn follow<T: Send + 'static>(
    py: Python<'_>,
    watch: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&dyn Watch) -> T + Send + 'static,
) -> PyResult<T> {
    let cancelled = Arc::new(AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel();
    let line = Line { news: Mutex::new(sender.clone()), cancelled: Arc::clone(&cancelled) };
    let _cancel = CancelOnDrop(cancelled);
    std::thread::Builder::new().name("csalf".into()).spawn(move || {
        let result = work(&line);
        // The caller may have left.
        let _ = sender.send(News::Done(Box::new(result)));
    })?;
    let receiver = Mutex::new(receiver);
    loop {
        let news = py.detach(|| match receiver.lock() {
            Ok(r) => r.recv_timeout(LOOK),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        });
        py.check_signals()?;
        match news {
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                let lost = MeshError::Internal { stage: "thread", detail: "the worker vanished".into() };
                return Err(errors::of_meshing(py, &lost));
            }
            Ok(News::Stage(name)) => {
                if let Some(watch) = watch
                    && matches!(watch.call1((name,))?.extract::<bool>(), Ok(false))
                {
                    return Err(errors::of_meshing(py, &MeshError::Cancelled));
                }
            }
            Ok(News::Done(result)) => return Ok(*result),
        }
    }
}
