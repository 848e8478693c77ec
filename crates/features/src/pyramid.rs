//! The image pyramid: each level reduced from the one before.

use crate::kernels::Simd;
use crate::kernels::resize::Resizer;
use crate::plane::Plane;
use crate::scales::ScaleLevels;
use geometry::GrayImage;

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

    /// The levels, the finest first.
    #[must_use]
    pub fn levels(&self) -> &[Plane] {
        &self.levels
    }
}
