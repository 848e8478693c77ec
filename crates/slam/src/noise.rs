//! How exactly a feature's position is known.

use features::Frame;

/// Inverse variance of the position of feature `i`, per squared pixel of level 0, when it is `sigma_px` at octave 0.
pub(crate) fn information(frame: &Frame, i: usize, sigma_px: f64) -> f64 {
    frame.inv_sigma_sq(i) / (sigma_px * sigma_px)
}
