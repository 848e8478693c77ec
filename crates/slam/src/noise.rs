//! How exactly a feature's position is known, and whether it agrees with a point.

use features::Frame;
use geometry::Vec3;
use optim::{CHI2_MONO, CHI2_STEREO};

/// The least that a feature counts, so that no observation vanishes.
const LEAST_WEIGHT: f64 = 0.05;

/// How exactly features are placed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    /// Standard deviation at octave 0, pixels.
    pub(crate) sigma_px: f64,
    /// Whether a feature counts the less, the less it is trusted.
    pub(crate) weighted: bool,
}

/// Inverse variance of the position of feature `i`, per squared pixel of level 0, times its activation if that counts.
pub(crate) fn information(frame: &Frame, i: usize, noise: Noise) -> f64 {
    let information = frame.inv_sigma_sq(i) / (noise.sigma_px * noise.sigma_px);
    if noise.weighted { information * f64::from(frame.activation[i]).max(LEAST_WEIGHT) } else { information }
}

/// Whether feature `i` shows a point, given in camera coordinates: in front of the camera, and reprojected within the
/// chi-square limit (95 %; the right column counts where it was measured) when the feature's position has the standard
/// deviation `sigma_px` at octave 0.
pub(crate) fn agrees(frame: &Frame, i: usize, point_cam: &Vec3, sigma_px: f64) -> bool {
    if point_cam.z <= 0.0 {
        return false;
    }
    let uvr = frame.rig.stereo.project(point_cam);
    let pixel = frame.pixel(i);
    let (du, dv) = (uvr.x - pixel.x, uvr.y - pixel.y);
    let right_u = f64::from(frame.right_u[i]);
    let (error_sq, limit) = if right_u.is_nan() {
        (du * du + dv * dv, CHI2_MONO)
    } else {
        let dr = uvr.z - right_u;
        (du * du + dv * dv + dr * dr, CHI2_STEREO)
    };
    error_sq * information(frame, i, Noise { sigma_px, weighted: false }) <= limit
}

#[cfg(test)]
#[path = "../tests/steps/noise.rs"]
mod tests;
