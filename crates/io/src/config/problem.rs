//! What is wrong with a configuration: all problems at once, each with its place.

use std::fmt;
use std::path::PathBuf;

/// Where a value comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Provenance {
    /// The defaults.
    Default,
    /// A configuration file.
    File {
        /// The file.
        path: PathBuf,
        /// Line from 1, 0 where unknown.
        line: u64,
        /// Column from 1, 0 where unknown.
        column: u64,
    },
    /// `--set`, with its argument.
    Override(String),
    /// A calibration file of the dataset, with its path.
    Calibration(String),
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Where it stands.
    pub place: Provenance,
    /// The key as given; empty for a file as a whole.
    pub key: String,
    /// What was found and what was expected.
    pub message: String,
}

/// Everything that is wrong with a configuration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", .0.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n"))]
pub struct ConfigErrors(pub Vec<Problem>);

impl Problem {
    /// A problem with a value.
    pub fn new(place: &Provenance, key: &str, found: impl fmt::Display, expected: &str) -> Self {
        let message = format!("found {found}, expected {expected}");
        Self { place: place.clone(), key: key.to_string(), message }
    }
}

impl fmt::Display for Provenance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Default => write!(f, "default"),
            Self::File { path, line: 0, .. } => write!(f, "{}", path.display()),
            Self::File { path, line, column } => write!(f, "{}:{line}:{column}", path.display()),
            Self::Override(argument) => write!(f, "--set {argument}"),
            Self::Calibration(source) => write!(f, "{source}"),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.key.is_empty() {
            write!(f, "{}: {}", self.place, self.message)
        } else {
            write!(f, "{}: {}: {}", self.place, self.key, self.message)
        }
    }
}
