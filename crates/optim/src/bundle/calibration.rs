//! Bundle adjustment with the calibration of the rig among the unknowns.
//!
//! One camera tells its focal length when it turns (Hartley and Zisserman, chapter 19), a pair also by how depths from disparity
//! and from motion agree. What the images do not tell is held by a prior.

mod model;

use geometry::{SE3, Vec3};
use nalgebra::SVector;
use simd::Simd;

use super::rig::{RigCamera, RigObservation};
use super::schur::border::Border;
use super::schur::{Estimate, System};
use super::solver::Edge;
use super::structure::Structure;
use super::{BundleOptions, BundleProblem, edge};
use crate::descent::Attempt;
use crate::robust::Loss;
use model::CalibratedRig;

/// Number of unknowns of a calibration.
pub const N_CALIBRATION: usize = 6;

/// Errors of a calibration: logarithm of the factor on both focal lengths; shift of the principal point along x and y, pixels;
/// radial distortion of second order; what must be added to every disparity, pixels; roll of the right camera, radians.
pub type CalibrationVector = [f64; N_CALIBRATION];

/// A bundle adjustment that also looks for errors of the calibration.
#[derive(Clone, Debug)]
pub struct CalibrationProblem {
    /// Cameras, points and measurements.
    pub bundle: BundleProblem,
    /// Expected errors of the rig of `bundle`.
    pub expected: CalibrationVector,
    /// Standard deviations of that expectation.
    pub sigma: CalibrationVector,
}

/// A solved [`CalibrationProblem`].
#[derive(Clone, Debug)]
pub struct CalibrationSolution {
    /// Poses, cam_from_world.
    pub cameras: Vec<SE3>,
    /// Points in the world, meters.
    pub points: Vec<Vec3>,
    /// Errors of the rig.
    pub errors: CalibrationVector,
    /// Their standard deviations, the expectation included, if residuals are independent and as large as the problem says.
    pub sigma: CalibrationVector,
    /// Squared length of the errors in units of their joint uncertainty: about twice what they lower the cost by.
    pub evidence: f64,
    /// Robust cost at the start and at the end, the expectation included.
    pub cost: [f64; 2],
}

/// Minimizes reprojection errors over points, free cameras and calibration; `None` where the normal equations cannot be solved.
///
/// # Panics
/// As [`super::refine_bundle`].
pub fn refine_calibration(
    problem: &CalibrationProblem,
    options: &BundleOptions,
) -> Option<CalibrationSolution> {
    let bundle = &problem.bundle;
    let edges: Vec<Edge<RigObservation>> = bundle.observations.iter().map(edge).collect();
    let loss = if options.huber.is_some() { Loss::Huber } else { Loss::Squared };
    let (structure, matrix) = Structure::new::<6>(&bundle.fixed, bundle.points.len(), &edges);
    let mut system = System::new(structure, matrix, Simd::detect());
    let mut model = CalibratedRig::new(problem);
    let mut current = Estimate {
        cameras: bundle.cameras.iter().map(|&pose| RigCamera::new(pose)).collect::<Vec<_>>(),
        points: bundle.points.iter().map(|&p| p.into()).collect(),
    };
    let mut trial = current.clone();
    let mut cost = system.cost(&model, &current, loss).plus(model.prior_cost());
    let initial = cost.total();
    options.descent().run(|lambda| {
        system.linearize(&model, &current, loss, lambda);
        let border = Border::linearize(&system, &model, &current, loss, lambda);
        let (moved, predicted) = border.solve_step(&mut system, &model, &current, &mut trial)?;
        let (last, next) = (cost, system.cost(&moved, &trial, loss).plus(moved.prior_cost()));
        let decrease = last.decrease_to(&next);
        if decrease > 0.0 {
            std::mem::swap(&mut current, &mut trial);
            (model, cost) = (moved, next);
        }
        Some(Attempt { cost: last.total(), decrease, predicted })
    });
    system.linearize(&model, &current, loss, LEAST_DAMPING);
    let border = Border::linearize(&system, &model, &current, loss, LEAST_DAMPING);
    let normal = border.normal_matrix(&mut system)?;
    let covariance = normal.try_inverse()?;
    let errors = SVector::from(model.errors);
    Some(CalibrationSolution {
        cameras: current.cameras.iter().map(|camera| camera.cam_from_world).collect(),
        points: current.points.iter().map(|&p| Vec3::from(p)).collect(),
        errors: model.errors,
        evidence: errors.dot(&(normal * errors)),
        sigma: std::array::from_fn(|i| covariance[(i, i)].max(0.0).sqrt()),
        cost: [initial, cost.total()],
    })
}

/// Holds the scale of a single camera's map while the covariance is computed.
const LEAST_DAMPING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::common::{StreetOptions, displaced, street};

    pub(super) const ERRORS: CalibrationVector = [0.02, 4.0, -3.0, 0.02, 0.15, 0.0005];

    pub(super) fn problem(seed: u64, noise_px: f64, mono_share: f64) -> CalibrationProblem {
        let options = StreetOptions { seed, cameras: 24, points: 1500, max_track: 8, noise_px, mono_share };
        let mut bundle = street(&options);
        bundle.fixed[0] = true;
        let sigma = [0.1, 20.0, 20.0, 0.1, 1.0, 0.01];
        CalibrationProblem { bundle, expected: [0.0; N_CALIBRATION], sigma }
    }

    /// A rig that is wrong in just this way would show a point as the model says.
    fn spoiled(mut problem: CalibrationProblem) -> CalibrationProblem {
        let camera = &mut problem.bundle.rig.camera;
        camera.fx *= (-ERRORS[0]).exp();
        camera.fy *= (-ERRORS[0]).exp();
        camera.cx -= ERRORS[1];
        camera.cy -= ERRORS[2];
        problem.bundle.observations.iter_mut().for_each(|o| o.right_u += ERRORS[4]);
        problem
    }

    #[test]
    fn a_wrong_calibration_is_found_within_its_uncertainty() {
        let options = BundleOptions { max_iterations: 40, ..BundleOptions::default() };
        for (seed, mono_share, of_pair) in [(5, 0.2, true), (6, 1.0, false)] {
            let mut wrong = spoiled(problem(seed, 0.5, mono_share));
            wrong.bundle = displaced(&wrong.bundle, seed, 0.02, 0.002, 0.1);
            // Noise is half of what the measurements claim.
            let found = refine_calibration(&wrong, &options).unwrap();
            let checked = if of_pair { 5 } else { 3 };
            for i in 0..checked {
                let expected = if i == 3 { 0.0 } else { ERRORS[i] };
                let error = found.errors[i] - expected;
                assert!(error.abs() < 2.0 * found.sigma[i], "{i}: {:?} +- {:?}", found.errors, found.sigma);
            }
            // On so slow a bend one camera tells its focal length hardly at all, and says so.
            assert_eq!(found.sigma[0] < 0.01, of_pair, "{:?}", found.sigma);
            assert!(found.cost[1] < 0.5 * found.cost[0]);
        }
    }

    #[test]
    fn what_is_held_stays_and_the_rest_is_the_plain_bundle_adjustment() {
        let mut held = problem(7, 0.5, 0.2);
        held.sigma = [1e-9; N_CALIBRATION];
        held.bundle = displaced(&held.bundle, 7, 0.02, 0.002, 0.1);
        let options =
            BundleOptions { max_iterations: 40, relative_tolerance: 1e-13, ..BundleOptions::default() };
        let found = refine_calibration(&held, &options).unwrap();
        let plain = super::super::refine_bundle(&held.bundle, &options);
        assert!(found.errors.iter().all(|e| e.abs() < 1e-9), "{:?}", found.errors);
        assert!((found.cost[1] - plain.report.final_cost).abs() < 1e-6 * plain.report.final_cost);
        for (a, b) in found.cameras.iter().zip(&plain.cameras) {
            assert!((a.matrix() - b.matrix()).amax() < 1e-6);
        }
    }
}
