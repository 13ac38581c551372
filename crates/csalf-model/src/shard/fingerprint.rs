//! What tells one run from another: a hash of all that its mesh depends on.

use crate::Prepared;
use siphasher::sip128::{Hasher128, SipHasher24};
use std::fmt::Write as _;
use std::hash::Hasher;

/// Text into a hash, unstored.
struct Sink(SipHasher24);

impl std::fmt::Write for Sink {
    fn write_str(&mut self, s: &str) -> std::fmt::Result {
        self.0.write(s.as_bytes());
        Ok(())
    }
}

/// The fingerprint of a run in `count` parts: the version of the program, the model, the options, the nodes on edges. The
/// last differ where two machines differ in their elementary functions. Numbers are hashed by their shortest exact
/// decimals. Cost: linear in the size of the model.
pub(super) fn of(prepared: &Prepared<'_>, count: u32) -> u128 {
    let mut sink = Sink(SipHasher24::new());
    let mut options = prepared.options.clone();
    // The mesh does not depend on it.
    options.mesher.threads = 0;
    let nodes = &prepared.frame.table.points;
    // A hash takes any text.
    let _ = write!(
        sink,
        "{} {count} {:?} {options:?} {:?} {nodes:?}",
        env!("CARGO_PKG_VERSION"),
        prepared.model,
        prepared.rules
    );
    sink.0.finish128().as_u128()
}
