//! One camera tells its focal length, principal point and distortion once it has turned enough.

use optim::CalibrationVector;

use super::{Found, HELD, solve};
use crate::problem::MapProblem;

/// How far calibrations are usually off, one standard deviation.
const PRIOR: CalibrationVector = [0.02, 5.0, 5.0, 0.003, HELD, HELD];
/// Squared length of the errors in units of their uncertainty from which they are taken away; the uncertainty is that of counting,
/// hence far above the limits of chi-square.
const EVIDENCE: f64 = 100.0;
/// Errors beyond this many standard deviations of the usual ones come from a map that is wrong, not from the calibration.
const BELIEVABLE: f64 = 5.0;
/// Residuals of one point are alike, and no model is exact: uncertainties are so much larger than counting says.
const DEPENDENCE: f64 = 5.0;
/// Fewer observations do not tell.
const MIN_OBSERVATIONS: usize = 1000;

/// Looks for errors of a calibration, where `before` was found already; `None` if nothing was, and nothing clearly
/// more than noise is now.
pub(super) fn look(whole: &MapProblem, before: &CalibrationVector) -> Option<Found> {
    if whole.problem.observations.len() < MIN_OBSERVATIONS {
        return None;
    }
    let solution = solve(whole, before.map(|error| -error), PRIOR)?;
    // A calibration that was wrong before is not trusted again: what more is found refines it.
    if before.iter().all(|error| *error == 0.0) && solution.evidence < EVIDENCE {
        return None;
    }
    let sum = |i| if PRIOR[i] > HELD { before[i] + solution.errors[i] } else { before[i] };
    if (0..before.len()).any(|i| PRIOR[i] > HELD && sum(i).abs() > BELIEVABLE * PRIOR[i]) {
        return None;
    }
    let sigma = solution.sigma.map(|sigma| sigma * DEPENDENCE);
    Some(Found { errors: std::array::from_fn(sum), sigma, solution })
}
