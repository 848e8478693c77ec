//! The fisheye camera of Kannala and Brandt (PAMI 2006, equation 6) as OpenCV's module `fisheye` defines it.

use crate::aliases::{Vec2, Vec3};
use crate::pinhole::Pinhole;
use crate::polynomial::first_sign_change;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A lens whose image radius is a polynomial of the angle `a` between ray and axis: `a + k1 a^3 + k2 a^5 + k3 a^7 + k4 a^9`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct KannalaBrandt {
    /// Focal lengths and principal point in pixels.
    pub camera: Pinhole,
    /// Coefficient of the third power.
    pub k1: f64,
    /// Coefficient of the fifth power.
    pub k2: f64,
    /// Coefficient of the seventh power.
    pub k3: f64,
    /// Coefficient of the ninth power.
    pub k4: f64,
}

impl KannalaBrandt {
    /// The pixel of a point in camera coordinates, which may lie beside or behind the camera.
    ///
    /// Meaningful up to [`KannalaBrandt::max_angle`] from the axis (no test here, for speed).
    pub fn project(&self, point_cam: &Vec3) -> Vec2 {
        let across = point_cam.xy().norm();
        let angle = across.atan2(point_cam.z);
        // The limit of angle over distance on the axis.
        let scale = if across > 0.0 { self.radius(angle) / across } else { 1.0 / point_cam.z };
        let Pinhole { fx, fy, cx, cy } = self.camera;
        Vec2::new(fx * scale * point_cam.x + cx, fy * scale * point_cam.y + cy)
    }

    /// The ray of a pixel in camera coordinates, of length one, by Newton's method with step halving.
    ///
    /// Beyond the radius of [`KannalaBrandt::max_angle`] there is no ray; then the nearest angle reached is taken.
    pub fn unproject(&self, pixel: &Vec2) -> Vec3 {
        let Pinhole { fx, fy, cx, cy } = self.camera;
        let across = Vec2::new((pixel.x - cx) / fx, (pixel.y - cy) / fy);
        let radius = across.norm();
        if radius == 0.0 {
            return Vec3::z();
        }
        let angle = self.angle(radius);
        let direction = across * (angle.sin() / radius);
        Vec3::new(direction.x, direction.y, angle.cos())
    }

    /// The angle from the axis in radians up to which the projection is one to one, at most pi.
    pub fn max_angle(&self) -> f64 {
        let derivative = [1.0, 3.0 * self.k1, 5.0 * self.k2, 7.0 * self.k3, 9.0 * self.k4];
        first_sign_change(&derivative, PI * PI).map_or(PI, f64::sqrt)
    }

    /// The image radius of an angle, at focal length one.
    fn radius(&self, angle: f64) -> f64 {
        let sq = angle * angle;
        angle * (1.0 + sq * (self.k1 + sq * (self.k2 + sq * (self.k3 + sq * self.k4))))
    }

    /// The derivative of [`KannalaBrandt::radius`].
    fn slope(&self, angle: f64) -> f64 {
        let sq = angle * angle;
        1.0 + sq * (3.0 * self.k1 + sq * (5.0 * self.k2 + sq * (7.0 * self.k3 + sq * 9.0 * self.k4)))
    }

    /// The angle of an image radius.
    fn angle(&self, radius: f64) -> f64 {
        const MAX_ITERATIONS: usize = 30;
        const MAX_HALVINGS: usize = 20;
        let mut angle = radius.min(PI);
        let mut residual = self.radius(angle) - radius;
        for _ in 0..MAX_ITERATIONS {
            let mut step = residual / self.slope(angle);
            let mut improved = false;
            for _ in 0..MAX_HALVINGS {
                let candidate = (angle - step).clamp(0.0, PI);
                let candidate_residual = self.radius(candidate) - radius;
                if candidate_residual.abs() < residual.abs() {
                    (angle, residual, improved) = (candidate, candidate_residual, true);
                    break;
                }
                step *= 0.5;
            }
            if !improved {
                break;
            }
        }
        angle
    }
}
