//! What [`crate::mesh`] can fail with.

/// Why there is no mesh.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The input is invalid; every defect is listed.
    #[error("the input is invalid: {}", .0.iter().map(|d| d.to_string()).collect::<Vec<_>>().join("; "))]
    Invalid(Vec<csalf_geom::domain::Defect>),
    /// The wanted sizes are invalid.
    #[error("the wanted sizes are invalid: {0}")]
    Size(#[from] csalf_sizemap::SizeError),
    /// The caller's [`crate::Watch`] ended the run.
    #[error("cancelled")]
    Cancelled,
    /// A defect of this program: the stage and what it found. Please report it with the input.
    #[error("internal error in stage {stage}: {detail}")]
    Internal {
        /// Stage of the pipeline.
        stage: &'static str,
        /// What was found.
        detail: String,
    },
}
