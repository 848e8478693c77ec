//! Where no features are taken: regions that the user masks, and the border that rectification leaves without a source.

use geometry::GrayImage;

use crate::config::ExtractorConfig;
use crate::detect::EDGE;
use crate::kernels::fast::RADIUS;

/// For each level of the pyramid the pixels of the full image at which corners may lie.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FeatureMask {
    /// 255 where a corner may lie; each of the size of the full image.
    levels: Vec<GrayImage>,
}

impl FeatureMask {
    /// The mask of images in which `filled` is 0 at pixels that show nothing and `wanted` is 0 at pixels that are not to be used;
    /// `None` when there is no such pixel. Corners keep so far from the former that their whole patch is filled, as from the edge of
    /// the image, and so far from the latter that the circle of the corner test lies outside.
    pub fn new(
        config: &ExtractorConfig,
        filled: Option<&GrayImage>,
        wanted: Option<&GrayImage>,
    ) -> Option<Self> {
        let holed = |mask: &&GrayImage| mask.data.contains(&0);
        let (filled, wanted) = (filled.filter(holed), wanted.filter(holed));
        if filled.is_none() && wanted.is_none() {
            return None;
        }
        let level = |l: usize| {
            let scale = f64::from(config.level_ratio()).powi(l as i32);
            let margin = |pixels: usize| (pixels as f64 * scale).ceil() as usize;
            let filled = filled.map(|mask| eroded(mask, margin(EDGE)));
            let wanted = wanted.map(|mask| eroded(mask, margin(RADIUS + 1)));
            both(filled, wanted)
        };
        Some(Self { levels: (0..config.levels).filter_map(level).collect() })
    }

    /// Whether a corner of this octave may lie at this place of the full image.
    pub(crate) fn allows(&self, octave: u8, (x, y): (f32, f32)) -> bool {
        let Some(mask) = self.levels.get(usize::from(octave)) else { return true };
        let (x, y) = ((x + 0.5).max(0.0) as usize, (y + 0.5).max(0.0) as usize);
        mask.get(x, y).is_some_and(|allowed| allowed != 0)
    }

    /// The bytes of all levels, for a fingerprint.
    pub fn bytes(&self) -> impl Iterator<Item = &[u8]> {
        self.levels.iter().map(|level| level.data.as_slice())
    }
}

/// 255 where both are not 0.
fn both(first: Option<GrayImage>, second: Option<GrayImage>) -> Option<GrayImage> {
    match (first, second) {
        (Some(mut first), Some(second)) => {
            for (value, other) in first.data.iter_mut().zip(&second.data) {
                *value = (*value).min(*other);
            }
            Some(first)
        }
        (first, second) => first.or(second),
    }
}

/// 255 where every pixel of `mask` within `margin_px` columns and rows is not 0, 0 elsewhere; what lies outside of the image does
/// not count.
pub(crate) fn eroded(mask: &GrayImage, margin_px: usize) -> GrayImage {
    let GrayImage { width, height, .. } = *mask;
    // Zeros in the rectangle above and left of (x, y).
    let stride = width + 1;
    let mut sums = vec![0u32; stride * (height + 1)];
    for y in 0..height {
        let mut in_row = 0;
        for x in 0..width {
            in_row += u32::from(mask.data[y * width + x] == 0);
            sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + in_row;
        }
    }
    GrayImage::from_fn(width, height, |x, y| {
        let (left, top) = (x.saturating_sub(margin_px), y.saturating_sub(margin_px));
        let (right, bottom) = ((x + margin_px + 1).min(width), (y + margin_px + 1).min(height));
        let at = |x: usize, y: usize| sums[y * stride + x];
        let zeros = at(right, bottom) + at(left, top) - at(left, bottom) - at(right, top);
        if zeros == 0 { 255 } else { 0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Extractor;
    use std::sync::Arc;

    const SIZE: (usize, usize) = (320, 240);

    fn noise() -> GrayImage {
        let cell = |x: usize, y: usize| geometry::mix_seed(3, (x / 6) as u64, (y / 6) as u64) as u8;
        GrayImage::from_fn(SIZE.0, SIZE.1, cell)
    }

    /// 0 in the columns from 100 to 159.
    fn band() -> GrayImage {
        GrayImage::from_fn(SIZE.0, SIZE.1, |x, _| if (100..160).contains(&x) { 0 } else { 7 })
    }

    /// Distances in pixels of the feature's level from the band of all features, by mask.
    fn distances(filled: Option<&GrayImage>, wanted: Option<&GrayImage>) -> Vec<f32> {
        let config = ExtractorConfig { keep: 1500, subpixel: false, ..ExtractorConfig::default() };
        let mask = FeatureMask::new(&config, filled, wanted).map(Arc::new);
        let features = Extractor::new(config.clone()).with_mask(mask).extract(&noise());
        let distance = |x: f32| (100.0 - x).max(x - 159.0);
        let scale = |octave: u8| config.level_ratio().powi(i32::from(octave));
        features.keypoints.iter().map(|k| distance(k.x) / scale(k.octave)).collect()
    }

    #[test]
    fn no_feature_lies_in_a_masked_region_and_others_take_its_place() {
        let band = band();
        let (all, masked) = (distances(None, None), distances(None, Some(&band)));
        assert!(all.iter().any(|&d| d < 0.0), "there are features in the band");
        let nearest = masked.iter().copied().fold(f32::INFINITY, f32::min);
        assert!((3.5..6.0).contains(&nearest), "{nearest}");
        assert!(masked.len() > all.len() * 3 / 4, "{} of {}", masked.len(), all.len());
    }

    #[test]
    fn patches_do_not_reach_into_what_is_not_filled() {
        let band = band();
        let nearest = |filled, wanted| distances(filled, wanted).into_iter().fold(f32::INFINITY, f32::min);
        let border = nearest(Some(&band), None);
        assert!((15.5..20.0).contains(&border), "{border}");
        assert_eq!(nearest(Some(&band), Some(&band)), border);
    }

    #[test]
    fn a_mask_without_holes_is_none() {
        let config = ExtractorConfig::default();
        let full = GrayImage::new(8, 8, 1);
        assert_eq!(FeatureMask::new(&config, Some(&full), Some(&full)), None);
        let mask = FeatureMask::new(&config, None, Some(&GrayImage::new(8, 8, 0))).unwrap();
        assert!(!mask.allows(0, (3.0, 3.0)) && !mask.allows(0, (-0.7, 9.0)));
    }
}
