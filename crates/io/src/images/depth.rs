//! Depth images: 16-bit gray in the dataset's units, or meters as 32-bit floats in TIFF and NumPy files.

use std::io::Cursor;
use std::path::Path;

use geometry::DepthImage;
use image::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};

use super::decode::{decode_bytes, kind, raster, read, unsupported};
use super::{ImageError, ImageSize};

/// What one meter becomes where depth is given in meters: half a millimeter is the step, 32 m the largest depth.
pub(super) const UNITS_OF_METERS: f64 = 2000.0;

const EXPECTED: &str = "16-bit gray (a depth image), or meters as 32-bit floats (TIFF, NumPy)";
/// What sensors write where they know no depth, besides 0.
const NO_DEPTH: u16 = u16::MAX;

/// How a depth image is written.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Form {
    /// In the dataset's units.
    Units,
    /// In meters.
    Meters,
}

/// Reads a depth image: 16-bit gray unchanged in the dataset's units, 65535 as unknown; meters in units of half a millimeter.
///
/// # Errors
/// [`ImageError`]; `UnsupportedDepth` for any other kind of pixel.
pub fn load_depth(path: &Path) -> Result<DepthImage, ImageError> {
    let bytes = read(path)?;
    if let Some((size, meters)) = meters(path, &bytes)? {
        return raster(path, size, meters.iter().map(|&z| units_of(z)).collect());
    }
    let decoded = decode_bytes(path, &bytes)?;
    if decoded.color != ColorType::L16 {
        return Err(unsupported(path, decoded.color, EXPECTED));
    }
    let values = decoded.bytes.as_chunks::<2>().0.iter().map(|&pair| u16::from_ne_bytes(pair));
    raster(path, decoded.size, values.map(|value| if value == NO_DEPTH { 0 } else { value }).collect())
}

/// Size and form of a depth image.
///
/// # Errors
/// As [`load_depth`], as far as the header shows it.
pub(super) fn form(path: &Path) -> Result<(ImageSize, Form), ImageError> {
    let found = kind(path);
    if let Ok((size, ColorType::L16)) = found {
        return Ok((size, Form::Units));
    }
    if let Some((size, _)) = meters(path, &read(path)?)? {
        return Ok((size, Form::Meters));
    }
    found.and_then(|(_, color)| Err(unsupported(path, color, EXPECTED)))
}

fn units_of(meters: f32) -> u16 {
    let units = (f64::from(meters) * UNITS_OF_METERS).round();
    // What is too far, behind the camera or no number is not known.
    if units > 0.0 && units < f64::from(NO_DEPTH) { units as u16 } else { 0 }
}

/// The depths of a file of 32-bit floats; `None` for any other file.
fn meters(path: &Path, bytes: &[u8]) -> Result<Option<(ImageSize, Vec<f32>)>, ImageError> {
    let broken = |format: &'static str, reason: String| ImageError::Corrupt {
        path: path.to_path_buf(),
        format,
        reason,
    };
    if bytes.starts_with(b"\x93NUMPY") {
        let array = numpy(bytes).ok_or_else(|| {
            broken(
                "NumPy",
                "expected rows of little-endian floats (descr <f4 or <f8, height and width)".to_owned(),
            )
        })?;
        return Ok(Some(array));
    }
    if !bytes.starts_with(b"II*\0") && !bytes.starts_with(b"MM\0*") {
        return Ok(None);
    }
    let broken = |error: tiff::TiffError| broken("TIFF", error.to_string());
    let mut limits = Limits::default();
    limits.decoding_buffer_size = 256 << 20;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(broken)?.with_limits(limits);
    if decoder.colortype().map_err(broken)? != tiff::ColorType::Gray(32) {
        return Ok(None);
    }
    let (width, height) = decoder.dimensions().map_err(broken)?;
    match decoder.read_image().map_err(broken)? {
        DecodingResult::F32(values) => {
            Ok(Some((ImageSize { width: width as usize, height: height as usize }, values)))
        }
        _ => Ok(None),
    }
}

/// A NumPy array of height and width (and one channel) with little-endian floats of 32 or 64 bits, row by row.
fn numpy(bytes: &[u8]) -> Option<(ImageSize, Vec<f32>)> {
    let is_first = *bytes.get(6)? == 1;
    let (length, start): (usize, usize) = if is_first {
        (usize::from(u16::from_le_bytes(bytes.get(8..10)?.try_into().ok()?)), 10)
    } else {
        (u32::from_le_bytes(bytes.get(8..12)?.try_into().ok()?) as usize, 12)
    };
    let header = std::str::from_utf8(bytes.get(start..start.checked_add(length)?)?).ok()?;
    let after = |key: &str| header.split_once(key).map(|(_, rest)| rest.trim_start_matches([':', ' ', '\'']));
    let shape = after("shape")?.strip_prefix('(')?.split_once(')')?.0;
    let sides: Vec<usize> = shape
        .split(',')
        .filter(|s| !s.trim().is_empty())
        .map(|s| s.trim().parse().ok())
        .collect::<Option<_>>()?;
    let ([height, width] | [height, width, 1]) = sides[..] else { return None };
    let is_wide = after("descr")?.starts_with("<f8");
    let is_plain =
        (is_wide || after("descr")?.starts_with("<f4")) && after("fortran_order")?.starts_with("False");
    let data = bytes.get(start + length..)?;
    let n_bytes = width.checked_mul(height)?.checked_mul(if is_wide { 8 } else { 4 })?;
    if !is_plain || data.len() != n_bytes {
        return None;
    }
    let values = if is_wide {
        data.as_chunks::<8>().0.iter().map(|&eight| f64::from_le_bytes(eight) as f32).collect()
    } else {
        data.as_chunks::<4>().0.iter().map(|&four| f32::from_le_bytes(four)).collect()
    };
    Some((ImageSize { width, height }, values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_depth_is_unknown() {
        assert_eq!(
            [1.5, 0.0004, 0.0, -1.0, f32::NAN, f32::INFINITY, 40.0].map(units_of),
            [3000, 1, 0, 0, 0, 0, 0]
        );
    }

    #[test]
    fn numpy_arrays_of_floats_in_rows() {
        let file = |header: &str, values: &[f32]| {
            let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
            bytes.extend((header.len() as u16).to_le_bytes());
            bytes.extend(header.bytes().chain(values.iter().flat_map(|v| v.to_le_bytes())));
            bytes
        };
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }\n";
        let values = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(numpy(&file(header, &values)), Some((ImageSize { width: 3, height: 2 }, values.to_vec())));
        for (piece, other) in
            [("<f4", "<f2"), ("False", "True"), ("(2, 3)", "(6,)"), ("(2, 3)", "(99999999999, 99999999999)")]
        {
            assert_eq!(numpy(&file(&header.replace(piece, other), &values)), None, "{other}");
        }
        assert_eq!(numpy(&file(header, &values)[..40]), None);
        // Three doubles in six floats' place; one channel.
        let [low, high] = 2.5_f64
            .to_le_bytes()
            .as_chunks::<4>()
            .0
            .iter()
            .map(|&b| f32::from_le_bytes(b))
            .collect::<Vec<_>>()[..]
        else {
            panic!("two halves")
        };
        let wide = header.replace("<f4", "<f8").replace("(2, 3)", "(1, 3, 1)");
        let three = [low, high].repeat(3);
        assert_eq!(numpy(&file(&wide, &three)), Some((ImageSize { width: 3, height: 1 }, vec![2.5; 3])));
    }
}
