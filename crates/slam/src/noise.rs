//! How exactly a feature's position is known, and whether it agrees with a point.

use features::Frame;
use geometry::Vec3;
use optim::{CHI2_MONO, CHI2_STEREO};

/// Inverse variance of the position of feature `i`, per squared pixel of level 0, when it is `sigma_px` at octave 0.
pub(crate) fn information(frame: &Frame, i: usize, sigma_px: f64) -> f64 {
    frame.inv_sigma_sq(i) / (sigma_px * sigma_px)
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
    error_sq * information(frame, i, sigma_px) <= limit
}
