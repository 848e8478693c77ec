//! What the Schur solver must know of a camera: how an observation depends on one camera and one point.

use crate::robust::Loss;

/// A camera model for [`crate::minimize`] with `C` parameters per camera.
///
/// Residuals are whitened; a step of a camera is a vector of its tangent space, a step of a point is added to it.
pub trait ObservationModel<const C: usize> {
    /// A camera with whatever it caches.
    type Camera: Clone;
    /// One measurement.
    type Observation: Copy;

    /// The camera moved by `step`.
    fn moved(&self, camera: &Self::Camera, step: &[f64; C]) -> Self::Camera;

    /// Squared whitened error; `None` where the measurement is undefined (point behind the camera, not finite) or beyond
    /// the model's cap: it then counts a squared error of 1e6 and pulls nothing.
    fn chi_sq(&self, camera: &Self::Camera, point: &Point, observation: &Self::Observation) -> Option<f64>;

    /// Square of Huber's delta for this measurement.
    fn delta_sq(&self, observation: &Self::Observation) -> f64;

    /// Normal-equation blocks of one measurement, weighted with the loss; `None` exactly where [`Self::chi_sq`] is.
    fn linearize(
        &self,
        camera: &Self::Camera,
        point: &Point,
        observation: &Self::Observation,
        loss: Loss,
    ) -> Option<Linearization<C>>;
}

/// A point in the world, or a step of one.
pub type Point = [f64; 3];

/// J^T W J and J^T W r of one observation, split into camera and point.
#[derive(Clone, Copy, Debug)]
pub struct Linearization<const C: usize> {
    /// Camera block; only the lower triangle is read.
    pub camera_camera: [[f64; C]; C],
    /// Point-camera block, one row per point coordinate.
    pub point_camera: [[f64; C]; 3],
    /// Point block, lower triangle by rows: 00, 10, 11, 20, 21, 22.
    pub point_point: [f64; 6],
    /// Gradient of the cost in the camera.
    pub camera_gradient: [f64; C],
    /// Gradient of the cost in the point.
    pub point_gradient: [f64; 3],
}

impl<const C: usize> Linearization<C> {
    /// The blocks of a residual `r` with Jacobians in camera and point, one row per residual, weighted by `weight`.
    #[inline(always)]
    pub fn from_jacobians<const R: usize>(
        r: &[f64; R],
        by_camera: &[[f64; C]; R],
        by_point: &[[f64; 3]; R],
        weight: f64,
    ) -> Self {
        let mut out = Self {
            camera_camera: [[0.0; C]; C],
            point_camera: [[0.0; C]; 3],
            point_point: [0.0; 6],
            camera_gradient: [0.0; C],
            point_gradient: [0.0; 3],
        };
        for k in 0..R {
            for i in 0..C {
                let weighted = weight * by_camera[k][i];
                for j in 0..=i {
                    out.camera_camera[i][j] += weighted * by_camera[k][j];
                }
                out.camera_gradient[i] += weighted * r[k];
            }
            for i in 0..3 {
                let weighted = weight * by_point[k][i];
                for j in 0..C {
                    out.point_camera[i][j] += weighted * by_camera[k][j];
                }
                for j in 0..=i {
                    out.point_point[i * (i + 1) / 2 + j] += weighted * by_point[k][j];
                }
                out.point_gradient[i] += weighted * r[k];
            }
        }
        out
    }
}
