//! The engine of csalf studio as a WebAssembly module with plain exports: no glue but thirty lines of script
//! (`crates/csalf-studio/page/worker.js`), one thread, no import that matters.
//!
//! ```text
//!   csalf_input(n) ─▶ address; write n bytes there
//!   csalf_mesh(), csalf_open(name), csalf_export(name), csalf_mesh_job() ─▶ 0: done, 1: refused
//!   csalf_output(), csalf_output_len() ─▶ the answer, or why it was refused (UTF-8)
//! ```
//!
//! | function | input | output |
//! |---|---|---|
//! | `csalf_open(k)` | file name of k bytes, then the file | JSON: documents and notes |
//! | `csalf_mesh()` | document | reply of [`csalf_studio::reply`] |
//! | `csalf_mesh_job()` | job in the JSON format of csalf | the same |
//! | `csalf_export(k)` | format name of k bytes, then the document | length of the name (u32), name, file |
//!
//! There is no unsafe block: the script reads and writes the memory of the module, Rust only tells where.

#![allow(unsafe_code, reason = "`no_mangle` counts as unsafe: the names begin with csalf_ and are used once")]

use csalf_studio::engine::{self, Refused};
use std::sync::{Mutex, MutexGuard, PoisonError};

static INPUT: Mutex<Vec<u8>> = Mutex::new(Vec::new());
static OUTPUT: Mutex<Vec<u8>> = Mutex::new(Vec::new());

fn lock(buffer: &'static Mutex<Vec<u8>>) -> MutexGuard<'static, Vec<u8>> {
    buffer.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes room for an input of `n` bytes and tells where it is. Valid until the next call of any function.
#[unsafe(no_mangle)]
pub extern "C" fn csalf_input(n: usize) -> *mut u8 {
    let mut input = lock(&INPUT);
    input.clear();
    input.resize(n, 0);
    input.as_mut_ptr()
}

/// Where the last answer is. Valid until the next call of any function.
#[unsafe(no_mangle)]
pub extern "C" fn csalf_output() -> *const u8 {
    lock(&OUTPUT).as_ptr()
}

/// Length of the last answer in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn csalf_output_len() -> usize {
    lock(&OUTPUT).len()
}

/// Opens the file in the input, whose name is its first `k` bytes.
#[unsafe(no_mangle)]
pub extern "C" fn csalf_open(k: usize) -> u32 {
    answer(|input| {
        let (name, file) = cut(input, k);
        engine::open(&name, file)
    })
}

/// Meshes the document in the input.
#[unsafe(no_mangle)]
pub extern "C" fn csalf_mesh() -> u32 {
    answer(|input| engine::mesh(input, &()))
}

/// Meshes the job in the input.
#[unsafe(no_mangle)]
pub extern "C" fn csalf_mesh_job() -> u32 {
    answer(|job| engine::mesh(&[br#"{"job":"#, job, b"}"].concat(), &()))
}

/// Writes the mesh of the document in the input; the first `k` bytes name the format.
#[unsafe(no_mangle)]
pub extern "C" fn csalf_export(k: usize) -> u32 {
    answer(|input| {
        let (format, document) = cut(input, k);
        let made = engine::export(document, &format, &())?;
        let n = (made.name.len() as u32).to_le_bytes();
        Ok([n.as_slice(), made.name.as_bytes(), &made.bytes].concat())
    })
}

/// The first `k` bytes as a text, and the rest.
fn cut(input: &[u8], k: usize) -> (String, &[u8]) {
    let (text, rest) = input.split_at(k.min(input.len()));
    (String::from_utf8_lossy(text).into_owned(), rest)
}

fn answer(work: impl FnOnce(&[u8]) -> Result<Vec<u8>, Refused>) -> u32 {
    let result = work(&lock(&INPUT));
    let status = u32::from(result.is_err());
    *lock(&OUTPUT) = result.unwrap_or_else(|why| why.to_string().into_bytes());
    status
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_job_asks_for_is_answered() {
        let job = br#"{"loops": [{"kind": "outer", "nodes": [[0,0],[1,0],[1,1],[0,1]]}]}"#;
        csalf_input(job.len());
        lock(&INPUT).copy_from_slice(job);
        assert_eq!(csalf_mesh_job(), 0);
        let reply = lock(&OUTPUT).clone();
        assert_eq!(csalf_output_len(), reply.len());
        assert!(String::from_utf8_lossy(&reply).contains("\"n_quads\":1,"));

        let wanted = [b"vtu{\"job\":", job.as_slice(), b"}"].concat();
        csalf_input(wanted.len());
        lock(&INPUT).copy_from_slice(&wanted);
        assert_eq!(csalf_export(3), 0);
        assert_eq!(lock(&OUTPUT)[..12], *b"\x08\0\0\0mesh.vtu");

        csalf_input(0);
        assert_eq!(csalf_mesh(), 1);
        assert_ne!(csalf_output_len(), 0);
        // A length that is no length of anything.
        assert_eq!(csalf_open(99), 1);
    }
}
