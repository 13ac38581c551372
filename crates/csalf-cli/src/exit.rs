//! Exit codes, and the failures that lead to them.
//!
//! | code | meaning |
//! |---|---|
//! | 0 | done |
//! | 1 | `check`: the mesh is broken, or worse than `--min-sj` |
//! | 2 | wrong usage: options, unknown formats, a job file with wrong keys |
//! | 3 | the input is invalid: not what its format asks for, or not a domain that can be meshed |
//! | 4 | a valid input could not be meshed: a defect of this program |
//! | 5 | file trouble: a file cannot be read or written |

use csalf_core::MeshError;
use csalf_io::IoError;

/// The command did what was asked.
pub const DONE: u8 = 0;
/// A mesh failed its check.
pub const CHECK: u8 = 1;
/// The command line or the configuration is wrong.
pub const USAGE: u8 = 2;
/// The input is invalid.
pub const INVALID: u8 = 3;
/// A valid input could not be meshed.
pub const UNMESHED: u8 = 4;
/// A file cannot be read or written.
pub const FILES: u8 = 5;

/// Why a command did not do what was asked.
#[derive(Debug)]
pub enum Failure {
    /// A mesh failed its check (code 1): the findings, one per line.
    Check(Vec<String>),
    /// Wrong usage (code 2).
    Usage(String),
    /// Invalid input (code 3): what it is, and everything that is wrong with it.
    Invalid {
        /// Name of the input.
        input: String,
        /// The defects, one per line.
        defects: Vec<String>,
    },
    /// Could not mesh (code 4).
    Unmeshed(String),
    /// Some outlines of a file have no mesh; each was already reported. The code is the largest of theirs: a defect
    /// of this program is not to be lost among faults of the input.
    Several {
        /// The largest code.
        code: u8,
        /// Outlines in all.
        n_outlines: usize,
        /// One message per failed outline.
        errors: Vec<String>,
    },
    /// File trouble (code 5).
    Files(String),
}

impl Failure {
    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Check(_) => CHECK,
            Self::Usage(_) => USAGE,
            Self::Invalid { .. } => INVALID,
            Self::Unmeshed(_) => UNMESHED,
            Self::Files(_) => FILES,
            Self::Several { code, .. } => *code,
        }
    }

    /// The failure of meshing `input`.
    pub fn of_meshing(input: &str, error: &MeshError) -> Self {
        match error {
            MeshError::Invalid(defects) => Self::Invalid {
                input: input.to_owned(),
                defects: defects.iter().map(ToString::to_string).collect(),
            },
            MeshError::Internal { .. } => Self::Unmeshed(format!("{input}: {error}")),
            other => Self::Invalid { input: input.to_owned(), defects: vec![other.to_string()] },
        }
    }

    /// The failure of reading or writing `file`.
    pub fn of_file(file: &str, error: &IoError) -> Self {
        match error {
            IoError::Open { .. } => Self::Files(error.to_string()),
            IoError::Write(_) => Self::Files(format!("{file}: {error}")),
            IoError::UnknownFormat { .. } => Self::Usage(format!("{file}: {error}")),
            _ => Self::Invalid { input: file.to_owned(), defects: vec![error.to_string()] },
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Check(findings) => write!(f, "{}", findings.join("\n")),
            Self::Usage(m) | Self::Unmeshed(m) | Self::Files(m) => write!(f, "{m}"),
            Self::Several { n_outlines, errors, .. } => {
                write!(f, "{} of {n_outlines} outlines failed", errors.len())
            }
            Self::Invalid { input, defects } if defects.len() == 1 => write!(f, "{input}: {}", defects[0]),
            Self::Invalid { input, defects } => {
                write!(f, "{input}: {} defects\n  {}", defects.len(), defects.join("\n  "))
            }
        }
    }
}

impl std::error::Error for Failure {}

#[cfg(test)]
mod tests {
    use super::*;
    use csalf_geom::domain::Defect;

    #[test]
    fn all_defects_are_listed_one_per_line() {
        let d = |n| Defect::TooFewNodes { loop_name: format!("hole{n}"), n_nodes: 2 };
        let failure = Failure::of_meshing("plate.json", &MeshError::Invalid(vec![d(0), d(1)]));
        assert_eq!(failure.code(), INVALID);
        let text = failure.to_string();
        assert_eq!(text.lines().count(), 3, "{text}");
        assert!(text.starts_with("plate.json: 2 defects\n  hole0 has 2 nodes"), "{text}");
    }

    #[test]
    fn our_own_faults_are_told_from_the_users() {
        let error = MeshError::Internal { stage: "test", detail: "nothing".into() };
        assert_eq!(Failure::of_meshing("-", &error).code(), UNMESHED);
    }
}
