//! The page and the engine on 127.0.0.1, for one person on one machine.
//!
//! Who may ask: whoever knows the random token that every path begins with, under a host name that means this
//! machine
//! (another one would be a rebound DNS name), from this page or from no page at all (`Origin`). Everybody
//! else gets 403
//! and learns nothing. The server reads no file and writes none; the program gives it the one to begin with.

use crate::engine::{self, Refused};
use crate::page;
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{DefaultBodyLimit, Path, Query, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use csalf_core::Watch;
use serde::Deserialize;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Largest request, bytes. A document of a million boundary nodes has 40 MB.
const MAX_BODY: usize = 128 << 20;

/// Bytes of randomness in a token.
const TOKEN_BYTES: usize = 16;

/// A studio, bound to its port and not yet serving.
#[derive(Debug)]
pub struct Studio {
    listener: TcpListener,
    shared: Arc<Shared>,
}

/// Why there is no studio.
#[derive(Debug, thiserror::Error)]
pub enum Unbound {
    /// The file to begin with cannot be read.
    #[error(transparent)]
    File(#[from] Refused),
    /// The port is taken, or the system gives no random numbers.
    #[error(transparent)]
    Port(#[from] io::Error),
}

#[derive(Debug)]
struct Shared {
    token: String,
    port: u16,
    /// What the page shows first: the answer of [`engine::open`].
    start: Vec<u8>,
}

impl Studio {
    /// Binds 127.0.0.1; port 0: any that is free. `file` is the name and content of what is shown first.
    ///
    /// # Errors
    /// [`Unbound`].
    pub fn bind(port: u16, file: Option<(&str, &[u8])>) -> Result<Self, Unbound> {
        let start = match file {
            Some((name, bytes)) => engine::open(name, bytes)?,
            None => br#"{"documents":[],"notes":[]}"#.to_vec(),
        };
        let mut random = [0; TOKEN_BYTES];
        getrandom::fill(&mut random).map_err(io::Error::other)?;
        let token = random.iter().map(|b| format!("{b:02x}")).collect();
        let listener = TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))?;
        listener.set_nonblocking(true)?;
        let port = listener.local_addr()?.port();
        Ok(Self { listener, shared: Arc::new(Shared { token, port, start }) })
    }

    /// Where the page is; whoever knows it may use the studio.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.shared.port, self.shared.token)
    }

    /// Serves until the process ends.
    ///
    /// # Errors
    /// The runtime cannot be started, or the listener fails.
    pub fn serve(self) -> io::Result<()> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().build()?;
        runtime.block_on(async move {
            let listener = tokio::net::TcpListener::from_std(self.listener)?;
            axum::serve(listener, router(self.shared)).await
        })
    }
}

fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/{token}/", get(|| async { file("") }))
        .route("/{token}/{file}", get(|Path((_, name)): Path<(String, String)>| async move { file(&name) }))
        .route("/{token}/api/start", get(start))
        .route("/{token}/api/open", post(open))
        .route("/{token}/api/mesh", post(mesh))
        .route("/{token}/api/export", post(export))
        .layer(DefaultBodyLimit::max(MAX_BODY))
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), guard))
        .with_state(shared)
}

/// Lets through who may ask, and tells the browser what the page may do.
async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let mut response = if allowed(&shared, request.uri().path(), request.headers()) {
        next.run(request).await
    } else {
        (StatusCode::FORBIDDEN, "refused: open the address that csalf studio printed\n").into_response()
    };
    let rules: [(HeaderName, &'static str); 5] = [
        (header::CONTENT_SECURITY_POLICY, page::POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ];
    for (name, value) in rules {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

fn allowed(shared: &Shared, path: &str, headers: &HeaderMap) -> bool {
    let names = [format!("127.0.0.1:{}", shared.port), format!("localhost:{}", shared.port)];
    let host = headers.get(header::HOST).and_then(|h| h.to_str().ok()).unwrap_or_default();
    let from_here = |origin: &HeaderValue| {
        origin.to_str().is_ok_and(|o| names.iter().any(|n| o.strip_prefix("http://") == Some(n)))
    };
    let token = path.trim_start_matches('/').split('/').next().unwrap_or_default();
    names.iter().any(|n| n == host)
        && headers.get_all(header::ORIGIN).iter().all(from_here)
        && same(token.as_bytes(), shared.token.as_bytes())
}

/// Equality in a time that does not tell how much was right.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |acc, (x, y)| acc | (x ^ y)) == 0
}

fn file(name: &str) -> Response {
    match page::asset(name) {
        Some(a) => ([(header::CONTENT_TYPE, a.kind)], a.text).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such file\n").into_response(),
    }
}

const JSON: [(HeaderName, &str); 1] = [(header::CONTENT_TYPE, "application/json")];

async fn start(State(shared): State<Arc<Shared>>) -> Response {
    (JSON, shared.start.clone()).into_response()
}

#[derive(Deserialize)]
struct Named {
    name: String,
}

async fn open(Query(Named { name }): Query<Named>, body: Bytes) -> Response {
    answer(move |_| engine::open(&name, &body).map(|json| (JSON, json).into_response())).await
}

async fn mesh(body: Bytes) -> Response {
    const KIND: [(HeaderName, &str); 1] = [(header::CONTENT_TYPE, "application/octet-stream")];
    answer(move |watch| engine::mesh(&body, watch).map(|reply| (KIND, reply).into_response())).await
}

#[derive(Deserialize)]
struct Wanted {
    format: String,
}

async fn export(Query(Wanted { format }): Query<Wanted>, body: Bytes) -> Response {
    answer(move |watch| {
        let made = engine::export(&body, &format, watch)?;
        // The name has letters, digits, `-`, `_` and `.` alone.
        let disposition = format!("attachment; filename=\"{}\"", made.name);
        let mut response = Body::from(made.bytes).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"));
        if let Ok(value) = HeaderValue::from_str(&disposition) {
            headers.insert(header::CONTENT_DISPOSITION, value);
        }
        Ok(response)
    })
    .await
}

/// Ends a run when nobody waits for its answer any more: the page drops a request as soon as it has a newer
/// one.
struct Nobody(Arc<AtomicBool>);

impl Drop for Nobody {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

struct Flag(Arc<AtomicBool>);

impl Watch for Flag {
    fn cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Runs `work` beside the server; a refusal becomes 422 with the reason as text.
async fn answer(work: impl FnOnce(&dyn Watch) -> Result<Response, Refused> + Send + 'static) -> Response {
    let gone = Arc::new(AtomicBool::new(false));
    let _nobody = Nobody(Arc::clone(&gone));
    match tokio::task::spawn_blocking(move || work(&Flag(gone))).await {
        Ok(Ok(response)) => response,
        Ok(Err(refused)) => (StatusCode::UNPROCESSABLE_ENTITY, refused.to_string()).into_response(),
        Err(_) => {
            (StatusCode::INTERNAL_SERVER_ERROR, "the engine broke down: please report it").into_response()
        }
    }
}
