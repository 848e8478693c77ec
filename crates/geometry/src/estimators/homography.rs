//! The homography between two images of a plane.

use super::pick;
use crate::aliases::Vec2;
use crate::homography::{Homography, estimate_homography, homography_of_four};
use crate::ransac::Estimator;

/// Estimates a homography from samples of four, and from all inliers by the direct linear transform.
///
/// The error of a match is the larger of its two squared transfer errors in square pixels: a match must fit in both images.
#[derive(Clone, Debug)]
pub struct HomographyEstimator<'a> {
    pixels_a: &'a [Vec2],
    pixels_b: &'a [Vec2],
    threshold_sq: f64,
}

impl<'a> HomographyEstimator<'a> {
    /// Matches in a sample.
    pub const SAMPLE_SIZE: usize = 4;

    /// Matched undistorted pixels of two images, and the squared threshold in square pixels.
    ///
    /// # Panics
    /// When the lengths differ.
    pub fn new(pixels_a: &'a [Vec2], pixels_b: &'a [Vec2], threshold_sq: f64) -> Self {
        assert_eq!(pixels_a.len(), pixels_b.len(), "pixels come in pairs");
        Self { pixels_a, pixels_b, threshold_sq }
    }
}

impl Estimator for HomographyEstimator<'_> {
    type Model = Homography;

    fn n_items(&self) -> usize {
        self.pixels_a.len()
    }

    fn fit(&self, sample: &[usize]) -> Vec<Homography> {
        let &[a, b, c, d] = sample else { return Vec::new() };
        let pixels = |all: &[Vec2]| [a, b, c, d].map(|i| all[i]);
        homography_of_four(&pixels(self.pixels_a), &pixels(self.pixels_b)).into_iter().collect()
    }

    fn error_sq(&self, homography: &Homography, item: usize) -> f64 {
        let [in_b, in_a] = homography.transfer_errors_sq(&self.pixels_a[item], &self.pixels_b[item]);
        in_b.max(in_a)
    }

    fn threshold_sq(&self) -> f64 {
        self.threshold_sq
    }

    fn refit(&self, _: &Homography, inliers: &[usize], weights: &[f64]) -> Option<Homography> {
        let (a, b) = (pick(self.pixels_a, inliers), pick(self.pixels_b, inliers));
        estimate_homography(&a, &b, Some(&pick(weights, inliers)))
    }
}
