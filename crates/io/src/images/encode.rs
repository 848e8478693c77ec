//! Writing of PNG files, each under a temporary name first; small JPEG previews.

use std::path::{Path, PathBuf};

use geometry::{DepthImage, GrayImage};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::Rgb;
use crate::file::{FileError, write_atomic};

/// Writes an 8-bit gray PNG.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn save_png_gray(path: &Path, image: &GrayImage) -> Result<(), FileError> {
    save(path, (image.width, image.height), &image.data, ExtendedColorType::L8)
}

/// Writes an 8-bit color PNG.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn save_png_rgb(path: &Path, image: &Rgb) -> Result<(), FileError> {
    save(path, (image.width, image.height), image.data.as_flattened(), ExtendedColorType::Rgb8)
}

/// Writes a 16-bit gray PNG, values unchanged.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn save_png_depth(path: &Path, image: &DepthImage) -> Result<(), FileError> {
    let bytes: Vec<u8> = image.data.iter().flat_map(|value| value.to_ne_bytes()).collect();
    save(path, (image.width, image.height), &bytes, ExtendedColorType::L16)
}

/// A small picture of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Preview {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// A JPEG file.
    pub jpeg: Vec<u8>,
}

/// Quality of previews, of 100.
const PREVIEW_QUALITY: u8 = 75;

/// A preview at most `max_width` wide: blocks of pixels averaged, the same number in x and y. `None` for an image that JPEG cannot
/// hold: without pixels, or with more than 65 535 in a row or column.
pub fn preview(image: &GrayImage, max_width: usize) -> Option<Preview> {
    let side = image.width.div_ceil(max_width.max(1)).max(1);
    let (width, height) = (image.width / side, image.height / side);
    let pixels = averaged(image, side);
    let mut jpeg = Vec::with_capacity(pixels.len() / 4);
    let mut encoder = JpegEncoder::new_with_quality(&mut jpeg, PREVIEW_QUALITY);
    let (columns, rows) = (u32::from(u16::try_from(width).ok()?), u32::from(u16::try_from(height).ok()?));
    encoder.encode(&pixels, columns, rows, ExtendedColorType::L8).ok()?;
    Some(Preview { width, height, jpeg })
}

/// Means of blocks of `side` x `side` pixels, rounded; rows and columns that fill no block are skipped.
fn averaged(image: &GrayImage, side: usize) -> Vec<u8> {
    let (width, height) = (image.width / side, image.height / side);
    let mut pixels = Vec::with_capacity(width * height);
    let mut sums = vec![0_u32; width];
    let n = (side * side) as u32;
    for block in 0..height {
        sums.fill(0);
        for y in block * side..(block + 1) * side {
            // The usual sides are known to the compiler, which makes them several times faster.
            match side {
                1 => add::<1>(&mut sums, image.row(y)),
                2 => add::<2>(&mut sums, image.row(y)),
                3 => add::<3>(&mut sums, image.row(y)),
                _ => {
                    for (sum, pixels) in sums.iter_mut().zip(image.row(y).chunks_exact(side)) {
                        *sum += pixels.iter().map(|&pixel| u32::from(pixel)).sum::<u32>();
                    }
                }
            }
        }
        pixels.extend(sums.iter().map(|sum| ((sum + n / 2) / n) as u8));
    }
    pixels
}

/// Adds up groups of `SIDE` pixels.
fn add<const SIDE: usize>(sums: &mut [u32], row: &[u8]) {
    for (sum, pixels) in sums.iter_mut().zip(row.as_chunks::<SIDE>().0) {
        *sum += pixels.iter().map(|&pixel| u32::from(pixel)).sum::<u32>();
    }
}

fn save(
    path: &Path,
    (width, height): (usize, usize),
    bytes: &[u8],
    color: ExtendedColorType,
) -> Result<(), FileError> {
    let unwritable = |reason: String| FileError::Unwritable { path: PathBuf::from(path), reason };
    let side =
        |n: usize| u32::try_from(n).map_err(|_| unwritable(format!("{n} pixels are more than PNG can hold")));
    let (width, height) = (side(width)?, side(height)?);
    let mut encoded = Vec::with_capacity(bytes.len() / 2);
    // A fixed filter is written five times faster than the adaptive one and costs 5 % in size.
    PngEncoder::new_with_quality(&mut encoded, CompressionType::Fast, FilterType::Sub)
        .write_image(bytes, width, height, color)
        .map_err(|error| unwritable(error.to_string()))?;
    write_atomic(path, &encoded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_every_size_are_averaged() {
        let image = GrayImage::from_fn(23, 17, |x, y| (x * x * 7 + y * 31 + x * y) as u8);
        for side in 1..=6 {
            let pixels = averaged(&image, side);
            assert_eq!(pixels.len(), (23 / side) * (17 / side));
            for (i, &found) in pixels.iter().enumerate() {
                let (left, top) = (i % (23 / side) * side, i / (23 / side) * side);
                let all = (0..side * side).map(|k| f64::from(image.at(left + k % side, top + k / side)));
                let mean = all.sum::<f64>() / (side * side) as f64;
                assert!(
                    (f64::from(found) - mean).abs() <= 0.5,
                    "side {side}, pixel {i}: {found}, mean {mean}"
                );
            }
        }
    }
}
