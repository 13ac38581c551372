//! csalf studio: a page on which a person draws or opens outlines, sets layers and sizes, and sees the mesh
//! at once.
//!
//! ```text
//!   page (page/)  ──document──▶  engine: open, mesh, export  ──▶ csalf-io, csalf-core
//!                 ◀──reply────    behind a local server (feature `server`), or as WebAssembly in a worker
//! ```
//!
//! The page holds all state, the engine none: every request carries the whole [`Document`], so undo is a
//! matter of the
//! page alone, and a lost answer loses nothing.
//!
//! | module | what |
//! |---|---|
//! | [`document`] | what is drawn and wanted: a job whose loops may be curves instead of nodes |
//! | [`engine`] | the three requests |
//! | [`reply`] | the bytes of a finished mesh, as the page draws them |
//! | [`page`] | the files of the page |
//! | `server` | the page and the engine on 127.0.0.1, behind a random token |

pub mod curve_file;
pub mod document;
pub mod engine;
pub mod page;
pub mod reply;
#[cfg(feature = "server")]
pub mod server;

pub use document::Document;
