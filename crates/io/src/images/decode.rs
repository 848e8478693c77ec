//! Decoding of PNG and JPEG files. The bytes are read first, so that each way of being broken has its own error.

use std::fs;
use std::io::{BufReader, Cursor, ErrorKind};
use std::path::Path;

use geometry::{DepthImage, GrayImage, Raster};
use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use image::{ColorType, ImageDecoder, ImageFormat, ImageResult};

use super::Rgb;
use super::gray::{first_channel, gray_from_color};
use super::{ImageError, ImageSize};

/// Reads an image as 8-bit gray; color is weighted as OpenCV does, alpha is left out.
///
/// # Errors
/// [`ImageError`]; `UnsupportedDepth` for 16 bits a channel.
pub fn load_gray(path: &Path) -> Result<GrayImage, ImageError> {
    let decoded = decode(path)?;
    let data = match decoded.color {
        ColorType::L8 => decoded.bytes,
        ColorType::La8 => first_channel(&decoded.bytes, 2),
        ColorType::Rgb8 => gray_from_color(&decoded.bytes, 3),
        ColorType::Rgba8 => gray_from_color(&decoded.bytes, 4),
        other => return Err(unsupported(path, other, "8 bits per channel, gray or color")),
    };
    raster(path, decoded.size, data)
}

/// Reads an image as 8-bit color; gray gives three equal channels, alpha is left out.
///
/// # Errors
/// [`ImageError`]; `UnsupportedDepth` for 16 bits a channel.
pub fn load_rgb(path: &Path) -> Result<Rgb, ImageError> {
    let decoded = decode(path)?;
    let (bytes, n_channels) = (&decoded.bytes, usize::from(decoded.color.channel_count()));
    let data = match decoded.color {
        ColorType::L8 | ColorType::La8 => bytes.chunks_exact(n_channels).map(|pixel| [pixel[0]; 3]).collect(),
        ColorType::Rgb8 | ColorType::Rgba8 => {
            bytes.chunks_exact(n_channels).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
        }
        other => return Err(unsupported(path, other, "8 bits per channel, gray or color")),
    };
    raster(path, decoded.size, data)
}

/// Reads a 16-bit gray image unchanged: depth in the dataset's units.
///
/// # Errors
/// [`ImageError`]; `UnsupportedDepth` for anything but 16-bit gray.
pub fn load_depth(path: &Path) -> Result<DepthImage, ImageError> {
    let decoded = decode(path)?;
    if decoded.color != ColorType::L16 {
        return Err(unsupported(path, decoded.color, "16-bit gray (a depth image)"));
    }
    let data = decoded.bytes.chunks_exact(2).map(|pair| u16::from_ne_bytes([pair[0], pair[1]])).collect();
    raster(path, decoded.size, data)
}

/// Width and height from an image's header; no pixel is decoded.
///
/// # Errors
/// [`ImageError`] as far as the header shows it.
pub fn image_size(path: &Path) -> Result<ImageSize, ImageError> {
    let file = fs::File::open(path).map_err(|error| unreadable(path, &error))?;
    let mut reader = BufReader::new(file);
    let head = std::io::BufRead::fill_buf(&mut reader).map_err(|error| unreadable(path, &error))?;
    let format = format_of(path, head)?;
    let size = match format {
        Format::Png => PngDecoder::new(&mut reader).map(|decoder| decoder.dimensions()),
        Format::Jpeg => JpegDecoder::new(&mut reader).map(|decoder| decoder.dimensions()),
    };
    size.map(size_from_dimensions).map_err(|error| corrupt(path, format, &error))
}

/// A broken header must not make the program ask for more memory than there is.
const LONGEST_SIDE_PX: usize = 16_384;

/// The formats that datasets use.
#[derive(Clone, Copy)]
enum Format {
    Png,
    Jpeg,
}

/// Pixels as the decoder gives them, 16-bit values in native byte order.
struct Decoded {
    size: ImageSize,
    color: ColorType,
    bytes: Vec<u8>,
}

fn decode(path: &Path) -> Result<Decoded, ImageError> {
    let bytes = fs::read(path).map_err(|error| unreadable(path, &error))?;
    let format = format_of(path, &bytes)?;
    let cursor = Cursor::new(bytes.as_slice());
    let decoded = match format {
        Format::Png => PngDecoder::new(cursor).and_then(read_pixels),
        Format::Jpeg => JpegDecoder::new(cursor).and_then(read_pixels),
    };
    decoded.map_err(|error| corrupt(path, format, &error))
}

fn read_pixels(decoder: impl ImageDecoder) -> ImageResult<Decoded> {
    let size = size_from_dimensions(decoder.dimensions());
    let color = decoder.color_type();
    if size.width.max(size.height) > LONGEST_SIDE_PX {
        let kind = image::error::LimitErrorKind::DimensionError;
        return Err(image::ImageError::Limits(image::error::LimitError::from_kind(kind)));
    }
    let mut bytes = vec![0; size.width * size.height * usize::from(color.bytes_per_pixel())];
    decoder.read_image(&mut bytes)?;
    Ok(Decoded { size, color, bytes })
}

fn size_from_dimensions((width, height): (u32, u32)) -> ImageSize {
    ImageSize { width: width as usize, height: height as usize }
}

fn raster<T: Copy>(path: &Path, size: ImageSize, data: Vec<T>) -> Result<Raster<T>, ImageError> {
    Raster::from_vec(size.width, size.height, data).ok_or_else(|| ImageError::Corrupt {
        path: path.to_path_buf(),
        format: "decoded",
        reason: format!("the number of pixels does not match {size}"),
    })
}

/// Detects the format from the first bytes, regardless of the file name.
fn format_of(path: &Path, head: &[u8]) -> Result<Format, ImageError> {
    if head.is_empty() {
        return Err(ImageError::Empty { path: path.to_path_buf() });
    }
    match image::guess_format(head) {
        Ok(ImageFormat::Png) => Ok(Format::Png),
        Ok(ImageFormat::Jpeg) => Ok(Format::Jpeg),
        _ => Err(ImageError::NotAnImage { path: path.to_path_buf(), found: describe_head(head) }),
    }
}

/// The first bytes of a file that is not an image, as text where they are text.
fn describe_head(head: &[u8]) -> String {
    const SHOWN_BYTES: usize = 16;
    let head = &head[..head.len().min(SHOWN_BYTES)];
    match std::str::from_utf8(head) {
        Ok(text) if text.chars().all(|c| !c.is_control() || c.is_whitespace()) => {
            format!("the text {text:?}")
        }
        _ => {
            let hex: Vec<String> = head.iter().map(|byte| format!("{byte:02x}")).collect();
            format!("the bytes {}", hex.join(" "))
        }
    }
}

fn unreadable(path: &Path, error: &std::io::Error) -> ImageError {
    match error.kind() {
        ErrorKind::NotFound => ImageError::Missing { path: path.to_path_buf() },
        _ => ImageError::Unreadable { path: path.to_path_buf(), reason: error.to_string() },
    }
}

fn corrupt(path: &Path, format: Format, error: &image::ImageError) -> ImageError {
    let format = match format {
        Format::Png => "PNG",
        Format::Jpeg => "JPEG",
    };
    // The decoder's own words, without the sentence that `image` puts before them.
    let reason = std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string);
    ImageError::Corrupt { path: path.to_path_buf(), format, reason }
}

fn unsupported(path: &Path, color: ColorType, expected: &'static str) -> ImageError {
    let found = match color {
        ColorType::L8 => "8-bit gray".to_string(),
        ColorType::L16 => "16-bit gray".to_string(),
        ColorType::La8 => "8-bit gray with alpha".to_string(),
        ColorType::Rgb8 => "8-bit color".to_string(),
        ColorType::Rgba8 => "8-bit color with alpha".to_string(),
        ColorType::La16 => "16-bit gray with alpha".to_string(),
        ColorType::Rgb16 | ColorType::Rgba16 => "16-bit color".to_string(),
        other => format!("{other:?} pixels"),
    };
    ImageError::UnsupportedDepth { path: path.to_path_buf(), found, expected }
}
