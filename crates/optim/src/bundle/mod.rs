//! Bundle adjustment of the rig: poses and points from pixel measurements.

pub(crate) mod calibration;
pub(crate) mod cholesky;
pub(crate) mod model;
pub(crate) mod ordering;
mod point;
pub(crate) mod rig;
pub(crate) mod schur;
pub(crate) mod solver;
pub(crate) mod structure;

use geometry::{SE3, StereoRig, Vec2, Vec3};

use crate::descent::Descent;
use crate::report::Report;
use crate::robust::MAX_CHI_SQ;
use model::{ObservationModel, Point};
use rig::{RigCamera, RigModel, RigObservation};
use simd::Simd;
use solver::{Edge, Graph, minimize_with};

/// A measurement of a point in a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BundleObservation {
    /// Index into [`BundleProblem::cameras`].
    pub camera: u32,
    /// Index into [`BundleProblem::points`].
    pub point: u32,
    /// Undistorted pixel in the left image.
    pub pixel: Vec2,
    /// Column in the rectified right image; NaN: none (monocular).
    pub right_u: f64,
    /// Inverse variance of each coordinate, 1/px^2.
    pub inv_sigma_sq: f64,
}

/// A bundle adjustment problem.
#[derive(Clone, Debug, PartialEq)]
pub struct BundleProblem {
    /// The rig shared by all cameras.
    pub rig: StereoRig,
    /// Initial poses, cam_from_world.
    pub cameras: Vec<SE3>,
    /// Per camera whether it must not move.
    pub fixed: Vec<bool>,
    /// Initial points in the world, meters.
    pub points: Vec<Vec3>,
    /// Measurements in any order.
    pub observations: Vec<BundleObservation>,
}

/// How to solve a [`BundleProblem`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BundleOptions {
    /// Limit on linear systems solved.
    pub max_iterations: usize,
    /// Huber's loss with delta^2 = this part of [`crate::CHI2_MONO`] or [`crate::CHI2_STEREO`]; `None`: plain squares.
    pub huber: Option<f64>,
    /// Stop once a step changes the cost by less than this part of it.
    pub relative_tolerance: f64,
    /// Levenberg-Marquardt damping of the first step, relative to the diagonal of the normal equations.
    pub initial_damping: f64,
}

impl Default for BundleOptions {
    fn default() -> Self {
        Self { max_iterations: 10, huber: Some(1.0), relative_tolerance: 1e-6, initial_damping: 1e-4 }
    }
}

impl BundleOptions {
    pub(crate) fn descent(&self) -> Descent {
        Descent {
            max_iterations: self.max_iterations,
            tolerance: self.relative_tolerance.max(f64::EPSILON),
            initial_damping: self.initial_damping,
        }
    }
}

/// A solved [`BundleProblem`].
#[derive(Clone, Debug, PartialEq)]
pub struct BundleSolution {
    /// Poses, cam_from_world; fixed ones unchanged.
    pub cameras: Vec<SE3>,
    /// Points in the world, meters.
    pub points: Vec<Vec3>,
    /// Whitened squared error per observation, in input order; 1e6 where it is larger or the point is behind the camera.
    pub chi_sq: Vec<f64>,
    /// Per observation whether its point lies in front of its camera and its error within the 95 % limit
    /// ([`crate::CHI2_MONO`] or [`crate::CHI2_STEREO`]).
    pub inliers: Vec<bool>,
    /// How the solve went.
    pub report: Report,
}

/// Minimizes the reprojection errors over all points and free cameras (local and global bundle adjustment).
///
/// Errors are capped at 1000 sigma, where they pull nothing; the same is counted for points behind their camera.
/// Without a fixed camera the damping holds the gauge; a point that its observations do not determine moves only in the
/// directions that they do; a point or camera without observation stays.
///
/// # Panics
/// When an observation names a camera or point that does not exist, or `fixed` has another length than `cameras`.
pub fn refine_bundle(problem: &BundleProblem, options: &BundleOptions) -> BundleSolution {
    refine_bundle_with(problem, options, Simd::detect())
}

/// [`refine_bundle`] with given instructions.
pub(crate) fn refine_bundle_with(
    problem: &BundleProblem,
    options: &BundleOptions,
    simd: Simd,
) -> BundleSolution {
    let model = RigModel::new(&problem.rig).with_huber(options.huber.unwrap_or(1.0));
    let edges = problem.observations.iter().map(edge);
    let graph = Graph {
        cameras: problem.cameras.iter().map(|&pose| RigCamera::new(pose)).collect(),
        fixed: problem.fixed.clone(),
        points: problem.points.iter().map(|&p| p.into()).collect(),
        edges: edges.clone().collect(),
    };
    let minimum = minimize_with(&model, graph, options, simd);
    let (chi_sq, inliers): (Vec<f64>, Vec<bool>) =
        judge(&model, edges, &minimum.cameras, &minimum.points).unzip();
    let n_inliers = inliers.iter().filter(|&&inlier| inlier).count();
    BundleSolution {
        cameras: minimum.cameras.iter().map(|camera| camera.cam_from_world).collect(),
        points: minimum.points.iter().map(|&p| Vec3::from(p)).collect(),
        chi_sq,
        inliers,
        report: Report {
            initial_cost: minimum.initial_cost,
            final_cost: minimum.final_cost,
            iterations: minimum.iterations,
            n_inliers,
            stop: minimum.stop,
        },
    }
}

impl BundleProblem {
    /// Which observations would be inliers with these poses and points, as [`BundleSolution::inliers`] says of a solution.
    ///
    /// # Panics
    /// When an observation names a camera or point that does not exist.
    pub fn inliers(&self, cameras: &[SE3], points: &[Vec3]) -> Vec<bool> {
        let cameras: Vec<RigCamera> = cameras.iter().map(|&pose| RigCamera::new(pose)).collect();
        let points: Vec<Point> = points.iter().map(|&p| p.into()).collect();
        let edges = self.observations.iter().map(edge);
        judge(&RigModel::new(&self.rig), edges, &cameras, &points).map(|(_, inlier)| inlier).collect()
    }
}

fn edge(o: &BundleObservation) -> Edge<RigObservation> {
    let observation = RigObservation::new(o.pixel.x, o.pixel.y, o.right_u, o.inv_sigma_sq);
    Edge { camera: o.camera, point: o.point, observation }
}

/// Squared error of each edge, whitened and capped, and whether it is within its limit.
fn judge(
    model: &RigModel,
    edges: impl Iterator<Item = Edge<RigObservation>>,
    cameras: &[RigCamera],
    points: &[Point],
) -> impl Iterator<Item = (f64, bool)> {
    edges.map(|Edge { camera, point, observation }| {
        let error = model.chi_sq(&cameras[camera as usize], &points[point as usize], &observation);
        let error = error.unwrap_or(MAX_CHI_SQ);
        (error, error <= observation.chi_sq_limit())
    })
}
