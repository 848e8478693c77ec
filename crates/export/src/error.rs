//! Why a map cannot be exported.

use std::path::PathBuf;

use io::{FileError, ImageError};

/// What is wrong; the message names the file or the sub-map, what was found and what was expected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// The map has no such sub-map.
    #[error(
        "found no sub-map {wanted}: the map has {n_submaps}, numbered from 0 by their number of keyframes"
    )]
    NoSuchSubmap {
        /// The number asked for.
        wanted: usize,
        /// How many there are.
        n_submaps: usize,
    },
    /// A keyframe is not one of the sequence's frames.
    #[error(
        "{}: found no frame at {timestamp_s} s, the time of keyframe {keyframe} (frame {frame}): \
         the map was built from another sequence",
        sequence.display()
    )]
    ForeignKeyframe {
        /// Folder of the sequence.
        sequence: PathBuf,
        /// The keyframe's number.
        keyframe: u32,
        /// Number of its frame.
        frame: u32,
        /// Its time, seconds.
        timestamp_s: f64,
    },
    /// An image cannot be read or has another size than the map's camera.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
}
