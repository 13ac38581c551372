//! csalf-tfi (skeleton).
