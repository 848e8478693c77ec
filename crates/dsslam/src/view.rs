//! Images as they are pushed: borrowed, with rows of any length in memory.

use geometry::{DepthImage, GrayImage, Raster};
use io::{ImageSize, brightness};

use crate::error::FrameProblem;

/// How the pixels of an [`ImageView`] lie in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PixelFormat {
    /// One byte of brightness.
    Gray8,
    /// Three bytes, red first.
    Rgb8,
    /// Three bytes, blue first, as OpenCV has them.
    Bgr8,
}

impl PixelFormat {
    fn bytes(self) -> usize {
        match self {
            PixelFormat::Gray8 => 1,
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => 3,
        }
    }
}

/// A borrowed image of 8 bits a channel. Color is weighted as OpenCV does, so that the same picture gives the same bits as its file.
///
/// ```
/// use dsslam::ImageView;
///
/// // Two rows of three pixels, each row padded to four bytes.
/// let bytes = [10, 20, 30, 0, 40, 50, 60, 0];
/// let view = ImageView::gray(&bytes, 3, 2).with_stride(4);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ImageView<'a> {
    data: &'a [u8],
    size: ImageSize,
    /// Bytes from the beginning of a row to that of the next.
    stride: usize,
    format: PixelFormat,
}

impl<'a> ImageView<'a> {
    /// An image whose rows follow each other without a gap.
    pub fn new(data: &'a [u8], width: usize, height: usize, format: PixelFormat) -> Self {
        let stride = width * format.bytes();
        Self { data, size: ImageSize { width, height }, stride, format }
    }

    /// One byte a pixel.
    pub fn gray(data: &'a [u8], width: usize, height: usize) -> Self {
        Self::new(data, width, height, PixelFormat::Gray8)
    }

    /// Three bytes a pixel, red first.
    pub fn rgb(data: &'a [u8], width: usize, height: usize) -> Self {
        Self::new(data, width, height, PixelFormat::Rgb8)
    }

    /// Three bytes a pixel, blue first.
    pub fn bgr(data: &'a [u8], width: usize, height: usize) -> Self {
        Self::new(data, width, height, PixelFormat::Bgr8)
    }

    /// The same with rows that begin `stride` bytes after one another.
    #[must_use]
    pub fn with_stride(self, stride: usize) -> Self {
        Self { stride, ..self }
    }

    /// A copy of the brightness of each pixel.
    ///
    /// # Errors
    /// Fewer bytes than the size asks for.
    pub fn to_image(self) -> Result<GrayImage, FrameProblem> {
        self.to_gray("given", self.size)
    }

    /// The brightness of each pixel; `name` is what messages call the image.
    pub(crate) fn to_gray(self, name: &'static str, expected: ImageSize) -> Result<GrayImage, FrameProblem> {
        let (size, pixel) = (self.size, self.format.bytes());
        check_size(name, size, expected)?;
        let rows = rows(self.data, size.height, self.stride, size.width * pixel, name)?;
        let mut data = Vec::with_capacity(size.width * size.height);
        for row in rows {
            match self.format {
                PixelFormat::Gray8 => data.extend_from_slice(row),
                PixelFormat::Rgb8 => data.extend(row.chunks_exact(3).map(|p| brightness(p[0], p[1], p[2]))),
                PixelFormat::Bgr8 => data.extend(row.chunks_exact(3).map(|p| brightness(p[2], p[1], p[0]))),
            }
        }
        Ok(GrayImage { width: size.width, height: size.height, data })
    }
}

impl<'a> From<&'a GrayImage> for ImageView<'a> {
    fn from(image: &'a GrayImage) -> Self {
        Self::gray(&image.data, image.width, image.height)
    }
}

impl<'a> From<&'a Raster<[u8; 3]>> for ImageView<'a> {
    fn from(image: &'a Raster<[u8; 3]>) -> Self {
        Self::rgb(image.data.as_flattened(), image.width, image.height)
    }
}

/// A borrowed depth image, registered to its gray image. What is 0, negative, infinite, not a number or too far for 16 bits is
/// unknown.
#[derive(Clone, Copy, Debug)]
pub struct DepthView<'a> {
    data: Depths<'a>,
    size: ImageSize,
    /// Values from the beginning of a row to that of the next.
    stride: usize,
}

#[derive(Clone, Copy, Debug)]
enum Depths<'a> {
    /// With units per meter; `None`: those of the configuration.
    Units(&'a [u16], Option<f64>),
    Meters(&'a [f32]),
}

impl<'a> DepthView<'a> {
    /// 16-bit depth in the units of the configuration's `camera.depth_units_per_metre`.
    pub fn u16(data: &'a [u16], width: usize, height: usize) -> Self {
        Self { data: Depths::Units(data, None), size: ImageSize { width, height }, stride: width }
    }

    /// 16-bit depth in units of its own, such as 1000 per meter for millimeters.
    pub fn u16_with_units(data: &'a [u16], width: usize, height: usize, units_per_meter: f64) -> Self {
        let data = Depths::Units(data, Some(units_per_meter));
        Self { data, size: ImageSize { width, height }, stride: width }
    }

    /// Depth in meters. It is rounded to the units of the configuration, which also bound it: with 5000 per meter to 13.1 m, with
    /// `camera.depth_units_per_metre=1000` to 65.5 m.
    pub fn meters(data: &'a [f32], width: usize, height: usize) -> Self {
        Self { data: Depths::Meters(data), size: ImageSize { width, height }, stride: width }
    }

    /// The same with rows that begin `stride` values after one another.
    #[must_use]
    pub fn with_stride(self, stride: usize) -> Self {
        Self { stride, ..self }
    }

    /// The depth image in these units.
    pub(crate) fn to_depth(
        self,
        expected: ImageSize,
        units_per_meter: f64,
    ) -> Result<DepthImage, FrameProblem> {
        const NAME: &str = "depth";
        check_size(NAME, self.size, expected)?;
        let ImageSize { width, height } = self.size;
        let data = match self.data {
            Depths::Units(data, units) => {
                let factor = units.map_or(1.0, |units| units_per_meter / units);
                let rows = rows(data, height, self.stride, width, NAME)?;
                rows.flatten().map(|&v| DepthImage::value(f64::from(v) * factor)).collect()
            }
            Depths::Meters(data) => {
                let rows = rows(data, height, self.stride, width, NAME)?;
                rows.flatten().map(|&v| DepthImage::value(f64::from(v) * units_per_meter)).collect()
            }
        };
        Ok(DepthImage { width, height, data })
    }
}

impl<'a> From<&'a DepthImage> for DepthView<'a> {
    fn from(image: &'a DepthImage) -> Self {
        Self::u16(&image.data, image.width, image.height)
    }
}

fn check_size(image: &'static str, found: ImageSize, expected: ImageSize) -> Result<(), FrameProblem> {
    if found == expected { Ok(()) } else { Err(FrameProblem::Size { image, found, expected }) }
}

/// The first `len` values of each row.
fn rows<'a, T>(
    data: &'a [T],
    height: usize,
    stride: usize,
    len: usize,
    image: &'static str,
) -> Result<impl Iterator<Item = &'a [T]>, FrameProblem> {
    let expected = height.saturating_sub(1).saturating_mul(stride).saturating_add(len);
    if stride < len || data.len() < expected {
        let expected = expected.max(height.saturating_mul(len));
        return Err(FrameProblem::Short { image, found: data.len(), expected, stride });
    }
    Ok(data.chunks(stride.max(1)).take(height).map(move |row| &row[..len]))
}

/// The images of one frame.
///
/// ```
/// use dsslam::{DepthView, ImageView, Images};
///
/// let (gray, depth, mask) = ([0; 6], [0; 6], [255; 6]);
/// let image = ImageView::gray(&gray, 3, 2);
/// let one = Images::from(image);
/// let pair = Images::from((image, image));
/// let rgbd = Images::from((image, DepthView::u16(&depth, 3, 2)));
/// let masked = pair.with_mask(ImageView::gray(&mask, 3, 2));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Images<'a> {
    pub(crate) left: ImageView<'a>,
    pub(crate) right: Option<ImageView<'a>>,
    pub(crate) depth: Option<DepthView<'a>>,
    pub(crate) mask: Option<ImageView<'a>>,
}

impl<'a> Images<'a> {
    /// The same with the image of the right camera.
    #[must_use]
    pub fn with_right(self, right: impl Into<ImageView<'a>>) -> Self {
        Self { right: Some(right.into()), ..self }
    }

    /// The same with a registered depth image.
    #[must_use]
    pub fn with_depth(self, depth: impl Into<DepthView<'a>>) -> Self {
        Self { depth: Some(depth.into()), ..self }
    }

    /// The same with a mask of the size of the left image: no feature is taken where it is 0. It takes the place of `input.mask` for
    /// this frame.
    #[must_use]
    pub fn with_mask(self, mask: impl Into<ImageView<'a>>) -> Self {
        Self { mask: Some(mask.into()), ..self }
    }
}

/// One image.
impl<'a> From<ImageView<'a>> for Images<'a> {
    fn from(left: ImageView<'a>) -> Self {
        Self { left, right: None, depth: None, mask: None }
    }
}

/// One image.
impl<'a> From<&'a GrayImage> for Images<'a> {
    fn from(image: &'a GrayImage) -> Self {
        ImageView::from(image).into()
    }
}

/// Left and right image.
impl<'a> From<(ImageView<'a>, ImageView<'a>)> for Images<'a> {
    fn from((left, right): (ImageView<'a>, ImageView<'a>)) -> Self {
        Self::from(left).with_right(right)
    }
}

/// Left and right image.
impl<'a> From<(&'a GrayImage, &'a GrayImage)> for Images<'a> {
    fn from((left, right): (&'a GrayImage, &'a GrayImage)) -> Self {
        Self::from((ImageView::from(left), ImageView::from(right)))
    }
}

/// Image and depth.
impl<'a> From<(ImageView<'a>, DepthView<'a>)> for Images<'a> {
    fn from((image, depth): (ImageView<'a>, DepthView<'a>)) -> Self {
        Self::from(image).with_depth(depth)
    }
}

/// Image and depth.
impl<'a> From<(&'a GrayImage, &'a DepthImage)> for Images<'a> {
    fn from((image, depth): (&'a GrayImage, &'a DepthImage)) -> Self {
        Self::from((ImageView::from(image), DepthView::from(depth)))
    }
}
