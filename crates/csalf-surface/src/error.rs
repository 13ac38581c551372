//! Why a face has no mesh.

use csalf_core::MeshError;
use glam::DVec3;

/// Why [`crate::mesh_face`] gave no mesh. Indices are those of the input.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FaceError {
    /// A list has the wrong length, or names something that does not exist.
    #[error("{what} {index} of the face is out of range or not finite")]
    BadInput {
        /// The list: `facet`, `facet vertex`, `loop`, `scar`, `point`, `size`, `flat coordinate`.
        what: &'static str,
        /// Place in it.
        index: usize,
    },
    /// The facets are no oriented surface: a side with more than two facets, or with two in the same
    /// direction.
    #[error(
        "the facets do not form an oriented surface at {at}: more than two meet at a side, or one is turned over"
    )]
    NotASurface {
        /// Where.
        at: DVec3,
    },
    /// No facets, or none with an area.
    #[error("the face has no area")]
    NoArea,
    /// The loops have an odd number of segments in total.
    #[error(
        "the loops of the face have {n_segments} segments in total, an odd number; quads need an even one"
    )]
    Odd {
        /// How many.
        n_segments: usize,
    },
    /// The face, or a piece of it, could not be brought into the plane.
    #[error("the face cannot be flattened near {at}: {why}")]
    Flatten {
        /// Somewhere in it.
        at: DVec3,
        /// What was tried.
        why: String,
    },
    /// Both sides of a spike or a fin are but one quad wide, so that they would share quad sides across it.
    #[error("the face is thinner than two quads near {at}: ask for smaller sizes there")]
    TooThin {
        /// Where.
        at: DVec3,
    },
    /// The planar mesher refused a flattened piece.
    #[error("the flattened face cannot be meshed{}: {error}", .at.map(|p| format!(" near {p}")).unwrap_or_default())]
    Planar {
        /// Where in space, if it has a place.
        at: Option<DVec3>,
        /// Why. Coordinates in it are those of the flattened face.
        error: Box<MeshError>,
    },
    /// The boundary of the facets runs where no loop does, or between nodes that are not successive on one.
    #[error(
        "the boundary of the facets does not follow the loops at {at}: a crack, or a loop that is missing"
    )]
    Boundary {
        /// Where.
        at: DVec3,
    },
    /// A defect of this program: the stage and what it found. Please report it with the input.
    #[error("internal error in stage {stage} of a face: {detail}")]
    Internal {
        /// Stage.
        stage: &'static str,
        /// What was found.
        detail: String,
    },
}
