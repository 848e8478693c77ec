//! Motion-only optimization: the pose of one frame against fixed points, with outliers found on the way.
//!
//! Instead of several restarts one descent: each stage continues from the pose of the last and rejudges all observations
//! by a limit that tightens from stage to stage, so that gross outliers go first and anything may return. Huber's loss
//! leads, plain least squares over the inliers ends it.

mod lanes;
mod normal;

use geometry::{SE3, StereoRig, Vec2, Vec3, Vec6};

use crate::descent::{Attempt, Descent};
use crate::report::{Report, StopReason};
use crate::robust::Loss;
use normal::{Normal, Packs};
use simd::Simd;

/// A measurement of a known point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseObservation {
    /// The point in the world, meters.
    pub point_world: Vec3,
    /// Undistorted pixel in the left image.
    pub pixel: Vec2,
    /// Column in the rectified right image; NaN: none (monocular).
    pub right_u: f64,
    /// Inverse variance of each coordinate, 1/px^2.
    pub inv_sigma_sq: f64,
}

/// Multiples of the chi-square limit by which the robust stages choose their observations, after a first stage with all: at
/// 5 and 2 times the deviation of an inlier on the limit. Without them half of the problems with 60 % outliers end wrong.
const GRADUATED_LIMITS: [f64; 2] = [25.0, 4.0];
/// A stage with fewer observations is left out.
const MIN_OBSERVATIONS: usize = 6;
/// Limit on stages of plain least squares over the inliers; they end when the set of inliers stays the same.
const MAX_PLAIN_STAGES: usize = 3;
/// A robust stage ends once a step changes the cost by less than this part of it.
const ROBUST_TOLERANCE: f64 = 1e-3;
/// Levenberg-Marquardt damping of the first step, relative to the diagonal of the normal equations.
const INITIAL_DAMPING: f64 = 1e-5;

/// How to refine a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseOptions {
    /// Inliers have a squared error of at most this times [`crate::CHI2_MONO`] or [`crate::CHI2_STEREO`].
    pub limit_factor: f64,
    /// Limit on linear systems solved per stage.
    pub max_iterations: usize,
    /// A plain stage ends once a step changes the cost by less than this part of it.
    pub plain_tolerance: f64,
}

impl Default for PoseOptions {
    fn default() -> Self {
        Self { limit_factor: 1.0, max_iterations: 10, plain_tolerance: 1e-6 }
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

/// Refines the pose of a frame from a prediction, with half of the observations grossly wrong.
///
/// Levenberg-Marquardt on SE(3) (left perturbation, analytic Jacobians). Points behind the camera, errors beyond 1000
/// sigma and observations that are not finite are outliers that pull nothing. With too few observations the initial pose comes back.
pub fn refine_pose(
    rig: &StereoRig,
    initial: SE3,
    observations: &[PoseObservation],
    options: &PoseOptions,
) -> PoseSolution {
    refine_pose_with(rig, initial, observations, options, Simd::detect())
}

/// [`refine_pose`] with given instructions.
pub(crate) fn refine_pose_with(
    rig: &StereoRig,
    initial: SE3,
    observations: &[PoseObservation],
    options: &PoseOptions,
    simd: Simd,
) -> PoseSolution {
    let mut stages = Stages {
        packs: Packs::new(rig, observations, simd),
        active: Vec::new(),
        loss: Loss::Huber,
        cam_from_world: initial,
        iterations: 0,
        stop: StopReason::NoData,
    };
    for factor in [f64::INFINITY].into_iter().chain(GRADUATED_LIMITS) {
        stages.stage(factor * options.limit_factor, Loss::Huber, options);
    }
    for _ in 0..MAX_PLAIN_STAGES {
        if !stages.stage(options.limit_factor, Loss::Squared, options) {
            break;
        }
    }
    let Stages { mut packs, mut cam_from_world, iterations, stop, .. } = stages;
    if iterations > 0 {
        cam_from_world = cam_from_world.normalized();
    }
    let inliers = packs.within(&cam_from_world, options.limit_factor);
    packs.set_active(&inliers);
    let report = Report {
        initial_cost: packs.normal(&initial, Loss::Squared).cost,
        final_cost: packs.normal(&cam_from_world, Loss::Squared).cost,
        iterations,
        n_inliers: inliers.iter().filter(|&&i| i).count(),
        stop,
    };
    PoseSolution { cam_from_world, inliers, report }
}

/// The state that goes from stage to stage.
struct Stages {
    packs: Packs,
    /// Observations of the last stage.
    active: Vec<bool>,
    /// Loss of the last stage.
    loss: Loss,
    cam_from_world: SE3,
    iterations: usize,
    stop: StopReason,
}

impl Stages {
    /// Minimizes over the observations within `limit_factor`; `false` where that would change nothing, or they are too few.
    fn stage(&mut self, limit_factor: f64, loss: Loss, options: &PoseOptions) -> bool {
        let active = self.packs.within(&self.cam_from_world, limit_factor);
        let n_active = active.iter().filter(|&&a| a).count();
        if n_active < MIN_OBSERVATIONS || (active == self.active && loss == self.loss) {
            return false;
        }
        self.packs.set_active(&active);
        (self.active, self.loss) = (active, loss);
        self.stop = self.minimize(options);
        true
    }

    /// Levenberg-Marquardt over the active observations.
    fn minimize(&mut self, options: &PoseOptions) -> StopReason {
        let tolerance = match self.loss {
            Loss::Huber => ROBUST_TOLERANCE,
            Loss::Squared => options.plain_tolerance,
        };
        let descent =
            Descent { max_iterations: options.max_iterations, tolerance, initial_damping: INITIAL_DAMPING };
        let mut current = self.packs.normal(&self.cam_from_world, self.loss);
        let (iterations, stop) = descent.run(|lambda| {
            let step = damped_step(&current, lambda)?;
            let trial_pose = SE3::exp(&Vec6::from(step.vector)) * self.cam_from_world;
            let trial = self.packs.normal(&trial_pose, self.loss);
            let (cost, decrease) = (current.cost, current.cost - trial.cost);
            if decrease > 0.0 {
                (self.cam_from_world, current) = (trial_pose, trial);
            }
            Some(Attempt { cost, decrease, predicted: step.predicted })
        });
        self.iterations += iterations;
        stop
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
