//! csalf-io (skeleton).
