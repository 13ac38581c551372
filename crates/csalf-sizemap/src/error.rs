//! What is wrong with wanted sizes.

/// Why no size field can be built. Indices count from 0 in the list that `what` names.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SizeError {
    /// A size is zero or negative: two coincident neighbours on a loop, or a wrong number of the caller's.
    #[error("size {value} of {what} {index} is not positive")]
    NotPositive {
        /// The list: `loop node`, `background node`, `source`, `hard point`, `uniform size`, `far size`.
        what: &'static str,
        /// Place in the list; loop nodes are counted through all loops.
        index: usize,
        /// The size.
        value: f64,
    },
    /// A size is NaN or infinite.
    #[error("size {value} of {what} {index} is not a finite number")]
    NotFinite {
        /// The list, as in [`Self::NotPositive`].
        what: &'static str,
        /// Place in the list.
        index: usize,
        /// The size.
        value: f64,
    },
    /// A coordinate is NaN or infinite.
    #[error("{what} {index} has a coordinate that is not a finite number")]
    BadPoint {
        /// The list.
        what: &'static str,
        /// Place in the list.
        index: usize,
    },
    /// A source has a negative radius, a falloff that is not positive, or one of them is not finite.
    #[error("source {index}: {what} is {value}")]
    BadSource {
        /// Place in the list of sources.
        index: usize,
        /// `radius` or `falloff`.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A triangle names a node that does not exist.
    #[error("triangle {triangle} of the background names node {node} of {n_points}")]
    BadTriangle {
        /// Place in the list of triangles.
        triangle: usize,
        /// The node it names.
        node: u32,
        /// How many nodes there are.
        n_points: usize,
    },
    /// Points and values differ in number.
    #[error("the background has {n_points} points and {n_values} values")]
    Lengths {
        /// Number of points.
        n_points: usize,
        /// Number of values.
        n_values: usize,
    },
    /// The points span no triangle inside the domain: all on one line, or too few.
    #[error("the background has no triangle of positive area")]
    NoArea,
    /// More nodes than 32-bit indices can name.
    #[error("the background has {0} nodes, more than can be numbered")]
    TooMany(usize),
    /// The gradation limit is not a positive number.
    #[error("gradation limit {0} is not a positive number")]
    BadGradation(f64),
}

/// Checks one size.
pub(crate) fn check_size(what: &'static str, index: usize, value: f64) -> Result<(), SizeError> {
    if !value.is_finite() {
        Err(SizeError::NotFinite { what, index, value })
    } else if value <= 0.0 {
        Err(SizeError::NotPositive { what, index, value })
    } else {
        Ok(())
    }
}
