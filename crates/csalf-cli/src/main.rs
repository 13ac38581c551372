//! The command line of csalf (skeleton).
fn main() {}
