//! csalf-clean (skeleton).
