//! Gray image with padded rows, so that vector kernels may read past the last pixel of a row.

use geometry::GrayImage;

/// Bytes that may be read (and, in outputs, written) behind the last pixel of each row.
pub(crate) const SLACK: usize = 64;

/// One level of an image pyramid: `height` rows of `width` pixels, each row padded to `stride` bytes.
///
/// Padding bytes have no defined value and never influence a result.
#[derive(Clone, Debug, Default)]
pub struct Plane {
    width: usize,
    height: usize,
    stride: usize,
    data: Vec<u8>,
}

impl Plane {
    /// Changes the size; old content is lost, memory is kept.
    pub(crate) fn resize(&mut self, width: usize, height: usize) {
        self.width = width;
        self.height = height;
        self.stride = (width + SLACK).next_multiple_of(32);
        self.data.resize(self.stride * height, 0);
    }

    /// Takes over size and pixels of `image`.
    pub(crate) fn copy_from(&mut self, image: &GrayImage) {
        self.resize(image.width, image.height);
        for y in 0..self.height {
            self.row_mut(y)[..image.width].copy_from_slice(image.row(y));
        }
    }

    /// Columns.
    #[inline]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[inline]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Bytes from one row to the next, at least `width + 64`.
    #[inline]
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// All rows with their padding, `stride * height` bytes.
    #[inline]
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// The pixels of row `y`, without padding.
    ///
    /// # Panics
    /// When `y` is outside.
    #[inline]
    pub fn pixels(&self, y: usize) -> &[u8] {
        &self.row(y)[..self.width]
    }

    /// Row `y` with its padding.
    #[inline]
    pub(crate) fn row(&self, y: usize) -> &[u8] {
        &self.data[y * self.stride..(y + 1) * self.stride]
    }

    /// Row `y` with its padding, to be written.
    #[inline]
    pub(crate) fn row_mut(&mut self, y: usize) -> &mut [u8] {
        &mut self.data[y * self.stride..(y + 1) * self.stride]
    }

    /// The value at column `x`, row `y`.
    ///
    /// # Panics
    /// When the place lies behind the data.
    #[inline]
    pub fn at(&self, x: usize, y: usize) -> u8 {
        self.data[y * self.stride + x]
    }

    /// A copy without padding.
    pub fn to_image(&self) -> GrayImage {
        GrayImage::from_fn(self.width, self.height, |x, y| self.at(x, y))
    }
}

/// Mirrors an index at both ends without repeating the end itself (OpenCV's border "reflect 101").
#[inline]
pub(crate) fn reflect(index: isize, len: usize) -> usize {
    let last = len as isize - 1;
    if last <= 0 {
        return 0;
    }
    let mut i = index;
    while i < 0 || i > last {
        i = if i < 0 { -i } else { 2 * last - i };
    }
    i as usize
}
