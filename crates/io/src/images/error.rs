//! What can be wrong with an image file.

use std::path::{Path, PathBuf};

use geometry::ImageSize;

/// Why an image file gives no image.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImageError {
    /// The file does not exist.
    #[error("{}: no such image", path.display())]
    Missing {
        /// The image file.
        path: PathBuf,
    },
    /// The operating system refused to read it.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The image file.
        path: PathBuf,
        /// The reason given by the operating system.
        reason: String,
    },
    /// The file has no bytes.
    #[error("{}: empty file (0 bytes), expected an image", path.display())]
    Empty {
        /// The image file.
        path: PathBuf,
    },
    /// The file begins like an image but cannot be decoded.
    #[error("{}: truncated or corrupt {format} image: {reason}", path.display())]
    Corrupt {
        /// The image file.
        path: PathBuf,
        /// `PNG`, `JPEG` and so on.
        format: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// The file is none of the images that are read.
    #[error("{}: not an image: begins with {found}, expected PNG, JPEG, PGM, PPM, BMP, TIFF or WebP", path.display())]
    NotAnImage {
        /// The image file.
        path: PathBuf,
        /// Its first bytes, as text where they are text.
        found: String,
    },
    /// The image has another size than it must have.
    #[error("{}: found {found} pixels, expected {expected} ({because})", path.display())]
    WrongSize {
        /// The image file.
        path: PathBuf,
        /// Its size.
        found: ImageSize,
        /// The size that it should have.
        expected: ImageSize,
        /// Where the expectation comes from.
        because: String,
    },
    /// An image that holds two side by side cannot be halved.
    #[error("{}: found {found} pixels, expected an even width (two images side by side)", path.display())]
    OddWidth {
        /// The image file.
        path: PathBuf,
        /// Its size.
        found: ImageSize,
    },
    /// The image has channels or bits that are not supported for its purpose.
    #[error("{}: found {found}, expected {expected}", path.display())]
    UnsupportedDepth {
        /// The image file.
        path: PathBuf,
        /// Its kind of pixel.
        found: String,
        /// The kinds that are supported.
        expected: &'static str,
    },
}

impl ImageError {
    /// The error of an image file that has another size than it must have; where that comes from a note in the file that it is to be
    /// turned, the error says so.
    pub fn wrong_size(path: &Path, found: ImageSize, expected: ImageSize, because: &str) -> Self {
        let is_turned = found.width == expected.height && found.height == expected.width;
        let note = Some(path).filter(|_| is_turned).and_then(super::decode::orientation);
        let because = match note {
            Some(note) => format!(
                "{because}; the file has the EXIF note that it is to be shown {note}, which is not done here: turn the images first"
            ),
            None if found.width == 2 * expected.width && found.height == expected.height => format!(
                "{because}; it is twice as wide: two views side by side need the calibration of both cameras"
            ),
            None => because.to_owned(),
        };
        Self::WrongSize { path: path.to_path_buf(), found, expected, because }
    }
}
