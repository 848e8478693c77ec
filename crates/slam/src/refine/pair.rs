//! A pair tells how its disparities are off. Its focal length and baseline carry the scale, which images do not tell; they are kept.
//!
//! Counting residuals promises far too much: what is wrong in the model besides (a tilt of the right camera, distortion) looks
//! like an offset too, and does not average out over a longer drive. So an offset as found is a measurement with a systematic error,
//! and is weighed against how far calibrations are usually off, instead of being taken whole or not at all.

use optim::CalibrationVector;

use super::{Found, HELD, solve};
use crate::problem::MapProblem;

/// Index of the offset of all disparities.
const OFFSET: usize = 4;
/// How far disparities are usually off, one standard deviation, pixels. This and `SYSTEMATIC_PX` were chosen on 21 runs of KITTI 03, 06
/// and drive 1405 (0.1 px each, and 0.03 px without a systematic error, came close); `RARE` is plausible, not tuned.
const USUAL_PX: f64 = 0.06;
/// Offsets from here on are rare but all alike, as of a rig that was knocked; in standard deviations of the usual ones.
const RARE: f64 = 2.5;
/// What remains of the model's errors in an offset as found, one standard deviation, pixels.
const SYSTEMATIC_PX: f64 = 0.06;
/// Looks for the offset freely.
const FREE: CalibrationVector = [HELD, HELD, HELD, HELD, 1.0, HELD];
/// Holds the offset where it is expected.
const KNOWN: CalibrationVector = [HELD, HELD, HELD, HELD, 1e-6, HELD];
/// What changes disparities by less is left, pixels.
const NEGLIGIBLE_PX: f64 = 0.01;
/// Fewer observations do not tell.
const MIN_OBSERVATIONS: usize = 300;

/// Looks for an offset of all disparities, where `before` was found already; `None` if it stays as it is.
pub(super) fn look(whole: &MapProblem, before: &CalibrationVector) -> Option<Found> {
    if whole.problem.observations.len() < MIN_OBSERVATIONS {
        return None;
    }
    let free = solve(whole, before.map(|error| -error), FREE)?;
    let variance = SYSTEMATIC_PX.powi(2) + free.sigma[OFFSET].powi(2);
    let offset_px = most_likely(before[OFFSET] + free.errors[OFFSET], variance);
    let change_px = offset_px - before[OFFSET];
    if change_px.abs() < NEGLIGIBLE_PX {
        return None;
    }
    let with_offset = |mut all: CalibrationVector, value| {
        all[OFFSET] = value;
        all
    };
    let solution = solve(whole, with_offset([0.0; 6], change_px), KNOWN)?;
    let sigma = with_offset([0.0; 6], variance.sqrt());
    Some(Found { errors: with_offset(*before, offset_px), sigma, solution })
}

/// The most likely offset, where `found_px` was found with a variance, px^2, if usual offsets are normally distributed and rare ones
/// fall off exponentially (the maximum a posteriori under Huber's density).
fn most_likely(found_px: f64, variance: f64) -> f64 {
    let usual = USUAL_PX * USUAL_PX;
    let shrunk = found_px * usual / (usual + variance);
    let rare_px = RARE * USUAL_PX;
    if shrunk.abs() <= rare_px { shrunk } else { found_px - (rare_px * variance / usual).copysign(found_px) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_offset_is_halved_and_a_large_one_loses_a_fixed_amount() {
        let variance = SYSTEMATIC_PX * SYSTEMATIC_PX;
        for (found, kept) in [(0.0, 0.0), (0.1, 0.05), (-0.2, -0.1), (0.3, 0.15), (0.5, 0.35), (-1.0, -0.85)]
        {
            let likely = most_likely(found, variance);
            assert!((likely - kept).abs() < 1e-12, "{found}: {likely}");
        }
        assert!(most_likely(0.1, 4.0 * variance) < 0.03, "what is hardly known counts little");
    }
}
