//! Two images side by side in one file, left and right.

use std::path::Path;

use geometry::GrayImage;

use super::{ImageError, ImageSize};
use crate::dataset::Packing;

/// Size of one half of an image of this size.
///
/// # Errors
/// [`ImageError::OddWidth`] naming `path`.
pub(crate) fn half_size(path: &Path, size: ImageSize) -> Result<ImageSize, ImageError> {
    if !size.width.is_multiple_of(2) || size.width == 0 {
        return Err(ImageError::OddWidth { path: path.to_path_buf(), found: size });
    }
    Ok(ImageSize { width: size.width / 2, height: size.height })
}

/// The left image and, where both are used, the right one that `image` holds.
///
/// # Errors
/// [`ImageError::OddWidth`].
pub(super) fn take(
    image: GrayImage,
    packing: Packing,
    path: &Path,
) -> Result<(GrayImage, Option<GrayImage>), ImageError> {
    if packing == Packing::Whole {
        return Ok((image, None));
    }
    let size = image.size();
    let half = half_size(path, size)?;
    let from = |column: usize| {
        GrayImage::from_fn(half.width, half.height, |x, y| image.data[y * image.width + column + x])
    };
    Ok((from(0), (packing == Packing::BothHalves).then(|| from(half.width))))
}
