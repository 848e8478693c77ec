//! What inertia says of a pose: a camera that is carried or driven goes on about as before.
//!
//! In an image with two motions, the scene's and that of a vehicle which fills much of the view, the larger group of matches wins the
//! optimization, whichever it is. Where those that it leaves out agree on a motion of their own, inertia decides between the two. And
//! where nothing but a pose is found that no camera can have reached, there is none.

use features::Frame;
use geometry::{SE3, Vec3};

use crate::lost::Lost;
use crate::noise::{Noise, agrees};
use crate::pose::refine_with_positions;

/// Matches that a second motion needs, as many and as a part both of those of the first and of those that it leaves out. Chosen on the
/// rendered streets busy 932 and 952.
const LEAST_MATCHES: usize = 12;
const LEAST_SHARE: f64 = 0.15;
/// How much nearer to going on as before the second motion must be.
const NEARER: f64 = 0.5;
/// What a camera may do beyond going on as before without surprise, and at most: how much it accelerates, m/s^2, and how far a
/// jolt moves it, meters.
const USUAL_M_S2: f64 = 5.0;
const MOST_M_S2: f64 = 50.0;
const JOLT_M: f64 = 0.03;

/// A pose and which matches agree with it.
pub(super) type Solved = (SE3, Vec<bool>);

/// A camera that goes on as before, in meters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia {
    /// Where it would be.
    pub(super) predicted: SE3,
    /// Since it was seen last.
    pub(super) seconds: f64,
}

impl Inertia {
    /// How far a pose is from going on as before, meters.
    fn off(&self, cam_from_world: &SE3) -> f64 {
        (cam_from_world.center() - self.predicted.center()).norm()
    }

    /// How far it may be by this acceleration, meters.
    fn reach(&self, acceleration_m_s2: f64) -> f64 {
        JOLT_M + acceleration_m_s2 * self.seconds.powi(2)
    }

    /// Checks that the camera can have come to a pose.
    ///
    /// # Errors
    /// How far it is off.
    pub(super) fn check(&self, cam_from_world: &SE3) -> Result<(), Lost> {
        let (off_m, most_m) = (self.off(cam_from_world), self.reach(MOST_M_S2));
        if off_m <= most_m { Ok(()) } else { Err(Lost::TooFar { off_m, most_m }) }
    }

    /// The pose of the matches that `first` leaves out, if they agree on one and it is much nearer to going on as before than the
    /// first, which is surprising; else `first`.
    pub(super) fn likelier(
        &self,
        frame: &Frame,
        matches: &[(u32, Vec3)],
        first: Solved,
        noise: Noise,
    ) -> Solved {
        let rest: Vec<(u32, Vec3)> =
            matches.iter().zip(&first.1).filter(|(_, agrees)| !**agrees).map(|(m, _)| *m).collect();
        let n_first = matches.len() - rest.len();
        let share = LEAST_SHARE * n_first.max(rest.len()) as f64;
        let needed = LEAST_MATCHES.max(share.ceil() as usize);
        if rest.len() < needed || self.off(&first.0) <= self.reach(USUAL_M_S2) {
            return first;
        }
        let (pose, second) = refine_with_positions(frame, self.predicted, &rest, noise);
        let n_second = second.iter().filter(|agrees| **agrees).count();
        if n_second < needed || self.off(&pose) > NEARER * self.off(&first.0) {
            return first;
        }
        let agree = |&(i, point): &(u32, Vec3)| agrees(frame, i as usize, &(pose * point), noise.sigma_px);
        (pose, matches.iter().map(agree).collect())
    }
}

#[cfg(test)]
#[path = "../../tests/steps/inertia.rs"]
mod tests;
