//! Images from and to files: gray, color and depth; the first stage of the pipeline.

mod decode;
mod depth;
mod encode;
mod error;
mod gray;
mod halves;
mod inspect;
mod jpeg;
mod resize;

use std::path::Path;

use geometry::{DepthImage, GrayImage, Raster};

use crate::dataset::{FrameSource, Packing};

pub use decode::{image_size, load_gray, load_rgb};
pub use depth::load_depth;
pub use encode::{Preview, preview, save_png_depth, save_png_gray, save_png_rgb};
pub use error::ImageError;
pub use geometry::ImageSize;
pub use gray::brightness;
pub(crate) use halves::half_size;
pub(crate) use inspect::inspect;
pub use resize::{reduce_depth, reduce_gray};

/// Endings of the names of images, in small letters; their content tells their format.
pub(crate) const IMAGE_ENDINGS: [&str; 11] =
    ["png", "jpg", "jpeg", "pgm", "ppm", "pnm", "bmp", "tif", "tiff", "webp", "jpe"];

/// An 8-bit color image, red first.
pub type Rgb = Raster<[u8; 3]>;

/// The pixels of one frame.
#[derive(Clone, Debug)]
pub struct LoadedFrame {
    /// Left (or only) image, gray.
    pub left: GrayImage,
    /// Right image, of the size of the left.
    pub right: Option<GrayImage>,
    /// Depth in the dataset's units (see `camera.depth_units_per_metre`), of the size of the left; 0 is unknown.
    pub depth: Option<DepthImage>,
}

impl LoadedFrame {
    /// Size of the images of this frame.
    pub fn size(&self) -> ImageSize {
        self.left.size()
    }

    /// The frame that an image holds, alone or side by side with another one; errors name `path`.
    ///
    /// # Errors
    /// [`ImageError::OddWidth`].
    pub fn unpacked(image: GrayImage, packing: Packing, path: &Path) -> Result<Self, ImageError> {
        let (left, right) = halves::take(image, packing, path)?;
        Ok(Self { left, right, depth: None })
    }
}

/// Reads all images of a frame; the right image and the depth must have the size of the left one.
///
/// # Errors
/// The first [`ImageError`] met, in the order left, right, depth.
pub fn load_frame(source: &FrameSource) -> Result<LoadedFrame, ImageError> {
    let (left, packed_right) = halves::take(load_gray(&source.left)?, source.packing, &source.left)?;
    let expected = left.size();
    let because = format!("as {}", source.left.display());
    let mut frame = LoadedFrame { left, right: packed_right, depth: None };
    if let Some(path) = &source.right {
        let right = frame.right.insert(load_gray(path)?);
        check_size(path, right.size(), expected, &because)?;
    }
    if let Some(path) = &source.depth {
        let depth = frame.depth.insert(load_depth(path)?);
        check_size(path, depth.size(), expected, &because)?;
    }
    Ok(frame)
}

/// Compares the size of an image with the one that it should have; `because` says where that comes from.
///
/// # Errors
/// [`ImageError::WrongSize`].
pub fn check_size(
    path: &Path,
    found: ImageSize,
    expected: ImageSize,
    because: &str,
) -> Result<(), ImageError> {
    if found == expected { Ok(()) } else { Err(ImageError::wrong_size(path, found, expected, because)) }
}
