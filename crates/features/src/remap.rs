//! Redrawing an image through a table that is computed once: rectification of raw images, before anything else looks at them.

use crate::kernels::remap::{FRACTION_BITS, ONE, remap_pixels};
use crate::mask::eroded;
use geometry::{CameraModel, GrayImage, Pinhole, SO3, Vec2};
use rayon::prelude::*;
use simd::Simd;

/// Rows that one task redraws.
const BAND: usize = 16;

/// For each pixel of a new image the place in the source image that it shows, to 1/32 pixel, as in OpenCV's `remap`.
///
/// A pixel without a source (outside of the source's outermost pixel centers, or where the lens model has no ray) is black
/// and not in the [`RemapTable::mask`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RemapTable {
    source: (usize, usize),
    target: (usize, usize),
    /// Position of the upper left one of four source pixels.
    offsets: Vec<u32>,
    /// Weights of left, right, upper and lower pixels in 1/32; all zero for a pixel without a source.
    weights: Vec<[u8; 4]>,
}

impl RemapTable {
    /// The table of a map from pixels of the target to pixels of the source, `None` for no source; sizes are `(width, height)`.
    pub fn new(
        source: (usize, usize),
        target: (usize, usize),
        source_of: impl Fn(&Vec2) -> Option<Vec2> + Sync,
    ) -> Self {
        let width = target.0;
        let row = |y: usize| -> Vec<(u32, [u8; 4])> {
            let place = |x: usize| source_of(&Vec2::new(x as f64, y as f64));
            (0..width).map(|x| place(x).and_then(|place| tap(source, &place)).unwrap_or_default()).collect()
        };
        let rows: Vec<Vec<(u32, [u8; 4])>> = (0..target.1).into_par_iter().map(row).collect();
        let (offsets, weights) = rows.into_iter().flatten().unzip();
        Self { source, target, offsets, weights }
    }

    /// The table that turns the raw images of a camera into those of the pinhole `camera`, which is turned by
    /// `rectified_from_cam` against it; sizes are `(width, height)`.
    pub fn rectifying(
        model: &CameraModel,
        rectified_from_cam: &SO3,
        camera: &Pinhole,
        source: (usize, usize),
        target: (usize, usize),
    ) -> Self {
        let cam_from_rectified = rectified_from_cam.inverse();
        let least_cosine = model.max_angle().cos();
        Self::new(source, target, |pixel| {
            let ray = cam_from_rectified * camera.unproject(pixel);
            // Beyond the largest angle the lens model folds back into the image.
            (ray.z > least_cosine * ray.norm()).then(|| model.project(&ray))
        })
    }

    /// Width and height of the images that are redrawn.
    pub fn source_size(&self) -> (usize, usize) {
        self.source
    }

    /// Width and height of the new images.
    pub fn target_size(&self) -> (usize, usize) {
        self.target
    }

    /// Whether the pixel at column `x`, row `y` of the new image has a source; `false` outside.
    pub fn has_source(&self, x: usize, y: usize) -> bool {
        x < self.target.0 && y < self.target.1 && self.weights[y * self.target.0 + x] != [0; 4]
    }

    /// 255 where every pixel of the new image within `margin_px` columns and rows has a source, 0 elsewhere; what lies outside of the
    /// new image does not count.
    pub fn mask(&self, margin_px: usize) -> GrayImage {
        let (width, height) = self.target;
        let filled = GrayImage::from_fn(width, height, |x, y| if self.has_source(x, y) { 255 } else { 0 });
        if margin_px == 0 { filled } else { eroded(&filled, margin_px) }
    }
}

/// The image redrawn through the table, with bilinear interpolation; `None` when it does not have the size of the table's source.
///
/// Runs on the current rayon pool; the result does not depend on the number of threads.
pub fn remap(image: &GrayImage, table: &RemapTable) -> Option<GrayImage> {
    remap_with(Simd::detect(), image, table)
}

pub(crate) fn remap_with(simd: Simd, image: &GrayImage, table: &RemapTable) -> Option<GrayImage> {
    if (image.width, image.height) != table.source {
        return None;
    }
    let (width, height) = table.target;
    let mut target = GrayImage::new(width, height, 0);
    // In a smaller image there are no four neighbors, and so no pixel has a source.
    if image.width >= 2 && image.height >= 2 && width > 0 {
        let pixels = BAND * width;
        target.data.par_chunks_mut(pixels).enumerate().for_each(|(band, row)| {
            let places = band * pixels..band * pixels + row.len();
            remap_pixels(simd, image, &table.offsets[places.clone()], &table.weights[places], row);
        });
    }
    Some(target)
}

/// The four source pixels around a place and their weights.
fn tap((width, height): (usize, usize), place: &Vec2) -> Option<(u32, [u8; 4])> {
    let along = |position: f64, size: usize| -> Option<(usize, u8)> {
        let steps = (position * f64::from(ONE)).round_ties_even();
        let last = size.checked_sub(2)? as i64;
        // Not a number compares false.
        let inside = steps >= 0.0 && steps <= ((last + 1) * i64::from(ONE)) as f64;
        let first = inside.then_some(steps as i64 >> FRACTION_BITS)?.min(last);
        Some((first as usize, (steps as i64 - (first << FRACTION_BITS)) as u8))
    };
    let ((x, right), (y, lower)) = (along(place.x, width)?, along(place.y, height)?);
    let offset = u32::try_from(y * width + x).ok()?;
    Some((offset, [ONE - right, right, ONE - lower, lower]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn noise(width: usize, height: usize, seed: u64) -> GrayImage {
        GrayImage::from_fn(width, height, |x, y| geometry::mix_seed(seed, x as u64, y as u64) as u8)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn vector_and_scalar_forms_are_equal(
            source in (1usize..70, 1usize..40),
            target in (1usize..90, 1usize..40),
            stretch in 0.2f64..2.0,
            turn in -0.5f64..0.5,
            seed: u64,
        ) {
            let table = RemapTable::new(source, target, |p| {
                Some(Vec2::new(p.x * stretch - turn * p.y, p.y * stretch + turn * p.x - 2.0))
            });
            let image = noise(source.0, source.1, seed);
            prop_assert_eq!(remap_with(Simd::scalar(), &image, &table), remap_with(Simd::detect(), &image, &table));
        }

        #[test]
        fn values_are_bilinear_at_the_rounded_place(x in -1.0f64..6.0, y in -1.0f64..5.0, seed: u64) {
            let image = noise(6, 5, seed);
            let table = RemapTable::new((6, 5), (1, 1), |_| Some(Vec2::new(x, y)));
            let [u, v] = [x, y].map(|c| (c * 32.0).round_ties_even() / 32.0);
            let inside = (0.0..=5.0).contains(&u) && (0.0..=4.0).contains(&v);
            prop_assert_eq!(table.has_source(0, 0), inside);
            let value = f64::from(remap(&image, &table).unwrap().data[0]);
            if inside {
                let at = |x: f64, y: f64| f64::from(image.at((x as usize).min(5), (y as usize).min(4)));
                let (a, b, fx, fy) = (u.floor(), v.floor(), u.fract(), v.fract());
                let upper = at(a, b) * (1.0 - fx) + at(a + 1.0, b) * fx;
                let lower = at(a, b + 1.0) * (1.0 - fx) + at(a + 1.0, b + 1.0) * fx;
                prop_assert_eq!(value, (upper * (1.0 - fy) + lower * fy + 0.5).floor());
            } else {
                prop_assert_eq!(value, 0.0);
            }
        }
    }

    #[test]
    fn whole_pixels_are_copied_up_to_the_border() {
        let image = noise(67, 35, 1);
        let same = RemapTable::new((67, 35), (67, 35), |p| Some(*p));
        assert_eq!(remap(&image, &same).unwrap(), image);
        let moved = RemapTable::new((67, 35), (67, 35), |p| Some(p + Vec2::new(3.0, -2.0)));
        let found = remap(&image, &moved).unwrap();
        for y in 0..35usize {
            for x in 0..67 {
                let source = y.checked_sub(2).and_then(|y| image.get(x + 3, y));
                assert_eq!(found.at(x, y), source.unwrap_or(0));
                assert_eq!(moved.has_source(x, y), source.is_some());
            }
        }
    }

    #[test]
    fn the_mask_keeps_a_margin_from_pixels_without_source() {
        let hole = RemapTable::new((20, 20), (20, 20), |p| (p.x != 7.0 || p.y != 4.0).then_some(*p));
        for margin in [0, 1, 3] {
            let mask = hole.mask(margin);
            for y in 0..20usize {
                for x in 0..20usize {
                    let near = x.abs_diff(7).max(y.abs_diff(4)) <= margin;
                    assert_eq!(mask.at(x, y), if near { 0 } else { 255 });
                }
            }
        }
        assert!(!hole.has_source(20, 0) && !hole.has_source(0, 20));
    }

    #[test]
    fn places_that_are_no_numbers_and_tiny_images_have_no_source() {
        let bad =
            RemapTable::new((5, 5), (3, 1), |p| Some(Vec2::new([f64::NAN, 1e300, -1e-3][p.x as usize], 0.0)));
        assert_eq!([0, 1, 2].map(|x| bad.has_source(x, 0)), [false, false, true], "-0.001 rounds to 0");
        let thin = RemapTable::new((1, 9), (2, 2), |_| Some(Vec2::zeros()));
        assert_eq!(remap(&GrayImage::new(1, 9, 50), &thin).unwrap(), GrayImage::new(2, 2, 0));
        assert!(remap(&GrayImage::new(9, 1, 50), &thin).is_none());
        let empty = RemapTable::new((5, 5), (0, 0), |p| Some(*p));
        assert_eq!(remap(&GrayImage::new(5, 5, 1), &empty).unwrap().data, Vec::<u8>::new());
    }
}
