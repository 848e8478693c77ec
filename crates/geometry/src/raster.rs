//! Images as plain data.

use std::fmt;

/// A grid of values, row after row without padding.
///
/// `data.len() == width * height`; build it with [`Raster::new`] or [`Raster::from_vec`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Raster<T> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values, the upper left one first.
    pub data: Vec<T>,
}

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageSize {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl fmt::Display for ImageSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl ImageSize {
    /// The size after a reduction by `factor`: rounded, at least one pixel.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let side = |pixels: usize| ((pixels as f64 * factor).round() as usize).max(1);
        Self { width: side(self.width), height: side(self.height) }
    }

    /// Width and height of `new` over those of this size: what a camera's pixels are to be multiplied with.
    pub fn factors_to(&self, new: ImageSize) -> [f64; 2] {
        let ratio = |new: usize, old: usize| new as f64 / (old.max(1)) as f64;
        [ratio(new.width, self.width), ratio(new.height, self.height)]
    }
}

/// Brightness, 0 black to 255 white.
pub type GrayImage = Raster<u8>;

/// Depth in units of the sensor; 0 where unknown.
pub type DepthImage = Raster<u16>;

impl DepthImage {
    /// A depth as a depth image holds it: rounded; 0 for one that 16 bits do not hold.
    pub fn value(units: f64) -> u16 {
        let units = units.round();
        if units >= 1.0 && units <= f64::from(u16::MAX) { units as u16 } else { 0 }
    }
}

impl<T: Copy> Raster<T> {
    /// A raster with the same value everywhere.
    pub fn new(width: usize, height: usize, fill: T) -> Self {
        Self { width, height, data: vec![fill; width * height] }
    }

    /// A raster of these values; `None` unless there are `width * height` of them.
    pub fn from_vec(width: usize, height: usize, data: Vec<T>) -> Option<Self> {
        (width.checked_mul(height) == Some(data.len())).then_some(Self { width, height, data })
    }

    /// A raster of the values `f(x, y)`.
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> T) -> Self {
        let mut data = Vec::with_capacity(width * height);
        for y in 0..height {
            data.extend((0..width).map(|x| f(x, y)));
        }
        Self { width, height, data }
    }

    /// Width and height.
    pub fn size(&self) -> ImageSize {
        ImageSize { width: self.width, height: self.height }
    }

    /// The raster with left and right exchanged.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        Self::from_fn(self.width, self.height, |x, y| self.at(self.width - 1 - x, y))
    }

    /// Row `y`.
    ///
    /// # Panics
    /// When `y` is outside.
    #[inline]
    pub fn row(&self, y: usize) -> &[T] {
        &self.data[y * self.width..(y + 1) * self.width]
    }

    /// Row `y`, to be written.
    ///
    /// # Panics
    /// When `y` is outside.
    #[inline]
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.data[y * self.width..(y + 1) * self.width]
    }

    /// The value at column `x`, row `y`.
    ///
    /// # Panics
    /// In debug builds when `x` is outside; always when the place lies behind the data.
    #[inline]
    pub fn at(&self, x: usize, y: usize) -> T {
        debug_assert!(x < self.width);
        self.data[y * self.width + x]
    }

    /// The value at column `x`, row `y`, `None` outside.
    #[inline]
    pub fn get(&self, x: usize, y: usize) -> Option<T> {
        if x < self.width { self.data.get(y * self.width + x).copied() } else { None }
    }
}
