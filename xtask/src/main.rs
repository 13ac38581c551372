//! Developer tasks of csalf (skeleton).
fn main() {}
