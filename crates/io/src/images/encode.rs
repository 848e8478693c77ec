//! Writing of PNG files, each under a temporary name first.

use std::path::{Path, PathBuf};

use geometry::{DepthImage, GrayImage};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::Rgb;
use crate::file::{FileError, write_atomic};

/// Writes an 8-bit grey PNG.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn save_png_gray(path: &Path, image: &GrayImage) -> Result<(), FileError> {
    save(path, (image.width, image.height), &image.data, ExtendedColorType::L8)
}

/// Writes an 8-bit colour PNG.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn save_png_rgb(path: &Path, image: &Rgb) -> Result<(), FileError> {
    save(path, (image.width, image.height), image.data.as_flattened(), ExtendedColorType::Rgb8)
}

/// Writes a 16-bit grey PNG, values unchanged.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn save_png_depth(path: &Path, image: &DepthImage) -> Result<(), FileError> {
    let bytes: Vec<u8> = image.data.iter().flat_map(|value| value.to_ne_bytes()).collect();
    save(path, (image.width, image.height), &bytes, ExtendedColorType::L16)
}

fn save(
    path: &Path,
    (width, height): (usize, usize),
    bytes: &[u8],
    color: ExtendedColorType,
) -> Result<(), FileError> {
    let unwritable = |reason: String| FileError::Unwritable { path: PathBuf::from(path), reason };
    let side =
        |n: usize| u32::try_from(n).map_err(|_| unwritable(format!("{n} pixels are too many for PNG")));
    let (width, height) = (side(width)?, side(height)?);
    let mut encoded = Vec::with_capacity(bytes.len() / 2);
    // A fixed filter is written five times faster than the adaptive one and costs 5 % in size.
    PngEncoder::new_with_quality(&mut encoded, CompressionType::Fast, FilterType::Sub)
        .write_image(bytes, width, height, color)
        .map_err(|error| unwritable(error.to_string()))?;
    write_atomic(path, &encoded)
}
