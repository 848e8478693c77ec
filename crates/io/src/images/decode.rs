//! Decoding of image files. The bytes are read first, so that each way of being broken has its own error.

use std::fs::File;
use std::io::{BufReader, Cursor, ErrorKind};
use std::path::Path;

use geometry::{GrayImage, Raster};
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageFormat, ImageReader, ImageResult, Limits};

use super::Rgb;
use super::gray::{first_channel, gray_from_color};
use super::jpeg;
use super::{ImageError, ImageSize};
use crate::file::{check_regular, read_bytes};

const EXPECTED: &str = "8 or 16 bits per channel, gray or color";

/// A broken header must not make the program ask for more memory than there is: neither by its sides nor by its pixels.
const LONGEST_SIDE_PX: u32 = 16_384;
const MOST_PIXELS: usize = 64 << 20;
const MOST_BYTES: usize = 256 << 20;

/// Reads an image as 8-bit gray; color is weighted as OpenCV does, alpha is left out, 16 bits are reduced to 8 (12 to 8 where no
/// pixel needs more).
///
/// # Errors
/// [`ImageError`].
pub fn load_gray(path: &Path) -> Result<GrayImage, ImageError> {
    let decoded = decode(path)?.in_8_bits(path)?;
    let data = match decoded.color {
        ColorType::L8 => decoded.bytes,
        ColorType::La8 => first_channel(&decoded.bytes, 2),
        ColorType::Rgb8 => gray_from_color(&decoded.bytes, 3),
        _ => gray_from_color(&decoded.bytes, 4),
    };
    raster(path, decoded.size, data)
}

/// Reads an image as 8-bit color; gray gives three equal channels, alpha is left out.
///
/// # Errors
/// [`ImageError`].
pub fn load_rgb(path: &Path) -> Result<Rgb, ImageError> {
    let decoded = decode(path)?.in_8_bits(path)?;
    let (bytes, n_channels) = (&decoded.bytes, usize::from(decoded.color.channel_count()));
    let data = match decoded.color {
        ColorType::L8 | ColorType::La8 => bytes.chunks_exact(n_channels).map(|pixel| [pixel[0]; 3]).collect(),
        _ => bytes.chunks_exact(n_channels).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect(),
    };
    raster(path, decoded.size, data)
}

/// Width and height from an image's header; no pixel is decoded.
///
/// # Errors
/// [`ImageError`] as far as the header shows it.
pub fn image_size(path: &Path) -> Result<ImageSize, ImageError> {
    kind(path).map(|(size, _)| size)
}

/// Size and kind of pixel from an image's header.
pub(super) fn kind(path: &Path) -> Result<(ImageSize, ColorType), ImageError> {
    check_regular(path).map_err(|error| unreadable(path, &error))?;
    let file = File::open(path).map_err(|error| unreadable(path, &error))?;
    let mut reader = BufReader::new(file);
    let head = std::io::BufRead::fill_buf(&mut reader).map_err(|error| unreadable(path, &error))?;
    let format = format_of(path, head)?;
    let decoder = decoder(reader, format).map_err(|error| corrupt(path, format, &error))?;
    Ok((size_from_dimensions(decoder.dimensions()), decoder.color_type()))
}

/// How a file says that it is to be shown, where not as it is stored.
pub(super) fn orientation(path: &Path) -> Option<&'static str> {
    let bytes = read_bytes(path).ok()?;
    let mut decoder = decoder(Cursor::new(bytes.as_slice()), format_of(path, &bytes).ok()?).ok()?;
    Some(match decoder.orientation().ok()? {
        Orientation::NoTransforms => return None,
        Orientation::Rotate90 => "turned by 90 degrees",
        Orientation::Rotate180 => "turned by 180 degrees",
        Orientation::Rotate270 => "turned by 270 degrees",
        _ => "mirrored",
    })
}

/// Pixels as the decoder gives them, 16-bit values in native byte order.
pub(super) struct Decoded {
    pub(super) size: ImageSize,
    pub(super) color: ColorType,
    pub(super) bytes: Vec<u8>,
}

impl Decoded {
    /// The same with 8 bits a channel.
    fn in_8_bits(self, path: &Path) -> Result<Self, ImageError> {
        let color = match self.color {
            ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => return Ok(self),
            ColorType::L16 => ColorType::L8,
            ColorType::La16 => ColorType::La8,
            ColorType::Rgb16 => ColorType::Rgb8,
            ColorType::Rgba16 => ColorType::Rgba8,
            other => return Err(unsupported(path, other, EXPECTED)),
        };
        /// Cameras of 12 bits write their values as they are.
        const OF_12_BITS: u16 = 1 << 12;
        let values = self.bytes.as_chunks::<2>().0.iter().map(|&pair| u16::from_ne_bytes(pair));
        let is_12 = values.clone().all(|value| value < OF_12_BITS);
        let shift = if is_12 { 4 } else { 8 };
        let bytes = values.map(|value| (value >> shift) as u8).collect();
        Ok(Self { color, bytes, ..self })
    }
}

pub(super) fn decode(path: &Path) -> Result<Decoded, ImageError> {
    decode_bytes(path, &read(path)?)
}

/// The bytes of an image file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, ImageError> {
    read_bytes(path).map_err(|error| unreadable(path, &error))
}

pub(super) fn decode_bytes(path: &Path, bytes: &[u8]) -> Result<Decoded, ImageError> {
    let format = format_of(path, bytes)?;
    if format == ImageFormat::Jpeg && !jpeg::is_complete(bytes) {
        return Err(ImageError::Corrupt {
            path: path.to_path_buf(),
            format: name(format),
            reason: "it ends before its end marker".to_owned(),
        });
    }
    let decoded = decoder(Cursor::new(bytes), format).and_then(read_pixels);
    decoded.map_err(|error| corrupt(path, format, &error))
}

/// The decoder of a format, with its limits.
fn decoder<'a, R: std::io::BufRead + std::io::Seek + 'a>(
    reader: R,
    format: ImageFormat,
) -> ImageResult<impl ImageDecoder + 'a> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(LONGEST_SIDE_PX);
    limits.max_image_height = Some(LONGEST_SIDE_PX);
    limits.max_alloc = Some(MOST_BYTES as u64);
    let mut reader = ImageReader::with_format(reader, format);
    reader.limits(limits);
    reader.into_decoder()
}

fn read_pixels(decoder: impl ImageDecoder) -> ImageResult<Decoded> {
    let size = size_from_dimensions(decoder.dimensions());
    let color = decoder.color_type();
    let n_pixels = size.width.saturating_mul(size.height);
    let n_bytes = n_pixels.saturating_mul(usize::from(color.bytes_per_pixel()));
    if n_pixels > MOST_PIXELS || n_bytes > MOST_BYTES {
        let kind = image::error::LimitErrorKind::DimensionError;
        return Err(image::ImageError::Limits(image::error::LimitError::from_kind(kind)));
    }
    let mut bytes = vec![0; n_bytes];
    decoder.read_image(&mut bytes)?;
    Ok(Decoded { size, color, bytes })
}

fn size_from_dimensions((width, height): (u32, u32)) -> ImageSize {
    ImageSize { width: width as usize, height: height as usize }
}

pub(super) fn raster<T: Copy>(path: &Path, size: ImageSize, data: Vec<T>) -> Result<Raster<T>, ImageError> {
    Raster::from_vec(size.width, size.height, data).ok_or_else(|| ImageError::Corrupt {
        path: path.to_path_buf(),
        format: "decoded",
        reason: format!("the number of pixels does not match {size}"),
    })
}

/// Detects the format from the first bytes, regardless of the file name.
fn format_of(path: &Path, head: &[u8]) -> Result<ImageFormat, ImageError> {
    if head.is_empty() {
        return Err(ImageError::Empty { path: path.to_path_buf() });
    }
    match image::guess_format(head) {
        Ok(format) if !name(format).is_empty() => Ok(format),
        _ => Err(ImageError::NotAnImage { path: path.to_path_buf(), found: describe_head(head) }),
    }
}

/// The formats that datasets use; empty for others.
fn name(format: ImageFormat) -> &'static str {
    match format {
        ImageFormat::Png => "PNG",
        ImageFormat::Jpeg => "JPEG",
        ImageFormat::Pnm => "PGM or PPM",
        ImageFormat::Bmp => "BMP",
        ImageFormat::Tiff => "TIFF",
        ImageFormat::WebP => "WebP",
        _ => "",
    }
}

/// How files begin that people take for images that are read, with what they are.
const OTHERS: [(usize, &[u8], &str); 8] = [
    (0, b"version https://git-lfs", "a Git LFS pointer (git lfs pull fetches the file)"),
    (0, b"<!DOCTYPE", "a web page (a download that failed?)"),
    (0, b"<html", "a web page (a download that failed?)"),
    (0, b"\x76\x2f\x31\x01", "OpenEXR, which is not read (16-bit PNG and float TIFF are)"),
    (0, b"GIF8", "GIF, which is not read"),
    (0, b"\xff\x0a", "JPEG XL, which is not read"),
    (4, b"JXL ", "JPEG XL, which is not read"),
    (4, b"ftyp", "HEIC, AVIF or a video, which are not read as images"),
];

/// The first bytes of a file that is not an image: what they stand for where that is known, as text where they are text.
fn describe_head(head: &[u8]) -> String {
    const SHOWN_BYTES: usize = 16;
    let known =
        OTHERS.iter().find(|(at, mark, _)| head.get(*at..).is_some_and(|rest| rest.starts_with(mark)));
    if let Some((_, _, what)) = known {
        return (*what).to_owned();
    }
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

fn corrupt(path: &Path, format: ImageFormat, error: &image::ImageError) -> ImageError {
    let format = name(format);
    // The decoder's own words, without the sentence that `image` puts before them.
    let reason = std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string);
    ImageError::Corrupt { path: path.to_path_buf(), format, reason }
}

pub(super) fn unsupported(path: &Path, color: ColorType, expected: &'static str) -> ImageError {
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
