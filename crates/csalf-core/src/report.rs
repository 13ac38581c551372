//! What came out, besides the mesh.

use csalf_mesh::{NamedSets, QuadMesh};

/// A finished mesh and all that is known of it.
#[derive(Clone, Debug)]
pub struct Meshed {
    /// The mesh.
    pub mesh: QuadMesh,
    /// Node, edge and quad sets named after loops, scars, points and layers.
    pub sets: NamedSets,
    /// Counts, warnings, times.
    pub report: MeshReport,
}

/// Outcome of one run, without quality figures (those are computed from the mesh by `csalf_mesh::quality`).
#[derive(Clone, Debug, Default)]
pub struct MeshReport {
    /// Per loop and scar: layers asked and made.
    pub loops: Vec<LoopReport>,
    /// What could not be done better.
    pub warnings: Vec<Warning>,
    /// Times of the meshing alone.
    pub timing: Timing,
    /// How many contours each member of the triad (and each fallback) finished, by name.
    pub members: Vec<(&'static str, usize)>,
}

/// Layers of one loop.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoopReport {
    /// Name of the loop or scar.
    pub name: String,
    /// Layers asked for (by the user or by rule).
    pub asked: usize,
    /// Layers made in full.
    pub made: usize,
    /// Why it stopped early, in words; empty if it did not.
    pub stopped: String,
    /// Largest relative thickness error over the finished layers.
    pub thickness_error: f64,
}

/// Something that could not be done better; not an error.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// A contour had to be filled by the guaranteed fallback.
    #[error("{n_nodes} nodes around ({x:.6}, {y:.6}) were filled by the fallback")]
    Fallback {
        /// Size of the contour.
        n_nodes: usize,
        /// Somewhere in it.
        x: f64,
        /// Somewhere in it.
        y: f64,
    },
    /// A first mesh did not pass the certificate; this one was made by simpler means and passed.
    #[error("meshed again by simpler means: {reason}")]
    Retried {
        /// What the certificate found.
        reason: String,
    },
    /// A node was added to make a region even (only where the caller allows it).
    #[error("a node was added to {name} at ({x:.6}, {y:.6}) to make the region beside it even")]
    NodeAdded {
        /// The scar.
        name: String,
        /// Where.
        x: f64,
        /// Where.
        y: f64,
    },
}

/// Times of the meshing alone: no reading, no writing, no quality report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timing {
    /// Wall clock seconds of all that was tried.
    pub wall_s: f64,
    /// Stages of the run that made the mesh, in order: name and wall seconds.
    pub stages: Vec<(&'static str, f64)>,
}
