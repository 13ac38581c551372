//! csalf-subdiv (skeleton).
