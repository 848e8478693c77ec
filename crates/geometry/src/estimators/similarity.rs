//! Two cameras that see the same points, each with its own idea of where they are: the geometry of a loop closure.

use super::pick;
use crate::aliases::{Vec2, Vec3};
use crate::pinhole::Pinhole;
use crate::ransac::Estimator;
use crate::sim3::Sim3;
use crate::umeyama::align_umeyama;

/// What one camera knows of the matched points; one entry per match in each slice.
#[derive(Clone, Copy, Debug)]
pub struct SightedPoints<'a> {
    /// The camera.
    pub camera: Pinhole,
    /// Points in coordinates of this camera.
    pub points_cam: &'a [Vec3],
    /// Undistorted pixels.
    pub pixels: &'a [Vec2],
    /// Squared thresholds in square pixels.
    pub thresholds_sq: &'a [f64],
}

impl SightedPoints<'_> {
    fn error_sq(&self, point_cam: &Vec3, item: usize) -> f64 {
        let error_sq =
            (self.camera.project(point_cam) - self.pixels[item]).norm_squared() / self.thresholds_sq[item];
        if point_cam.z > 0.0 && error_sq.is_finite() { error_sq } else { f64::INFINITY }
    }
}

/// Estimates `a_from_b` by Umeyama's method.
///
/// The error of a match is the larger of the two squared reprojection errors, each over its squared threshold: a match must
/// fit in both images.
#[derive(Clone, Debug)]
pub struct SimilarityEstimator<'a> {
    a: SightedPoints<'a>,
    b: SightedPoints<'a>,
    with_scale: bool,
}

impl<'a> SimilarityEstimator<'a> {
    /// Matches in a sample.
    pub const SAMPLE_SIZE: usize = 3;

    /// The same matches seen by two cameras, and whether the scale between them is free.
    ///
    /// # Panics
    /// When the lengths differ.
    pub fn new(a: SightedPoints<'a>, b: SightedPoints<'a>, with_scale: bool) -> Self {
        let n = a.points_cam.len();
        let lengths = [
            a.pixels.len(),
            a.thresholds_sq.len(),
            b.points_cam.len(),
            b.pixels.len(),
            b.thresholds_sq.len(),
        ];
        assert!(
            lengths.iter().all(|&length| length == n),
            "one point, pixel and threshold per match and camera"
        );
        Self { a, b, with_scale }
    }
}

impl Estimator for SimilarityEstimator<'_> {
    type Model = Sim3;

    fn n_items(&self) -> usize {
        self.a.points_cam.len()
    }

    fn fit(&self, sample: &[usize]) -> Vec<Sim3> {
        let (src, dst) = (pick(self.b.points_cam, sample), pick(self.a.points_cam, sample));
        align_umeyama(&src, &dst, None, self.with_scale).into_iter().collect()
    }

    fn error_sq(&self, a_from_b: &Sim3, item: usize) -> f64 {
        let in_a = a_from_b * self.b.points_cam[item];
        let in_b = a_from_b.rotation.matrix().tr_mul(&(self.a.points_cam[item] - a_from_b.translation))
            / a_from_b.scale;
        self.a.error_sq(&in_a, item).max(self.b.error_sq(&in_b, item))
    }

    fn threshold_sq(&self) -> f64 {
        1.0
    }

    fn refit(&self, _: &Sim3, inliers: &[usize], weights: &[f64]) -> Option<Sim3> {
        let (src, dst) = (pick(self.b.points_cam, inliers), pick(self.a.points_cam, inliers));
        align_umeyama(&src, &dst, Some(&pick(weights, inliers)), self.with_scale)
    }
}
