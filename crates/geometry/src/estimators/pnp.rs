//! The pose of a camera from world points and their pixels.

use crate::aliases::{Mat3x6, Mat6, Vec2, Vec3, Vec6};
use crate::p3p::p3p;
use crate::pinhole::Pinhole;
use crate::ransac::Estimator;
use crate::se3::SE3;
use crate::so3::SO3;

/// Estimates `cam_from_world` by P3P; all solutions of a sample compete through their scores.
///
/// The error of a match is its squared reprojection error over its own squared threshold.
#[derive(Clone, Debug)]
pub struct PnpEstimator<'a> {
    camera: Pinhole,
    rays: Vec<Vec3>,
    pixels: &'a [Vec2],
    points_world: &'a [Vec3],
    thresholds_sq: &'a [f64],
}

impl<'a> PnpEstimator<'a> {
    /// Matches in a sample.
    pub const SAMPLE_SIZE: usize = 3;

    /// Matches of undistorted pixels with world points in meters, and for each the squared threshold in square pixels.
    ///
    /// # Panics
    /// When the three lengths differ.
    pub fn new(
        camera: Pinhole,
        pixels: &'a [Vec2],
        points_world: &'a [Vec3],
        thresholds_sq: &'a [f64],
    ) -> Self {
        assert!(
            pixels.len() == points_world.len() && pixels.len() == thresholds_sq.len(),
            "one pixel, point and threshold per match"
        );
        let rays = pixels.iter().map(|pixel| camera.unproject(pixel)).collect();
        Self { camera, rays, pixels, points_world, thresholds_sq }
    }

    /// Adds a match to the normal equations of a pose increment on the left; `None` behind the camera.
    fn accumulate(
        &self,
        cam_from_world: &SE3,
        item: usize,
        weight: f64,
        system: &mut (Mat6, Vec6),
    ) -> Option<()> {
        let point_cam = cam_from_world * self.points_world[item];
        if point_cam.z <= 0.0 {
            return None;
        }
        let residual = self.camera.project(&point_cam) - self.pixels[item];
        let mut point_by_pose = Mat3x6::zeros();
        point_by_pose.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(1.0);
        point_by_pose.fixed_view_mut::<3, 3>(0, 3).copy_from(&-SO3::hat(&point_cam));
        let jacobian = self.camera.project_jacobian(&point_cam) * point_by_pose;
        let weight = weight / self.thresholds_sq[item];
        system.0 += jacobian.tr_mul(&jacobian) * weight;
        system.1 += jacobian.tr_mul(&residual) * weight;
        Some(())
    }
}

impl Estimator for PnpEstimator<'_> {
    type Model = SE3;

    fn n_items(&self) -> usize {
        self.pixels.len()
    }

    fn fit(&self, sample: &[usize]) -> Vec<SE3> {
        let &[a, b, c, ..] = sample else {
            return Vec::new();
        };
        p3p(&[a, b, c].map(|i| self.rays[i]), &[a, b, c].map(|i| self.points_world[i]))
    }

    fn error_sq(&self, cam_from_world: &SE3, item: usize) -> f64 {
        let point_cam = cam_from_world * self.points_world[item];
        if point_cam.z <= 0.0 {
            return f64::INFINITY;
        }
        (self.camera.project(&point_cam) - self.pixels[item]).norm_squared() / self.thresholds_sq[item]
    }

    fn threshold_sq(&self) -> f64 {
        1.0
    }

    /// Gauss-Newton on the weighted reprojection errors.
    fn refit(&self, cam_from_world: &SE3, inliers: &[usize], weights: &[f64]) -> Option<SE3> {
        const ITERATIONS: usize = 3;
        let mut refined = *cam_from_world;
        for _ in 0..ITERATIONS {
            let mut system = (Mat6::zeros(), Vec6::zeros());
            for &item in inliers {
                self.accumulate(&refined, item, weights[item], &mut system)?;
            }
            let step = system.0.cholesky()?.solve(&-system.1);
            refined = (SE3::exp(&step) * refined).normalized();
        }
        refined.is_finite().then_some(refined)
    }
}
