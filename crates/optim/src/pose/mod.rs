//! Motion-only optimisation: the pose of one frame against fixed points, with outliers found on the way.
//!
//! Each round continues from the pose of the last one; after each all observations are judged anew, so outliers may return.
//! Robust rounds come first, plain least squares over the inliers last.

mod lanes;
mod normal;

use geometry::{SE3, StereoRig, Vec2, Vec3, Vec6};

use crate::bundle::solver::Damping;
use crate::report::{Report, StopReason};
use crate::robust::Loss;
use crate::simd::Lanes;
use normal::{Normal, Packs};

/// A measurement of a known point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseObservation {
    /// The point in the world, metres.
    pub point_world: Vec3,
    /// Undistorted pixel in the left image.
    pub pixel: Vec2,
    /// Column in the rectified right image; NaN: none (monocular).
    pub right_u: f64,
    /// Inverse variance of each coordinate, 1/px^2.
    pub inv_sigma_sq: f64,
}

/// How to refine a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseOptions {
    /// Limit on rounds with Huber's loss; they end when the set of inliers stays the same.
    pub max_robust_rounds: usize,
    /// Limit on rounds of plain least squares over the inliers.
    pub max_plain_rounds: usize,
    /// Limit on linear systems solved per round.
    pub max_iterations: usize,
    /// A round ends once a step changes the cost by less than this part of it.
    pub relative_tolerance: f64,
    /// Inliers have a squared error of at most this times [`crate::CHI2_MONO`] or [`crate::CHI2_STEREO`].
    pub limit_factor: f64,
    /// With fewer inliers no further round is made.
    pub min_inliers: usize,
    /// Levenberg-Marquardt damping of the first step, relative to the diagonal of the normal equations.
    pub initial_damping: f64,
}

impl Default for PoseOptions {
    fn default() -> Self {
        Self {
            max_robust_rounds: 3,
            max_plain_rounds: 3,
            max_iterations: 10,
            relative_tolerance: 1e-6,
            limit_factor: 1.0,
            min_inliers: 6,
            initial_damping: 1e-5,
        }
    }
}

/// A refined pose.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseSolution {
    /// The pose.
    pub cam_from_world: SE3,
    /// Per observation whether it lies in front of the camera and within its chi-square limit at the pose.
    pub inliers: Vec<bool>,
    /// How the solve went; both costs are plain squares over the inliers.
    pub report: Report,
}

/// Refines the pose of a frame from a prediction, with up to half of the observations grossly wrong.
///
/// Levenberg-Marquardt on SE(3) (left perturbation, analytic Jacobians). Points behind the camera are outliers.
pub fn refine_pose(
    rig: &StereoRig,
    initial: SE3,
    observations: &[PoseObservation],
    options: &PoseOptions,
) -> PoseSolution {
    refine_pose_with(rig, initial, observations, options, Lanes::detect())
}

/// [`refine_pose`] with given instructions.
fn refine_pose_with(
    rig: &StereoRig,
    initial: SE3,
    observations: &[PoseObservation],
    options: &PoseOptions,
    lanes: Lanes,
) -> PoseSolution {
    let mut packs = Packs::new(rig, observations, lanes);
    let mut state = Round { cam_from_world: initial, iterations: 0, stop: StopReason::NoData };
    let mut inliers = packs.within(&initial, f64::INFINITY);
    for (loss, rounds) in [(Loss::Huber, options.max_robust_rounds), (Loss::Squared, options.max_plain_rounds)] {
        for _ in 0..rounds {
            if inliers.iter().filter(|&&i| i).count() < options.min_inliers {
                break;
            }
            packs.set_active(&inliers);
            state.run(&packs, loss, options);
            let judged = packs.within(&state.cam_from_world, options.limit_factor);
            let is_stable = judged == inliers;
            inliers = judged;
            if is_stable {
                break;
            }
        }
    }
    let cam_from_world = state.cam_from_world.normalized();
    let inliers = packs.within(&cam_from_world, options.limit_factor);
    packs.set_active(&inliers);
    let report = Report {
        initial_cost: packs.normal(&initial, Loss::Squared).cost,
        final_cost: packs.normal(&cam_from_world, Loss::Squared).cost,
        iterations: state.iterations,
        n_inliers: inliers.iter().filter(|&&i| i).count(),
        stop: state.stop,
    };
    PoseSolution { cam_from_world, inliers, report }
}

struct Round {
    cam_from_world: SE3,
    iterations: usize,
    stop: StopReason,
}

impl Round {
    /// Levenberg-Marquardt over the active observations.
    fn run(&mut self, packs: &Packs, loss: Loss, options: &PoseOptions) {
        let mut current = packs.normal(&self.cam_from_world, loss);
        let mut damping = Damping::new(options.initial_damping);
        self.stop = StopReason::IterationLimit;
        for _ in 0..options.max_iterations {
            self.iterations += 1;
            let Some(step) = damped_step(&current, damping.lambda) else {
                if damping.raise() {
                    continue;
                }
                self.stop = StopReason::NoDescent;
                return;
            };
            let trial_pose = SE3::exp(&Vec6::from(step.vector)) * self.cam_from_world;
            let trial = packs.normal(&trial_pose, loss);
            let decrease = current.cost - trial.cost;
            let small = step.predicted <= options.relative_tolerance * current.cost;
            if decrease > 0.0 {
                self.cam_from_world = trial_pose;
                damping.accept(decrease / step.predicted);
                current = trial;
            }
            if small {
                self.stop = StopReason::Converged;
                return;
            }
            if !(decrease > 0.0) && !damping.raise() {
                self.stop = StopReason::NoDescent;
                return;
            }
        }
    }
}

struct Step {
    vector: [f64; 6],
    /// Decrease of cost by the quadratic model.
    predicted: f64,
}

/// Solves (H + lambda diag(H)) x = -g; `None` when not positive definite.
fn damped_step(normal: &Normal, lambda: f64) -> Option<Step> {
    let Normal { gradient, hessian, .. } = normal;
    let damping: [f64; 6] = std::array::from_fn(|i| lambda * hessian[i][i].max(1e-6));
    let mut l = *hessian;
    let mut x = gradient.map(|g| -g);
    for c in 0..6 {
        for k in 0..c {
            l[c][c] -= l[c][k] * l[c][k];
        }
        let pivot = l[c][c] + damping[c];
        if !(pivot > 0.0 && pivot < f64::INFINITY) {
            return None;
        }
        l[c][c] = pivot.sqrt();
        for r in c + 1..6 {
            for k in 0..c {
                l[r][c] -= l[r][k] * l[c][k];
            }
            l[r][c] /= l[c][c];
        }
    }
    for r in 0..6 {
        for c in 0..r {
            x[r] -= l[r][c] * x[c];
        }
        x[r] /= l[r][r];
    }
    for r in (0..6).rev() {
        for c in r + 1..6 {
            x[r] -= l[c][r] * x[c];
        }
        x[r] /= l[r][r];
    }
    let predicted = (0..6).map(|i| 0.5 * x[i] * (damping[i] * x[i] - gradient[i])).sum();
    Some(Step { vector: x, predicted })
}
