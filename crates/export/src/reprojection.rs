//! How well the points fit the images.

use crate::scene::Scene;

/// Distances between features and projections in the left images, pixels, not robust and not weighted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReprojectionError {
    /// Number of observations.
    pub n_observations: usize,
    /// Mean over all observations; 0 without any.
    pub mean_px: f64,
    /// Mean over the points of the mean over each point's observations, which is what COLMAP reports; 0 without any.
    pub mean_of_points_px: f64,
}

impl Scene {
    /// The error of reprojection over all observations; the points carry the means over theirs.
    pub fn reprojection(&self) -> ReprojectionError {
        let n_observations: usize = self.points.iter().map(|point| point.track.len()).sum();
        let sum: f64 = self.points.iter().map(|point| point.error_px * point.track.len() as f64).sum();
        let of_points: f64 = self.points.iter().map(|point| point.error_px).sum();
        ReprojectionError {
            n_observations,
            mean_px: sum / n_observations.max(1) as f64,
            mean_of_points_px: of_points / self.points.len().max(1) as f64,
        }
    }
}
