//! Layer 3 of csalf: loop-paving, the structured rings of quads around boundary loops.
//!
//! - [`front`]: the six loop fronts of Table I; [`classify`]: which node gets which.
//! - [`place`]: where their new nodes go; [`laws`]: how thick the layers are.
//! - [`ring`]: the ring of a whole loop as connectivity, with no closure needed.
//! - [`closure`]: the paper's sequential march with its closure stencils (Table II), which makes the same ring.
//! - [`driver`]: Algorithm I, layers around all loops of a region; [`evaluate`]: the tests that a ring must pass;
//!   [`mesher`]: one ring as a member of the triad.

mod build;
pub mod classify;
pub mod closure;
pub mod driver;
pub mod evaluate;
pub mod front;
mod index;
pub mod laws;
pub mod mesher;
pub mod place;
pub mod relax;
pub mod ring;
pub mod spec;

pub use driver::{LayerTask, Layers, Walk, WalkKind, WalkReport, pave_layers};
pub use evaluate::Stop;
pub use front::Front;
pub use mesher::LoopPaver;
pub use place::PavingRules;
pub use ring::{NoRing, Ring, Role};
pub use spec::{LayerLaw, LayerSpec};
