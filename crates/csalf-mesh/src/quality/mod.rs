//! Quality of meshes: one metric per file, and the [`QualityReport`] over all of them.
//!
//! Shape metrics are Verdict's, so that they can be compared with other programs; tau, the size figures and
//! the structure figures are those of the judge of the public cases. Each shape metric opens with a [`Card`].

pub mod angles;
pub mod aspect;
mod card;
mod corners;
pub(crate) mod edges;
pub mod jacobian_ratio;
pub mod metrics;
mod report;
pub mod scaled_jacobian;
pub mod shape;
pub mod size;
pub mod skew;
pub mod space;
pub mod structure;
pub mod tau;
#[cfg(test)]
mod tests;

pub use card::Card;
pub use corners::Corners;
pub use report::QualityReport;
pub use size::SizeConformity;
pub use structure::Structure;
pub use tau::Tau;

/// A quad corner whose scaled Jacobian is at most this counts as not convex: straight up to the rounding of
/// coordinates. Larger rejects slim but sound quads; smaller accepts corners that rounding made. (The judge's
/// value.)
pub const FLAT: f64 = 1e-6;

/// The cards of all shape metrics, in the order of the report.
pub const CARDS: [Card; 8] = [
    scaled_jacobian::CARD,
    jacobian_ratio::CARD,
    angles::MIN_CARD,
    angles::MAX_CARD,
    aspect::CARD,
    shape::CARD,
    skew::CARD,
    space::CARD,
];
