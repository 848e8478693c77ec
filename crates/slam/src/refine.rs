//! Refines the calibration from the map so far, inside the run: a bundle adjustment over the whole map in which the calibration is
//! unknown too (Cvisic et al., arXiv 2109.03462, do so after the fact for KITTI).
//!
//! One camera tells its focal length, principal point and distortion when it turns; a pair also tells how disparities are off.
//! What the images do not tell significantly stays as it was given.

mod one;
mod pair;

use std::fmt;
use std::sync::Arc;

use features::{Frame, Rig};
use geometry::Sensor;
use map::{Correction, KeyframeCorrection, KeyframeId, Map};
use optim::{BundleOptions, CalibrationProblem, CalibrationSolution, CalibrationVector, refine_calibration};

use crate::noise::Noise;
use crate::params::Params;
use crate::problem::MapProblem;

/// A calibration as the images of a run tell it, in the place of the one that was given.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedCalibration {
    /// The rig as it was given.
    pub given: Arc<Rig>,
    /// The rig now.
    pub rig: Arc<Rig>,
    /// What was wrong with the given one; 0 where the images do not tell.
    pub errors: CalibrationVector,
    /// Standard deviations of the errors.
    pub sigma: CalibrationVector,
    /// Keyframes that it rests on.
    pub keyframes: usize,
}

/// Names of a calibration's errors: logarithm of the factor on the focal lengths, shift of the principal point in pixels, radial
/// distortion of second order, offset of all disparities in pixels, roll of the right camera in radians.
pub const CALIBRATION_NAMES: [&str; 6] =
    ["log_focal", "center_x_px", "center_y_px", "radial", "disparity_offset_px", "right_roll_rad"];

/// Standard deviation of a feature's position at octave 0, pixels, as seen in residuals on real drives.
const SIGMA_PX: f64 = 0.5;
/// Keyframes at the first attempt, and the factor to each further one.
const FIRST_KEYFRAMES: usize = 20;
const GROWTH: f64 = 1.5;
/// Larger maps tell nothing new that their earlier state did not.
const MAX_KEYFRAMES: usize = 300;
/// Points count from this many observations on.
const MIN_TRACK: usize = 3;
const ITERATIONS: usize = 12;
/// Holds what is not looked for.
const HELD: f64 = 1e-9;

impl RefinedCalibration {
    fn new(given: &Arc<Rig>, errors: CalibrationVector, sigma: CalibrationVector, keyframes: usize) -> Self {
        let mut rig = Rig::clone(given);
        let [log_focal, center_x, center_y, radial, ..] = errors;
        let camera = &mut rig.stereo.camera;
        camera.fx *= log_focal.exp();
        camera.fy *= log_focal.exp();
        camera.cx += center_x;
        camera.cy += center_y;
        rig.distortion.k1 += radial;
        Self { given: given.clone(), rig: Arc::new(rig), errors, sigma, keyframes }
    }

    /// The errors that are not 0, by name, with their standard deviations.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, [f64; 2])> {
        let all = CALIBRATION_NAMES.iter().zip(self.errors.iter().zip(&self.sigma));
        all.filter(|(_, (error, _))| error.abs() > HELD)
            .map(|(name, (&error, &sigma))| (*name, [error, sigma]))
    }

    /// A frame as it was extracted, or by an earlier refinement `from`, by this one.
    pub fn apply(&self, frame: &Arc<Frame>, from: Option<&RefinedCalibration>) -> Arc<Frame> {
        if Arc::ptr_eq(&frame.rig, &self.rig) {
            return frame.clone();
        }
        let before = from.map_or([0.0; 6], |from| from.errors);
        let [offset_px, roll] = [4, 5].map(|i| self.errors[i] - before[i]);
        let slope = roll * self.given.stereo.camera.fx / self.given.stereo.camera.fy;
        Arc::new(frame.recalibrated(&self.rig, offset_px, slope))
    }
}

impl fmt::Display for RefinedCalibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = |(name, [error, sigma]): (&str, [f64; 2])| format!("{name} {error:+.4} (+- {sigma:.4})");
        let words: Vec<String> = self.named().map(word).collect();
        write!(f, "{}, from {} keyframes", words.join(", "), self.keyframes)
    }
}

/// The calibration of a map, and when it is looked at again.
#[derive(Clone, Debug)]
pub(crate) struct Refinement {
    next_keyframes: usize,
}

impl Default for Refinement {
    fn default() -> Self {
        Self { next_keyframes: FIRST_KEYFRAMES }
    }
}

impl Refinement {
    /// Whether a map of this many keyframes is looked at as a whole.
    pub(crate) fn fits(&self, n_keyframes: usize) -> bool {
        n_keyframes <= MAX_KEYFRAMES
    }

    /// Whether the map has grown enough to be looked at again.
    pub(crate) fn is_due(&mut self, n_keyframes: usize) -> bool {
        let is_due = n_keyframes >= self.next_keyframes && self.fits(n_keyframes);
        while self.next_keyframes <= n_keyframes {
            self.next_keyframes = (self.next_keyframes as f64 * GROWTH) as usize;
        }
        is_due
    }
}

/// What a bundle adjustment found.
struct Found {
    /// Errors of the calibration as it was given, and their standard deviations.
    errors: CalibrationVector,
    sigma: CalibrationVector,
    /// Poses and points with the errors taken out.
    solution: CalibrationSolution,
}

/// The calibration that the map tells, and the poses and positions that go with it; `None` if it tells nothing new.
pub(crate) fn refined(
    map: &Map,
    now: Option<&RefinedCalibration>,
    params: &Params,
) -> Option<(RefinedCalibration, Correction)> {
    let look = match params.camera.sensor {
        Sensor::Mono => one::look,
        Sensor::Stereo => pair::look,
        Sensor::Rgbd => return None,
    };
    let whole = whole_map(map)?;
    let given =
        now.map_or_else(|| map.keyframes().next().map(|kf| kf.frame.rig.clone()), |n| Some(n.given.clone()))?;
    let Found { errors, sigma, solution } = look(&whole, &now.map_or([0.0; 6], |now| now.errors))?;
    let calibration = RefinedCalibration::new(&given, errors, sigma, map.n_keyframes());
    let moved = whole.keyframes.iter().zip(&solution.cameras).zip(&whole.problem.fixed);
    let moved = moved.filter(|(_, fixed)| !**fixed);
    let correction = Correction {
        keyframes: moved.map(|((&id, pose), _)| KeyframeCorrection::rigid(id, pose.normalized())).collect(),
        points: whole.points.iter().copied().zip(solution.points.iter().copied()).collect(),
        seen_revision: map.revision(),
        ..Correction::default()
    };
    Some((calibration, correction))
}

/// The bundle adjustment with errors of the present calibration unknown: where they are expected, and how exactly.
fn solve(
    whole: &MapProblem,
    expected: CalibrationVector,
    sigma: CalibrationVector,
) -> Option<CalibrationSolution> {
    let problem = CalibrationProblem { bundle: whole.problem.clone(), expected, sigma };
    let options = BundleOptions { max_iterations: ITERATIONS, huber: Some(1.0), ..BundleOptions::default() };
    refine_calibration(&problem, &options)
}

/// All keyframes and well observed points as one problem; the root of each sub-map is fixed. `None` without keyframes.
fn whole_map(map: &Map) -> Option<MapProblem> {
    let keyframes: Vec<KeyframeId> = map.keyframes().map(|kf| kf.id).collect();
    let points = map.points().filter(|point| point.observations().len() >= MIN_TRACK).map(|p| p.id).collect();
    let noise = Noise { sigma_px: SIGMA_PX, weighted: false };
    MapProblem::new(map, keyframes, points, noise, |id| map.roots().contains(&id))
}
