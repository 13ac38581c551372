//! Layer 3 of csalf: better meshes of the same boundary. [`mod@smooth`] moves inner vertices, certified never to
//! turn a quad over.

pub mod cavity;
pub mod driver;
pub mod edit;
pub mod ops;
pub mod reshape;
pub mod smooth;

pub use cavity::{CavityReport, CavityRules, CavityTask, refill_cavities};
pub use driver::{REMOVED, RepairReport, repair};
pub use reshape::{ReshapeReport, ReshapeTask, reshape};
pub use smooth::{
    FinishReport, SmoothOptions, SmoothReport, UntangleReport, finish, lift, smooth, smooth_boxed, untangle,
};
