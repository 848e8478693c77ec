//! What can be wrong with a vocabulary file.

use std::path::{Path, PathBuf};

/// Why bytes are not a vocabulary.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// Neither format.
    #[error("not a vocabulary: found {found}, expected a DSSLAM vocabulary or ORB-SLAM2's text format")]
    Unknown {
        /// How the data begins.
        found: String,
    },
    /// Written by a later version of the program.
    #[error("format version {found} is newer than this program reads (up to {supported})")]
    Newer {
        /// Version in the file.
        found: u32,
        /// Highest version known here.
        supported: u32,
    },
    /// A version that never existed.
    #[error("format version {found} does not exist, expected 1 to {supported}")]
    Version {
        /// Version in the file.
        found: u32,
        /// Highest version known here.
        supported: u32,
    },
    /// The data end too early.
    #[error("truncated: found {found} bytes, expected {expected}")]
    Truncated {
        /// Bytes there.
        found: u64,
        /// Bytes that the header announces, or that a header needs.
        expected: u64,
    },
    /// The data go on behind their end.
    #[error("too long: found {found} bytes, expected {expected}")]
    TooLong {
        /// Bytes there.
        found: u64,
        /// Bytes that the header announces.
        expected: u64,
    },
    /// Some byte changed since the file was written.
    #[error("corrupted: checksum {found:08x}, expected {expected:08x}")]
    Checksum {
        /// Checksum of the bytes.
        found: u32,
        /// Checksum that the file states.
        expected: u32,
    },
    /// The checksum is right, the contents are none of a vocabulary tree.
    #[error("invalid: {0}")]
    Invalid(String),
    /// A line of the text format.
    #[error("line {line}: found {found}, expected {expected}")]
    Line {
        /// Line number, from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What should stand there.
        expected: String,
    },
}

/// Why a vocabulary file cannot be read or written; the message names the file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VocabularyError {
    /// The operating system refused to read it.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The reason given by the operating system.
        reason: String,
    },
    /// Its contents are not a vocabulary.
    #[error("{}: {problem}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: FormatError,
    },
    /// The operating system refused to write it.
    #[error(transparent)]
    Unwritable(io::FileError),
}

impl VocabularyError {
    pub(crate) fn unreadable(path: &Path, error: &std::io::Error) -> Self {
        Self::Unreadable { path: path.to_path_buf(), reason: error.to_string() }
    }
}
