//! The motion model: a constant velocity between frames that need not be equally far apart in time.

use geometry::{SE3, SO3};

/// How the camera moved over a known time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotionModel {
    /// `cam_after_from_cam_before`.
    motion: SE3,
    seconds: f64,
}

/// Longest extrapolation, in units of the time over which the motion was seen.
const MAX_STRETCH: f64 = 20.0;

impl MotionModel {
    /// From the poses of two frames `seconds` apart.
    pub(crate) fn between(before_cam_from_world: &SE3, after_cam_from_world: &SE3, seconds: f64) -> Self {
        let motion = (*after_cam_from_world * before_cam_from_world.inverse()).normalized();
        MotionModel { motion, seconds }
    }

    /// The rotation as it was seen.
    pub(crate) fn turn(&self) -> SO3 {
        self.motion.rotation
    }

    /// The motion over `seconds`; the motion as it was seen where either time makes no sense.
    pub(crate) fn motion_over(&self, seconds: f64) -> SE3 {
        let stretch = seconds / self.seconds;
        if !(stretch.is_finite() && stretch > 0.0) || (stretch - 1.0).abs() < 1e-3 {
            return self.motion;
        }
        SE3::exp(&(self.motion.log() * stretch.min(MAX_STRETCH)))
    }
}

#[cfg(test)]
#[path = "../../tests/steps/motion_model.rs"]
mod tests;
