//! Before any face is meshed: how large, where, and how many nodes on each edge.

mod edges;
mod parity;
mod size;
#[cfg(test)]
mod tests;

pub use edges::{EdgeNodes, Infeasible, Limits, Plan, plan};
pub use size::SizeRules;
