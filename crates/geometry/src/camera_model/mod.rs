//! Cameras as they come from a calibration: raw pixels, with the lens in the model.

mod kannala_brandt;
mod rational;

pub use kannala_brandt::KannalaBrandt;
pub use rational::Rational;

use crate::aliases::{Vec2, Vec3};
use crate::distortion::Distortion;
use crate::pinhole::Pinhole;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A camera whose pixels are those of the sensor, not undistorted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum CameraModel {
    /// A pinhole with radial and tangential distortion.
    Pinhole {
        /// Focal lengths and principal point.
        camera: Pinhole,
        /// The lens.
        distortion: Distortion,
    },
    /// A fisheye.
    KannalaBrandt(KannalaBrandt),
    /// A pinhole with a rational distortion of eight coefficients.
    Rational(Rational),
}

impl CameraModel {
    /// The raw pixel of a point in camera coordinates.
    ///
    /// Meaningful up to [`CameraModel::max_angle`] from the axis only (no test here, for speed).
    pub fn project(&self, point_cam: &Vec3) -> Vec2 {
        match self {
            Self::Pinhole { camera, distortion } => {
                camera.project(&distortion.distort(&(point_cam.xy() / point_cam.z)).push(1.0))
            }
            Self::KannalaBrandt(fisheye) => fisheye.project(point_cam),
            Self::Rational(lens) => {
                lens.camera.project(&lens.distort(&(point_cam.xy() / point_cam.z)).push(1.0))
            }
        }
    }

    /// The ray of a raw pixel in camera coordinates, of length one; the inverse of [`CameraModel::project`].
    pub fn unproject(&self, pixel: &Vec2) -> Vec3 {
        match self {
            Self::Pinhole { camera, distortion } => {
                distortion.undistort(&camera.unproject(pixel).xy()).push(1.0).normalize()
            }
            Self::KannalaBrandt(fisheye) => fisheye.unproject(pixel),
            Self::Rational(lens) => lens.undistort(&lens.camera.unproject(pixel).xy()).push(1.0).normalize(),
        }
    }

    /// The angle from the axis in radians up to which the projection is one to one: beyond it, a lens model folds its image back.
    ///
    /// A pinhole sees less than a quarter turn; its tangential terms are ignored.
    pub fn max_angle(&self) -> f64 {
        match self {
            Self::Pinhole { distortion, .. } => distortion.max_radius().atan(),
            Self::KannalaBrandt(fisheye) => fisheye.max_angle(),
            Self::Rational(lens) => lens.max_radius().atan(),
        }
    }

    /// The camera of an image whose width and height were changed by these factors; the lens stays the same.
    #[must_use]
    pub fn resized(&self, factors: [f64; 2]) -> Self {
        self.with_pinhole(self.pinhole().resized(factors))
    }

    /// The same lens with other focal lengths and another principal point.
    #[must_use]
    pub fn with_pinhole(&self, camera: Pinhole) -> Self {
        match *self {
            Self::Pinhole { distortion, .. } => Self::Pinhole { camera, distortion },
            Self::KannalaBrandt(fisheye) => Self::KannalaBrandt(KannalaBrandt { camera, ..fisheye }),
            Self::Rational(lens) => Self::Rational(Rational { camera, ..lens }),
        }
    }

    /// Focal lengths and principal point.
    pub fn pinhole(&self) -> &Pinhole {
        match self {
            Self::Pinhole { camera, .. } => camera,
            Self::KannalaBrandt(fisheye) => &fisheye.camera,
            Self::Rational(lens) => &lens.camera,
        }
    }
}

/// The model's name with its numbers.
impl fmt::Display for CameraModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Pinhole { fx, fy, cx, cy } = self.pinhole();
        match self {
            Self::Pinhole { distortion: Distortion { k1, k2, p1, p2, k3 }, .. } => {
                write!(f, "pinhole {fx} {fy} {cx} {cy}, radial-tangential {k1} {k2} {p1} {p2} {k3}")
            }
            Self::KannalaBrandt(KannalaBrandt { k1, k2, k3, k4, .. }) => {
                write!(f, "fisheye {fx} {fy} {cx} {cy}, Kannala-Brandt {k1} {k2} {k3} {k4}")
            }
            Self::Rational(Rational {
                upper: Distortion { k1, k2, p1, p2, k3 },
                lower: [k4, k5, k6],
                ..
            }) => {
                write!(f, "pinhole {fx} {fy} {cx} {cy}, rational {k1} {k2} {p1} {p2} {k3} {k4} {k5} {k6}")
            }
        }
    }
}
