//! Bundle adjustment with the calibration of the rig among the unknowns.
//!
//! One camera tells its focal length when it turns (Hartley and Zisserman, chapter 19), a pair also by how depths from disparity
//! and from motion agree. What the images do not tell is held by a prior.

use geometry::{SE3, Vec3};
use nalgebra::SVector;
use simd::Simd;

use super::model::{Linearization, ObservationModel, Point};
use super::rig::{MIN_DEPTH_M, RigCamera, RigObservation};
use super::schur::border::{Border, Rows, SharedModel};
use super::schur::{Estimate, System};
use super::solver::{Damping, Edge};
use super::structure::Structure;
use super::{BundleOptions, BundleProblem, edge};
use crate::robust::{Loss, MAX_CHI_SQ, NEGLIGIBLE_DECREASE};

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
    let loss = if options.robust { Loss::Huber } else { Loss::Squared };
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
    let mut damping = Damping::new(options.initial_damping);
    for _ in 0..options.max_iterations {
        system.linearize(&model, &current, loss, damping.lambda);
        let border = Border::linearize(&system, &model, &current, loss, damping.lambda);
        let mut is_down = false;
        if let Some((moved, predicted)) = border.solve_step(&mut system, &model, &current, &mut trial) {
            let next = system.cost(&moved, &trial, loss).plus(moved.prior_cost());
            let decrease = cost.decrease_to(&next);
            let small = options.relative_tolerance.max(f64::EPSILON) * cost.total();
            is_down = decrease > 0.0;
            if is_down {
                std::mem::swap(&mut current, &mut trial);
                (model, cost) = (moved, next);
                damping.accept(decrease / predicted);
            }
            if predicted <= small.max(NEGLIGIBLE_DECREASE) {
                break;
            }
        }
        if !is_down && !damping.raise() {
            break;
        }
    }
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

/// The rig with errors of its calibration.
#[derive(Clone, Copy, Debug)]
struct CalibratedRig {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    baseline_m: f64,
    errors: CalibrationVector,
    expected: CalibrationVector,
    information: CalibrationVector,
}

/// What a point is seen as, and what that is made from.
struct Seen {
    p: [f64; 3],
    inv_z: f64,
    /// Normalized places in the left and the right image: x, y and the column on the right.
    x: f64,
    y: f64,
    right_x: f64,
    r: [f64; 3],
    chi_sq: f64,
}

impl CalibratedRig {
    fn new(problem: &CalibrationProblem) -> Self {
        let rig = &problem.bundle.rig;
        let c = &rig.camera;
        Self {
            fx: c.fx,
            fy: c.fy,
            cx: c.cx,
            cy: c.cy,
            baseline_m: rig.baseline_m,
            errors: [0.0; N_CALIBRATION],
            expected: problem.expected,
            information: problem.sigma.map(|sigma| 1.0 / (sigma * sigma)),
        }
    }

    fn prior_cost(&self) -> f64 {
        let terms =
            (0..N_CALIBRATION).map(|i| self.information[i] * (self.errors[i] - self.expected[i]).powi(2));
        0.5 * terms.sum::<f64>()
    }

    fn focal(&self) -> (f64, f64) {
        let factor = self.errors[0].exp();
        (self.fx * factor, self.fy * factor)
    }

    #[inline(always)]
    fn see(&self, camera: &RigCamera, point: &Point, o: &RigObservation) -> Option<Seen> {
        let p = camera.transform(point);
        if !(p[2] > MIN_DEPTH_M) {
            return None;
        }
        let [_, dcx, dcy, k1, offset, roll] = self.errors;
        let (fx, fy) = self.focal();
        let inv_z = 1.0 / p[2];
        let (x, y) = (p[0] * inv_z, p[1] * inv_z);
        let right_x = x - self.baseline_m * inv_z;
        let radial = 1.0 + k1 * (x * x + y * y);
        let right_radial = 1.0 + k1 * (right_x * right_x + y * y);
        let r = o.residual([
            fx * x * radial + self.cx + dcx,
            fy * y * radial + self.cy + dcy,
            fx * (right_x * right_radial + roll * y) + self.cx + dcx + offset,
        ]);
        let [w, _, w_right] = o.information();
        let chi_sq = w * (r[0] * r[0] + r[1] * r[1]) + w_right * (r[2] * r[2]);
        (chi_sq <= MAX_CHI_SQ).then_some(Seen { p, inv_z, x, y, right_x, r, chi_sq })
    }
}

impl ObservationModel<6> for CalibratedRig {
    type Camera = RigCamera;
    type Observation = RigObservation;

    fn moved(&self, camera: &RigCamera, step: &[f64; 6]) -> RigCamera {
        camera.moved(step)
    }

    #[inline(always)]
    fn chi_sq(&self, camera: &RigCamera, point: &Point, observation: &RigObservation) -> Option<f64> {
        self.see(camera, point, observation).map(|seen| seen.chi_sq)
    }

    #[inline(always)]
    fn delta_sq(&self, observation: &RigObservation) -> f64 {
        observation.chi_sq_limit()
    }

    #[inline(always)]
    fn linearize(
        &self,
        camera: &RigCamera,
        point: &Point,
        observation: &RigObservation,
        loss: Loss,
    ) -> Option<Linearization<6>> {
        let rows = self.rows(camera, point, observation, loss)?;
        Some(Linearization::from_jacobians(&rows.residual, &rows.by_camera, &rows.by_point, 1.0))
    }
}

impl SharedModel<6, N_CALIBRATION> for CalibratedRig {
    #[inline(always)]
    fn rows(
        &self,
        camera: &RigCamera,
        point: &Point,
        o: &RigObservation,
        loss: Loss,
    ) -> Option<Rows<6, N_CALIBRATION>> {
        let Seen { p, inv_z, x, y, right_x, r, chi_sq } = self.see(camera, point, o)?;
        let root = o.information().map(|w| (w * loss.weight(chi_sq, o.chi_sq_limit())).sqrt());
        let [.., k1, _, roll] = self.errors;
        let (fx, fy) = self.focal();
        let (r_sq, right_r_sq) = (x * x + y * y, right_x * right_x + y * y);
        let (radial, right_radial) = (1.0 + k1 * r_sq, 1.0 + k1 * right_r_sq);
        let mixed = 2.0 * k1 * y;
        // By the normalized place (column of its own image, row).
        let by_place = [
            [fx * (radial + 2.0 * k1 * x * x), fx * mixed * x],
            [fy * mixed * x, fy * (radial + mixed * y)],
            [fx * (right_radial + 2.0 * k1 * right_x * right_x), fx * (mixed * right_x + roll)],
        ];
        let by_point_cam: [[f64; 3]; 3] = std::array::from_fn(|row| {
            let [a, b] = by_place[row];
            let column = if row == 2 { right_x } else { x };
            [a * inv_z, b * inv_z, -(a * column + b * y) * inv_z]
        });
        let by_errors = [
            [fx * x * radial, 1.0, 0.0, fx * x * r_sq, 0.0, 0.0],
            [fy * y * radial, 0.0, 1.0, fy * y * r_sq, 0.0, 0.0],
            [fx * (right_x * right_radial + roll * y), 1.0, 0.0, fx * right_x * right_r_sq, 1.0, fx * y],
        ];
        Some(Rows {
            residual: std::array::from_fn(|row| root[row] * r[row]),
            by_camera: std::array::from_fn(|row| {
                let [a, b, c] = by_point_cam[row].map(|v| root[row] * v);
                [a, b, c, p[1] * c - p[2] * b, p[2] * a - p[0] * c, p[0] * b - p[1] * a]
            }),
            by_point: std::array::from_fn(|row| {
                camera.turned_back(&by_point_cam[row].map(|v| root[row] * v))
            }),
            by_shared: std::array::from_fn(|row| by_errors[row].map(|v| root[row] * v)),
        })
    }

    fn prior(&self) -> [(f64, f64); N_CALIBRATION] {
        std::array::from_fn(|i| {
            (self.information[i] * (self.errors[i] - self.expected[i]), self.information[i])
        })
    }

    fn shared_moved(&self, step: &[f64; N_CALIBRATION]) -> Self {
        Self { errors: std::array::from_fn(|i| self.errors[i] + step[i]), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::common::{StreetOptions, displaced, street};

    const ERRORS: CalibrationVector = [0.02, 4.0, -3.0, 0.02, 0.15, 0.0005];

    fn problem(seed: u64, noise_px: f64, mono_share: f64) -> CalibrationProblem {
        let options = StreetOptions { seed, cameras: 24, points: 1500, max_track: 8, noise_px, mono_share };
        let mut bundle = street(&options);
        bundle.fixed[0] = true;
        let sigma = [0.1, 20.0, 20.0, 0.1, 1.0, 0.01];
        CalibrationProblem { bundle, expected: [0.0; N_CALIBRATION], sigma }
    }

    #[test]
    fn derivatives_equal_differences() {
        let whole = problem(3, 0.5, 0.3);
        let model = CalibratedRig { errors: ERRORS, ..CalibratedRig::new(&whole) };
        let mut n_compared = 0;
        for o in whole.bundle.observations.iter().step_by(97) {
            let camera = RigCamera::new(whole.bundle.cameras[o.camera as usize]);
            let point: Point = whole.bundle.points[o.point as usize].into();
            let observation = edge(o).observation;
            let at = |model: &CalibratedRig, camera: &RigCamera, point: &Point| {
                model.rows(camera, point, &observation, Loss::Squared).unwrap()
            };
            let rows = at(&model, &camera, &point);
            let compare = |analytic: &dyn Fn(usize) -> f64, plus: [f64; 3], minus: [f64; 3], h: f64| {
                for row in 0..3 {
                    let numeric = (plus[row] - minus[row]) / (2.0 * h);
                    let analytic = analytic(row);
                    assert!(
                        (numeric - analytic).abs() < 1e-4 * (1.0 + analytic.abs()),
                        "{numeric} {analytic}"
                    );
                }
            };
            for i in 0..6 {
                let h = 1e-5;
                let step = |h: f64| std::array::from_fn(|k| if k == i { h } else { 0.0 });
                let moved = |h: f64| at(&model, &camera.moved(&step(h)), &point).residual;
                compare(&|row| rows.by_camera[row][i], moved(h), moved(-h), h);
                let changed = |h: f64| at(&model.shared_moved(&step(h)), &camera, &point).residual;
                compare(&|row| rows.by_shared[row][i], changed(h), changed(-h), h);
                if i < 3 {
                    let shifted = |h: f64| {
                        let mut point = point;
                        point[i] += h;
                        at(&model, &camera, &point).residual
                    };
                    compare(&|row| rows.by_point[row][i], shifted(h), shifted(-h), h);
                }
                n_compared += 1;
            }
        }
        assert!(n_compared > 300, "{n_compared}");
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
