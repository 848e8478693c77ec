//! The pinhole camera.

use crate::aliases::{Mat2x3, Mat3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// Focal lengths and principal point, all in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pinhole {
    /// Focal length along x in pixels.
    pub fx: f64,
    /// Focal length along y in pixels.
    pub fy: f64,
    /// Principal point, x in pixels.
    pub cx: f64,
    /// Principal point, y in pixels.
    pub cy: f64,
}

impl Pinhole {
    /// The pixel of a point in camera coordinates; meaningful for `z > 0` only (no test here, for speed).
    #[inline]
    pub fn project(&self, point_cam: &Vec3) -> Vec2 {
        let inverse_z = 1.0 / point_cam.z;
        Vec2::new(self.fx * point_cam.x * inverse_z + self.cx, self.fy * point_cam.y * inverse_z + self.cy)
    }

    /// The ray of a pixel in camera coordinates, with `z = 1`.
    #[inline]
    pub fn unproject(&self, pixel: &Vec2) -> Vec3 {
        Vec3::new((pixel.x - self.cx) / self.fx, (pixel.y - self.cy) / self.fy, 1.0)
    }

    /// The derivative of [`Pinhole::project`] by the point: 2 by 3, pixels per meter.
    #[inline]
    pub fn project_jacobian(&self, point_cam: &Vec3) -> Mat2x3 {
        let inverse_z = 1.0 / point_cam.z;
        let (x, y) = (point_cam.x * inverse_z, point_cam.y * inverse_z);
        let (fx, fy) = (self.fx * inverse_z, self.fy * inverse_z);
        Mat2x3::new(fx, 0.0, -fx * x, 0.0, fy, -fy * y)
    }

    /// The calibration matrix `[fx 0 cx; 0 fy cy; 0 0 1]`.
    pub fn matrix(&self) -> Mat3 {
        Mat3::new(self.fx, 0.0, self.cx, 0.0, self.fy, self.cy, 0.0, 0.0, 1.0)
    }

    /// The camera of an image whose width and height were changed by these factors, with the corners of the image kept in place.
    #[must_use]
    pub fn resized(&self, [x, y]: [f64; 2]) -> Self {
        // Where nothing changes, no digit does.
        let center = |c: f64, factor: f64| if factor == 1.0 { c } else { (c + 0.5) * factor - 0.5 };
        Self { fx: self.fx * x, fy: self.fy * y, cx: center(self.cx, x), cy: center(self.cy, y) }
    }
}
