//! What can be wrong with an image file.

use std::path::PathBuf;

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
        /// `PNG` or `JPEG`.
        format: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// The file is neither PNG nor JPEG.
    #[error("{}: not an image: begins with {found}, expected PNG or JPEG", path.display())]
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
