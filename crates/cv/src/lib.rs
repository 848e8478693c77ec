//! OpenCV in one place: the reference that benchmarks and tests compare with, and the program `dsslam-video`.
//!
//! No other crate links OpenCV, and the program does not depend on this one: neither its build nor its start pays for it.

use geometry::GrayImage;
use opencv::core::{self, KeyPoint, Mat, Ptr, Vector};
use opencv::features2d::{self, ORB};
use opencv::prelude::*;

pub use opencv::Result;

/// OpenCV's ORB with the parameters of the benchmarks: 8 levels of factor 1.2, FAST threshold 20, Harris scores.
pub struct Orb {
    detector: Ptr<ORB>,
}

impl Orb {
    /// A detector that keeps `n_features` per image. OpenCV's own threads are switched off, for the whole process.
    ///
    /// # Errors
    /// What OpenCV refuses.
    pub fn new(n_features: usize) -> Result<Self> {
        core::set_num_threads(1)?;
        let keep = i32::try_from(n_features).unwrap_or(i32::MAX);
        let detector = ORB::create(keep, 1.2, 8, 31, 0, 2, features2d::ORB_ScoreType::HARRIS_SCORE, 31, 20)?;
        Ok(Self { detector })
    }

    /// Detects and describes `image`; returns the number of features. One call of this is the unit U of the benchmarks.
    ///
    /// # Errors
    /// What OpenCV refuses.
    pub fn detect_and_compute(&mut self, image: &GrayImage) -> Result<usize> {
        let mut keypoints = Vector::<KeyPoint>::new();
        let mut descriptors = Mat::default();
        let view = view(image)?;
        self.detector.detect_and_compute(
            &view,
            &core::no_array(),
            &mut keypoints,
            &mut descriptors,
            false,
        )?;
        Ok(keypoints.len())
    }
}

/// A matrix header over the image's own bytes.
fn view(image: &GrayImage) -> Result<opencv::boxed_ref::BoxedRef<'_, Mat>> {
    Mat::new_rows_cols_with_data(i32::try_from(image.height)?, i32::try_from(image.width)?, &image.data)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of random-looking brightness: many corners.
    fn chequered(width: usize, height: usize) -> GrayImage {
        let shade = |x: usize, y: usize| ((x / 9 * 37 + y / 9 * 101) % 251) as u8;
        let data = (0..height).flat_map(|y| (0..width).map(move |x| shade(x, y))).collect();
        GrayImage { width, height, data }
    }

    #[test]
    fn orb_finds_corners_and_none_on_a_flat_image() {
        assert!(Orb::new(500).unwrap().detect_and_compute(&chequered(320, 240)).unwrap() > 100);
        let flat = GrayImage { width: 320, height: 240, data: vec![90; 320 * 240] };
        assert_eq!(Orb::new(500).unwrap().detect_and_compute(&flat).unwrap(), 0);
    }
}
