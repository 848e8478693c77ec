//! Why bytes are not a usable map file. No message names a path: the caller knows it.

use crate::Violation;

/// What is wrong with the bytes of a map file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapFileError {
    /// The bytes do not begin as every map file does.
    #[error("not a map file: {found}, expected a file that begins with `DSMAP`")]
    NotAMapFile {
        /// What is there instead.
        found: String,
    },
    /// The end is missing.
    #[error("truncated map file: has {found} bytes, {expected} expected")]
    Truncated {
        /// Number of bytes.
        found: u64,
        /// Number of bytes that the header says, or of the header itself.
        expected: u64,
    },
    /// Bytes after the end.
    #[error("damaged map file: has {found} bytes, its header says {expected}")]
    TooLong {
        /// Number of bytes.
        found: u64,
        /// Number of bytes that the header says.
        expected: u64,
    },
    /// Bytes were changed after the file had been made.
    #[error("damaged map file: checksum of {part} is {found}, expected {expected}")]
    Checksum {
        /// What the checksum is for.
        part: &'static str,
        /// The checksum of the bytes, hexadecimal.
        found: String,
        /// The checksum that the file states.
        expected: String,
    },
    /// The file was made by a newer or an older program.
    #[error("map file has format version {found}, this program reads versions {oldest} to {newest}")]
    Version {
        /// Version of the file.
        found: u32,
        /// The oldest version that can be read.
        oldest: u32,
        /// The newest one.
        newest: u32,
    },
    /// Undamaged, but not what a map file holds: the program that made it had a defect.
    #[error("unreadable map file: {reason}")]
    Malformed {
        /// What was found and what was expected.
        reason: String,
    },
    /// Undamaged and readable, but the relations in the map contradict each other.
    #[error("inconsistent map in file: {violation}{}", if *.n_more > 0 { format!(" (and {} more)", .n_more) } else { String::new() })]
    Inconsistent {
        /// The first broken invariant.
        violation: Box<Violation>,
        /// How many more there are.
        n_more: usize,
    },
}

impl MapFileError {
    pub(super) fn malformed(reason: impl Into<String>) -> Self {
        MapFileError::Malformed { reason: reason.into() }
    }
}
