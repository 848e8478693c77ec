//! Two motions in one image: the scene's, and that of a vehicle which fills much of the view. The larger group of matches wins the
//! optimization, whichever it is. Where those that it leaves out agree on a motion of their own, inertia decides.

use features::Frame;
use geometry::{SE3, Vec3};

use crate::noise::{Noise, agrees};
use crate::pose::refine_with_positions;

/// Matches that a second motion needs, as many and as a part both of those of the first and of those that it leaves out. Chosen on the
/// rendered street busy 932.
const LEAST_MATCHES: usize = 20;
const LEAST_SHARE: f64 = 0.25;
/// What a camera that is carried or driven may do beyond going on as before: how much it accelerates, m/s^2, and how far a jolt moves
/// it, meters.
const ACCELERATION_M_S2: f64 = 5.0;
const JOLT_M: f64 = 0.03;
/// How much nearer to going on as before the second motion must be.
const NEARER: f64 = 0.5;

/// A pose and which matches agree with it.
pub(super) type Solved = (SE3, Vec<bool>);

/// The pose of the matches that `first` leaves out, if they agree on one, and the camera could have come there over `seconds` but hardly
/// to the first one; else `first`. `predicted` is where it would be had it gone on as before.
pub(super) fn likelier(
    frame: &Frame,
    (predicted, seconds): (&SE3, f64),
    matches: &[(u32, Vec3)],
    first: Solved,
    noise: Noise,
) -> Solved {
    let off = |pose: &SE3| (pose.center() - predicted.center()).norm();
    let is_surprising = off(&first.0) > JOLT_M + ACCELERATION_M_S2 * seconds.powi(2);
    let rest: Vec<(u32, Vec3)> =
        matches.iter().zip(&first.1).filter(|(_, agrees)| !**agrees).map(|(m, _)| *m).collect();
    let n_first = matches.len() - rest.len();
    let needed = LEAST_MATCHES.max((LEAST_SHARE * n_first.max(rest.len()) as f64).ceil() as usize);
    if !is_surprising || rest.len() < needed {
        return first;
    }
    let (pose, second) = refine_with_positions(frame, *predicted, &rest, noise);
    let n_second = second.iter().filter(|agrees| **agrees).count();
    if n_second < needed || off(&pose) > NEARER * off(&first.0) {
        return first;
    }
    let agree =
        |&(feature, point): &(u32, Vec3)| agrees(frame, feature as usize, &(pose * point), noise.sigma_px);
    let all = matches.iter().map(agree).collect();
    (pose, all)
}

#[cfg(test)]
#[path = "../../tests/steps/rivals.rs"]
mod tests;
