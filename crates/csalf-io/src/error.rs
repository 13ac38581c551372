//! What can go wrong while reading or writing.

use std::path::PathBuf;

/// Where in the input something was found.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub enum Place {
    /// Not known, or the input as a whole.
    #[default]
    Whole,
    /// A line, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(usize),
    /// A path into a tree, such as `loops[1].nodes[7]`.
    Path(String),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Whole => Ok(()),
            Self::Line(n) => write!(f, ", line {n}"),
            Self::Byte(n) => write!(f, ", byte {n}"),
            Self::Path(p) => write!(f, ", at {p}"),
        }
    }
}

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The file itself: missing, not readable, a directory.
    #[error("cannot read {path}: {source}", path = .path.display())]
    Open {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The sink would not take the bytes: disk full, pipe closed.
    #[error("cannot write: {0}")]
    Write(#[from] std::io::Error),
    /// The name does not tell the format.
    #[error("unknown file extension {extension:?}; known ones are {known}")]
    UnknownFormat {
        /// What stands after the last dot, empty if there is none.
        extension: String,
        /// What is known, separated by commas.
        known: String,
    },
    /// The bytes are not what the format wants.
    #[error("not a valid {format} file{place}: {message}")]
    Syntax {
        /// Name of the format.
        format: &'static str,
        /// Where.
        place: Place,
        /// What is wrong.
        message: String,
    },
    /// Valid, but more than this program reads or the format can hold.
    #[error("{format}{place}: {message}")]
    Unsupported {
        /// Name of the format.
        format: &'static str,
        /// Where.
        place: Place,
        /// What is not supported.
        message: String,
    },
    /// Valid, but it holds nothing of use.
    #[error("the {format} file holds no {wanted}")]
    Empty {
        /// Name of the format.
        format: &'static str,
        /// What was looked for.
        wanted: &'static str,
    },
}

impl IoError {
    /// A [`IoError::Syntax`] error.
    pub fn syntax(format: &'static str, place: Place, message: impl Into<String>) -> Self {
        Self::Syntax { format, place, message: message.into() }
    }

    /// A [`IoError::Unsupported`] error.
    pub fn unsupported(format: &'static str, place: Place, message: impl Into<String>) -> Self {
        Self::Unsupported { format, place, message: message.into() }
    }
}
