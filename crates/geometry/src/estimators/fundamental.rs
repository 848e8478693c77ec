//! The epipolar geometry of two images.

use super::pick;
use crate::aliases::{Mat3, Vec2};
use crate::fundamental::{estimate_fundamental, sampson_error_sq};
use crate::ransac::Estimator;

/// Estimates the fundamental matrix by the eight-point algorithm; errors are Sampson distances in square pixels.
#[derive(Clone, Debug)]
pub struct FundamentalEstimator<'a> {
    pixels_a: &'a [Vec2],
    pixels_b: &'a [Vec2],
    threshold_sq: f64,
}

impl<'a> FundamentalEstimator<'a> {
    /// Matches in a sample.
    pub const SAMPLE_SIZE: usize = 8;

    /// Matched undistorted pixels of two images, and the squared threshold in square pixels.
    ///
    /// # Panics
    /// When the lengths differ.
    pub fn new(pixels_a: &'a [Vec2], pixels_b: &'a [Vec2], threshold_sq: f64) -> Self {
        assert_eq!(pixels_a.len(), pixels_b.len(), "pixels come in pairs");
        Self { pixels_a, pixels_b, threshold_sq }
    }
}

impl Estimator for FundamentalEstimator<'_> {
    type Model = Mat3;

    fn n_items(&self) -> usize {
        self.pixels_a.len()
    }

    fn fit(&self, sample: &[usize]) -> Vec<Mat3> {
        let pixels = |all: &[Vec2]| pick(all, sample);
        estimate_fundamental(&pixels(self.pixels_a), &pixels(self.pixels_b), None).into_iter().collect()
    }

    fn error_sq(&self, fundamental: &Mat3, item: usize) -> f64 {
        sampson_error_sq(fundamental, &self.pixels_a[item], &self.pixels_b[item])
    }

    fn threshold_sq(&self) -> f64 {
        self.threshold_sq
    }

    fn refit(&self, _: &Mat3, inliers: &[usize], weights: &[f64]) -> Option<Mat3> {
        let (a, b) = (pick(self.pixels_a, inliers), pick(self.pixels_b, inliers));
        estimate_fundamental(&a, &b, Some(&pick(weights, inliers)))
    }
}
