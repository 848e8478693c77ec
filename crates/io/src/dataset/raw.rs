//! Cameras as a dataset calibrates them, before rectification, and what rectification makes of them.

use geometry::{CameraModel, SE3, SO3};

use crate::images::ImageSize;

/// A camera with its lens, and where it sits.
#[derive(Clone, Debug, PartialEq)]
pub struct RawCamera {
    /// Projection to raw pixels.
    pub model: CameraModel,
    /// Size of its images.
    pub size: ImageSize,
    /// Pose of the camera in the frame of the body, meters (EuRoC: `T_BS`).
    pub body_from_cam: SE3,
}

/// The cameras that a sequence uses, the left one first.
#[derive(Clone, Debug, PartialEq)]
pub struct RawCalibration {
    /// One camera, or two (stereo).
    pub cameras: Vec<RawCamera>,
    /// Where it was read: a path.
    pub source: String,
}

/// How the raw images of one camera become those of [`super::Calibration`], which have the same size.
///
/// A pixel `p` of the new image shows what the raw image has at
/// `model.project(rectified_from_cam^-1 * camera.unproject(p))`, with `camera` that of the calibration's rig.
#[derive(Clone, Debug, PartialEq)]
pub struct RectifiedView {
    /// Projection to raw pixels.
    pub model: CameraModel,
    /// The turn of the camera.
    pub rectified_from_cam: SO3,
    /// Size of the raw and of the new images.
    pub size: ImageSize,
}
