//! What can be wrong with a dataset as a whole.

use std::path::PathBuf;

use super::Sensor;
use crate::file::FileError;

/// Why a dataset cannot be opened.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DatasetError {
    /// The folder does not exist.
    #[error("{}: no such folder", path.display())]
    MissingFolder {
        /// The folder asked for.
        path: PathBuf,
    },
    /// There is something under this name, but no folder.
    #[error("{}: not a folder", path.display())]
    NotAFolder {
        /// The path asked for.
        path: PathBuf,
    },
    /// The folder has neither of the known layouts.
    #[error(
        "{}: no known dataset layout, expected KITTI (times.txt, calib.txt, image_0 or image_2) or TUM RGB-D (rgb.txt, depth.txt)",
        path.display()
    )]
    UnknownLayout {
        /// The folder.
        path: PathBuf,
    },
    /// The folder does not hold what the chosen sensor needs.
    #[error("{}: sensor {sensor} is not possible here: {reason}", path.display())]
    SensorUnavailable {
        /// The folder.
        path: PathBuf,
        /// The sensor asked for.
        sensor: Sensor,
        /// What is missing.
        reason: String,
    },
    /// The folder lists no frame at all.
    #[error("{}: found no image, expected {expected}", path.display())]
    NoImages {
        /// The folder.
        path: PathBuf,
        /// Where images should be.
        expected: String,
    },
    /// A camera's line is missing in `calib.txt`.
    #[error("{}: found no line `{camera}:`, expected 12 numbers (projection matrix, row by row)", path.display())]
    MissingCamera {
        /// The calibration file.
        path: PathBuf,
        /// `P0` to `P3`.
        camera: String,
    },
    /// A text file of the dataset is broken.
    #[error(transparent)]
    File(#[from] FileError),
}
