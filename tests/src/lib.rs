//! Test kit of csalf (skeleton).
