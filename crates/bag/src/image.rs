//! Image messages as images.

use geometry::{DepthImage, GrayImage, Raster};
use io::brightness;

use crate::messages::{PackedImage, RawImage};
use crate::topic::Kind;
use crate::wire::{Decoded, Wire};

/// Longest side of an image; a longer one is a broken one.
const LONGEST_SIDE: u32 = 16_384;

/// Units of integer depth: millimeters, as REP 118 says.
const UNITS_PER_METER: f64 = 1000.0;

/// An image of a message.
#[derive(Clone, Debug, PartialEq)]
pub enum Picture {
    /// Brightness.
    Gray(GrayImage),
    /// Depth in meters; 0 where it is unknown.
    Depth(Raster<f32>),
}

impl Picture {
    /// The image of a message; `wants_depth` tells how 16-bit values are meant.
    pub(crate) fn of(bytes: &[u8], wire: Wire, kind: Kind, wants_depth: bool) -> Decoded<Self> {
        match kind {
            Kind::Image => raw(&RawImage::of(bytes, wire)?, wants_depth),
            _ => packed(&PackedImage::of(bytes, wire)?, wants_depth),
        }
    }

    /// Brightness; `None` for depth.
    pub fn into_gray(self) -> Option<GrayImage> {
        match self {
            Picture::Gray(image) => Some(image),
            Picture::Depth(_) => None,
        }
    }

    /// Depth in these units; `None` for an image. What does not fit 16 bits is unknown.
    pub fn into_depth(self, units_per_meter: f64) -> Option<DepthImage> {
        let Picture::Depth(meters) = self else { return None };
        let unit = |meters: f32| DepthImage::value(f64::from(meters) * units_per_meter);
        let Raster { width, height, data } = meters;
        Some(DepthImage { width, height, data: data.into_iter().map(unit).collect() })
    }
}

fn raw(image: &RawImage<'_>, wants_depth: bool) -> Decoded<Picture> {
    let encoding = image.encoding.as_str();
    match (encoding, wants_depth) {
        ("mono8" | "8UC1", false) => gray(image, 1, |p| p[0]),
        ("rgb8", false) => gray(image, 3, |p| brightness(p[0], p[1], p[2])),
        ("bgr8" | "8UC3", false) => gray(image, 3, |p| brightness(p[2], p[1], p[0])),
        ("rgba8", false) => gray(image, 4, |p| brightness(p[0], p[1], p[2])),
        ("bgra8" | "8UC4", false) => gray(image, 4, |p| brightness(p[2], p[1], p[0])),
        // The upper 8 of 16 bits.
        ("mono16" | "16UC1", false) if image.is_big_endian => gray(image, 2, |p| p[0]),
        ("mono16" | "16UC1", false) => gray(image, 2, |p| p[1]),
        ("bayer_rggb8", false) => bayer(image, [0, 0]),
        ("bayer_grbg8", false) => bayer(image, [1, 0]),
        ("bayer_gbrg8", false) => bayer(image, [0, 1]),
        ("bayer_bggr8", false) => bayer(image, [1, 1]),
        ("16UC1" | "mono16", true) => {
            let big = image.is_big_endian;
            let value = |p: &[u8]| {
                if big { u16::from_be_bytes([p[0], p[1]]) } else { u16::from_le_bytes([p[0], p[1]]) }
            };
            depth(image, 2, |p| (f64::from(value(p)) / UNITS_PER_METER) as f32)
        }
        ("32FC1", true) => {
            let big = image.is_big_endian;
            depth(image, 4, |p| {
                let bytes = [p[0], p[1], p[2], p[3]];
                known(if big { f32::from_be_bytes(bytes) } else { f32::from_le_bytes(bytes) })
            })
        }
        (_, true) => Err(format!("depth with encoding {encoding}, expected 16UC1 or 32FC1")),
        (_, false) => Err(format!(
            "an image with encoding {encoding}, expected mono8, mono16, rgb8, bgr8, rgba8, bgra8 or one of bayer_*8"
        )),
    }
}

/// A depth, 0 for what is not one.
fn known(meters: f32) -> f32 {
    if meters.is_finite() && meters > 0.0 { meters } else { 0.0 }
}

/// The rows of an image whose pixels have this many bytes.
fn rows<'a>(image: &RawImage<'a>, pixel: usize) -> Decoded<(usize, usize, impl Iterator<Item = &'a [u8]>)> {
    let RawImage { height, width, step, data, .. } = image;
    let (height, width, step) = (*height as usize, *width as usize, *step as usize);
    if *data == [] as [u8; 0] || width == 0 || height == 0 || image.width.max(image.height) > LONGEST_SIDE {
        return Err(format!("an image of {width} x {height} pixels and {} bytes", data.len()));
    }
    let row = width * pixel;
    if step < row || data.len() < step * (height - 1) + row {
        return Err(format!(
            "an image of {width} x {height} pixels with rows of {step} bytes, which needs at least {} bytes, and has {}",
            step.max(row) * (height - 1) + row,
            data.len()
        ));
    }
    Ok((width, height, data.chunks(step).take(height).map(move |bytes| &bytes[..row])))
}

fn raster<T: Copy>(image: &RawImage<'_>, pixel: usize, value: impl Fn(&[u8]) -> T) -> Decoded<Raster<T>> {
    let (width, height, rows) = rows(image, pixel)?;
    let mut data = Vec::with_capacity(width * height);
    for row in rows {
        data.extend(row.chunks_exact(pixel).map(&value));
    }
    Ok(Raster { width, height, data })
}

fn gray(image: &RawImage<'_>, pixel: usize, value: impl Fn(&[u8]) -> u8) -> Decoded<Picture> {
    raster(image, pixel, value).map(Picture::Gray)
}

fn depth(image: &RawImage<'_>, pixel: usize, value: impl Fn(&[u8]) -> f32) -> Decoded<Picture> {
    raster(image, pixel, value).map(Picture::Depth)
}

/// A color mosaic whose first red pixel lies at `red`: the missing colors are the means of the neighbors that have them.
fn bayer(image: &RawImage<'_>, red: [usize; 2]) -> Decoded<Picture> {
    let mosaic = raster(image, 1, |p| p[0])?;
    let (width, height) = (mosaic.width, mosaic.height);
    // The color that a pixel has: red, green, blue.
    let kind = |x: usize, y: usize| (x + red[0]) % 2 + (y + red[1]) % 2;
    let color = |color: usize, x: usize, y: usize| {
        if kind(x, y) == color {
            return mosaic.at(x, y);
        }
        let (mut sum, mut n) = (0_u32, 0_u32);
        for near_y in y.saturating_sub(1)..(y + 2).min(height) {
            for near_x in x.saturating_sub(1)..(x + 2).min(width) {
                if kind(near_x, near_y) == color {
                    sum += u32::from(mosaic.at(near_x, near_y));
                    n += 1;
                }
            }
        }
        ((sum + n / 2) / n.max(1)) as u8
    };
    let mut data = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            data.push(brightness(color(0, x, y), color(1, x, y), color(2, x, y)));
        }
    }
    Ok(Picture::Gray(GrayImage { width, height, data }))
}

/// What `compressed_depth_image_transport` writes before its PNG: a format, and two numbers of the quantization of floats.
const DEPTH_HEAD: usize = 12;

fn packed(image: &PackedImage<'_>, wants_depth: bool) -> Decoded<Picture> {
    let is_depth = image.format.contains("compressedDepth");
    let bytes = if is_depth { image.data.get(DEPTH_HEAD..).unwrap_or_default() } else { image.data };
    let reader = image::ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format();
    let mut reader = reader.map_err(|error| error.to_string())?;
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(LONGEST_SIDE), Some(LONGEST_SIDE));
    reader.limits(limits);
    let decoded =
        reader.decode().map_err(|error| format!("an image with format {:?}: {error}", image.format))?;
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    if !wants_depth {
        let data = match decoded {
            image::DynamicImage::ImageLuma8(gray) => gray.into_raw(),
            image::DynamicImage::ImageLuma16(gray) => {
                gray.into_raw().iter().map(|v| (v >> 8) as u8).collect()
            }
            other => other.to_rgb8().pixels().map(|p| brightness(p.0[0], p.0[1], p.0[2])).collect(),
        };
        return Ok(Picture::Gray(GrayImage { width, height, data }));
    }
    let image::DynamicImage::ImageLuma16(values) = decoded else {
        return Err(format!("depth with format {:?}, expected a 16-bit PNG", image.format));
    };
    let values = values.into_raw();
    let meters: Vec<f32> = if is_depth && image.format.starts_with("32FC1") {
        let number = |at: usize| f32::from_le_bytes([0, 1, 2, 3].map(|i| image.data[at + i]));
        // Inverse depth: value = a / depth + b.
        let (a, b) = (number(4), number(8));
        values.iter().map(|v| if *v == 0 { 0.0 } else { known(a / (f32::from(*v) - b)) }).collect()
    } else {
        values.iter().map(|v| (f64::from(*v) / UNITS_PER_METER) as f32).collect()
    };
    Ok(Picture::Depth(Raster { width, height, data: meters }))
}
