//! The rectified stereo pair; an RGB-D camera is one with a virtual baseline.

use crate::aliases::{Vec2, Vec3};
use crate::pinhole::Pinhole;
use serde::{Deserialize, Serialize};

/// Two equal pinhole cameras, the right one displaced by the baseline along +x of the left one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StereoRig {
    /// Both cameras.
    pub camera: Pinhole,
    /// Distance of the two centers in meters.
    pub baseline_m: f64,
}

impl StereoRig {
    /// Focal length times baseline, in pixel meters: disparity times depth.
    #[inline]
    pub fn bf(&self) -> f64 {
        self.camera.fx * self.baseline_m
    }

    /// `(u, v, u_right)` in pixels of a point in coordinates of the left camera; meaningful for `z > 0` only.
    #[inline]
    pub fn project(&self, point_cam: &Vec3) -> Vec3 {
        let pixel = self.camera.project(point_cam);
        Vec3::new(pixel.x, pixel.y, pixel.x - self.bf() / point_cam.z)
    }

    /// The point in coordinates of the left camera at pixel `(u, v)` and `depth` meters along z.
    #[inline]
    pub fn unproject(&self, u: f64, v: f64, depth: f64) -> Vec3 {
        self.camera.unproject(&Vec2::new(u, v)) * depth
    }

    /// Depth in meters of a disparity `u - u_right` in pixels.
    #[inline]
    pub fn depth_from_disparity(&self, disparity_px: f64) -> f64 {
        self.bf() / disparity_px
    }
}
