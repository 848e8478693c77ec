//! The image pyramid: each level reduced from the one before.

use crate::kernels::resize::Resizer;
use crate::plane::Plane;
use crate::scales::ScaleLevels;
use geometry::GrayImage;
use simd::Simd;

/// An image at several scales, the full one first; memory is reused from image to image.
#[derive(Debug, Default)]
pub struct Pyramid {
    levels: Vec<Plane>,
    resizers: Vec<Resizer>,
}

impl Pyramid {
    /// Replaces the content by `image` and its reductions to the sizes of `scales`; no level of an empty image.
    pub(crate) fn build(&mut self, simd: Simd, scales: &ScaleLevels, image: &GrayImage) {
        let n_levels = if image.data.is_empty() { 0 } else { scales.len() };
        self.levels.resize_with(n_levels, Plane::default);
        self.resizers.resize_with(n_levels, Resizer::default);
        let Some(first) = self.levels.first_mut() else { return };
        first.copy_from(image);
        for l in 1..n_levels {
            let (finer, coarser) = self.levels.split_at_mut(l);
            let size = scales.level_size(l, image.width, image.height);
            self.resizers[l].run(simd, &finer[l - 1], size, &mut coarser[0]);
        }
    }

    /// How the pixels of level `l` lie on the full image.
    pub(crate) fn placement(&self, l: usize) -> Placement {
        let ratio = |full: usize, side: usize| full as f32 / side as f32;
        let (full, level) = (&self.levels[0], &self.levels[l]);
        Placement { x: ratio(full.width(), level.width()), y: ratio(full.height(), level.height()) }
    }

    /// The levels, the finest first.
    pub fn levels(&self) -> &[Plane] {
        &self.levels
    }
}

/// Pixels of the full image per pixel of a level, in each direction. Sizes are whole numbers, so that this is not quite the
/// nominal scale: at the coarsest level that would misplace the far edge by more than a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    pub(crate) x: f32,
    pub(crate) y: f32,
}

impl Placement {
    /// The position on the full image of a position on the level: the corners of the images coincide, and whole numbers are
    /// centers of pixels.
    pub(crate) fn to_full(self, x: f32, y: f32) -> (f32, f32) {
        ((x + 0.5) * self.x - 0.5, (y + 0.5) * self.y - 0.5)
    }

    /// The inverse of [`Placement::to_full`].
    pub(crate) fn to_level(self, x: f32, y: f32) -> (f32, f32) {
        ((x + 0.5) / self.x - 0.5, (y + 0.5) / self.y - 0.5)
    }
}
