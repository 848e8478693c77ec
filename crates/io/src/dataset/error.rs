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
    /// What lies there is no folder with images: nothing, a file, or whole recordings in a form that is not read.
    #[error("{}: {what}", path.display())]
    NotAFolder {
        /// The path asked for.
        path: PathBuf,
        /// What is wrong, and what can be done.
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
    /// Something is missing or wrong: images, times, pairs, or a field of a calibration file.
    #[error("{}{place}: found {found}, expected {expected}", path.display())]
    Unexpected {
        /// The file or folder.
        path: PathBuf,
        /// The place in it, such as `:12: resolution`; empty for the whole.
        place: String,
        /// What is there.
        found: String,
        /// What should be there.
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

    /// Something else at `path` than what is needed.
    pub(crate) fn unexpected(path: &Path, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::in_field(path, "", found, expected)
    }

    /// The same for a field of the file.
    pub(crate) fn in_field(
        path: &Path,
        field: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        let place = if field.is_empty() { String::new() } else { format!(": {field}") };
        Self::Unexpected { path: path.to_path_buf(), place, found: found.into(), expected: expected.into() }
    }

    /// The parser's error for this file.
    pub(crate) fn syntax(path: &Path, error: SyntaxError) -> Self {
        let SyntaxError { line, format, message, .. } = error;
        Self::Syntax { path: path.to_path_buf(), line, format, message }
    }
}
