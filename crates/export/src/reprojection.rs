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

impl ReprojectionError {
    /// The error of a scene, whose points carry the means over their observations.
    pub(crate) fn of(scene: &Scene) -> Self {
        let n_observations: usize = scene.points.iter().map(|point| point.track.len()).sum();
        let sum: f64 = scene.points.iter().map(|point| point.error_px * point.track.len() as f64).sum();
        let of_points: f64 = scene.points.iter().map(|point| point.error_px).sum();
        Self {
            n_observations,
            mean_px: sum / n_observations.max(1) as f64,
            mean_of_points_px: of_points / scene.points.len().max(1) as f64,
        }
    }
}
