//! What can be wrong with a dataset as a whole.

use std::path::{Path, PathBuf};

use geometry::RectificationError;

use super::Sensor;
use crate::document::SyntaxError;
use crate::file::FileError;
use crate::images::ImageError;

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
    /// A file that holds whole recordings in a form that is not read.
    #[error("{}: {what}", path.display())]
    Container {
        /// The file.
        path: PathBuf,
        /// What it is, and what can be done.
        what: &'static str,
    },
    /// The folder has none of the known layouts.
    #[error(
        "{}: no known dataset layout: found {found}; expected KITTI (image_0 or image_2 with times.txt), KITTI raw \
         (image_00/data), KITTI-360 (image_00/data_rect), TUM RGB-D (rgb.txt and depth.txt, or associations.txt), OpenLORIS \
         (color.txt and aligned_depth.txt), EuRoC or TUM-VI (mav0/cam0), TartanAir (image_left), 7-Scenes (*.color.png), \
         Replica (results/frame*), VSLAM-LAB (rgb.csv) or images in the folder itself, in left and right, or in rgb and depth",
        path.display()
    )]
    UnknownLayout {
        /// The folder.
        path: PathBuf,
        /// What lies in it.
        found: String,
    },
    /// A calibration file has none of the known formats.
    #[error("{}: found {found}, expected one of these calibrations: {expected}", path.display())]
    UnknownCalibration {
        /// The file.
        path: PathBuf,
        /// What stands in it.
        found: String,
        /// The formats that are read.
        expected: String,
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
    /// No two images of a stereo rig were taken at the same time.
    #[error("{}: found {found}, expected one within {tolerance_ms} ms", path.display())]
    NoPairs {
        /// The list of the right images.
        path: PathBuf,
        /// What the lists hold.
        found: String,
        /// Largest time between the images of a pair, milliseconds.
        tolerance_ms: f64,
    },
    /// A list of times does not fit the images.
    #[error("{}: found {found}, expected {n_images} (one per image)", path.display())]
    TimesOfImages {
        /// The list.
        path: PathBuf,
        /// How many there are.
        found: String,
        /// Number of images.
        n_images: usize,
    },
    /// A calibration file is not what it looks like.
    #[error("{}:{line}: invalid {format}: {message}", path.display())]
    Syntax {
        /// The calibration file.
        path: PathBuf,
        /// Line number, from 1.
        line: u64,
        /// `YAML`, `JSON` or `XML`.
        format: &'static str,
        /// The parser's message.
        message: String,
    },
    /// A field of a calibration file is missing or wrong.
    #[error("{}{line}: {field}: found {found}, expected {expected}", path.display())]
    Field {
        /// The calibration file.
        path: PathBuf,
        /// A colon and the line number, from 1; empty for a missing field.
        line: String,
        /// The field.
        field: String,
        /// What stands there.
        found: String,
        /// What should stand there.
        expected: String,
    },
    /// The cameras of a calibration cannot be rectified.
    #[error("{}: {field}: {error}", path.display())]
    Rectification {
        /// The calibration file of the right camera, or of that with a lens that cannot be inverted.
        path: PathBuf,
        /// The field with the right camera's place, or the lens.
        field: String,
        /// Why.
        error: RectificationError,
    },
    /// The images do not have the size that they should have.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A text file of the dataset is broken.
    #[error(transparent)]
    File(#[from] FileError),
}

impl DatasetError {
    /// A sensor that is not possible with what lies at `path`.
    pub fn unavailable(path: &Path, sensor: Sensor, reason: impl Into<String>) -> Self {
        Self::SensorUnavailable { path: path.to_path_buf(), sensor, reason: reason.into() }
    }

    /// The parser's error for this file.
    pub(crate) fn syntax(path: &Path, error: SyntaxError) -> Self {
        let SyntaxError { line, format, message, .. } = error;
        Self::Syntax { path: path.to_path_buf(), line, format, message }
    }
}
