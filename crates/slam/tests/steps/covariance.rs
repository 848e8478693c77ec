//! The covariance predicts how solutions of noisy measurements scatter.

use geometry::{Pinhole, SO3, Vec2, Vec6};
use optim::{BundleObservation, BundleOptions, BundleProblem, refine_bundle};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

/// Noise of the measurements, pixels.
const SIGMA_PX: f64 = 0.4;
/// Noisy solutions.
const N_TRIALS: usize = 200;

/// A camera that drives 1 m per view along a bend, and who sees which point.
struct Drive {
    rig: StereoRig,
    views: Vec<SE3>,
    points: Vec<(Vec3, Vec<Sight>)>,
}

impl Drive {
    /// `n` views in a street of `n_points` points, each seen by some of the views, in three of four cases by both cameras.
    fn new(n: usize, n_points: usize, stereo: bool) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let camera = Pinhole { fx: 500.0, fy: 500.0, cx: 320.0, cy: 180.0 };
        let rig = StereoRig { camera, baseline_m: 0.5 };
        let step = SE3::new(SO3::exp(&Vec3::new(0.0, -0.03, 0.01)), Vec3::new(0.05, 0.0, -1.0));
        let views: Vec<SE3> =
            std::iter::successors(Some(SE3::identity()), |view| Some(step * *view)).take(n).collect();
        let mut points = Vec::new();
        while points.len() < n_points {
            let point = Vec3::new(
                random.random_range(-9.0..9.0),
                random.random_range(-3.0..2.0),
                random.random_range(6.0..30.0),
            );
            let mut sights = Vec::new();
            for (view, cam_from_world) in views.iter().enumerate() {
                let point_cam = *cam_from_world * point;
                let pixel = camera.project(&point_cam);
                let is_inside = (0.0..640.0).contains(&pixel.x) && (0.0..360.0).contains(&pixel.y);
                if point_cam.z > 2.0 && is_inside && random.random::<f64>() < 0.8 {
                    let scale = 1.2_f64.powi(random.random_range(0..4));
                    let stereo = stereo && random.random::<f64>() < 0.75;
                    sights.push(Sight { view, information: (SIGMA_PX * scale).powi(-2), stereo });
                }
            }
            if sights.len() > 1 {
                points.push((point, sights));
            }
        }
        Drive { rig, views, points }
    }

    fn covariance(&self) -> Mat6 {
        let mut window = Window::new(self.rig, self.views.clone());
        self.points.iter().for_each(|(point, sights)| window.add(point, sights));
        window.marginal_of_last().unwrap()
    }

    /// The error of the last view, seen from the first one, after all measurements were made with noise and all unknowns solved for.
    fn solved(&self, seed: u64, is_fixed: impl Fn(usize) -> bool) -> Vec6 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut noise = |sigma: f64| {
            let u: f64 = 1.0 - random.random::<f64>();
            sigma * (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * random.random::<f64>()).cos()
        };
        let mut observations = Vec::new();
        for (number, (point, sights)) in (0..).zip(&self.points) {
            for sight in sights {
                let uvr = self.rig.project(&(self.views[sight.view] * *point));
                let sigma = sight.information.powf(-0.5);
                let pixel = Vec2::new(uvr.x + noise(sigma), uvr.y + noise(sigma));
                let right_u = if sight.stereo { uvr.z + noise(sigma) } else { f64::NAN };
                let (camera, inv_sigma_sq) = (sight.view as u32, sight.information);
                observations.push(BundleObservation { camera, point: number, pixel, right_u, inv_sigma_sq });
            }
        }
        let problem = BundleProblem {
            rig: self.rig,
            cameras: self.views.clone(),
            fixed: (0..self.views.len()).map(is_fixed).collect(),
            points: self.points.iter().map(|(point, _)| *point).collect(),
            observations,
        };
        let options = BundleOptions { max_iterations: 20, robust: false, ..BundleOptions::default() };
        let last = self.views.len() - 1;
        (refine_bundle(&problem, &options).cameras[last] * self.views[last].inverse()).log()
    }
}

/// Eigenvalues of the scatter in units of the covariance: all 1 where it is right.
fn scatter(errors: &[Vec6], covariance: &Mat6) -> Vec<f64> {
    let whiten = covariance.cholesky().unwrap().l().try_inverse().unwrap();
    let sum: Mat6 = errors.iter().map(|e| (whiten * e) * (whiten * e).transpose()).sum();
    (sum / errors.len() as f64).symmetric_eigenvalues().iter().copied().collect()
}

/// Ends of the eigenvalues of a scatter of 200 draws in 6 dimensions are 0.68 and 1.38 (Marchenko and Pastur).
fn assert_right(eigenvalues: &[f64]) {
    assert!(eigenvalues.iter().all(|v| (0.6..1.6).contains(v)), "{eigenvalues:?}");
}

#[test]
fn solutions_of_noisy_drives_scatter_as_predicted() {
    let drive = Drive::new(5, 150, true);
    let covariance = drive.covariance();
    let errors: Vec<Vec6> = (0..N_TRIALS as u64).map(|seed| drive.solved(seed, |view| view == 0)).collect();
    assert_right(&scatter(&errors, &covariance));
    // With the map taken for exact, as if only the frame's own noise counted, it would be far too small.
    let mut own = Mat6::zeros();
    for (point, sights) in &drive.points {
        for sight in sights.iter().filter(|sight| sight.view == 4) {
            let point_cam = drive.views[4] * *point;
            let by_pose = by_pose(&drive.rig, &point_cam);
            let right = if sight.stereo { sight.information } else { 0.0 };
            let weights = Vec3::new(sight.information, sight.information, right);
            own += by_pose.transpose() * Mat3::from_diagonal(&weights) * by_pose;
        }
    }
    let too_small = scatter(&errors, &own.try_inverse().unwrap());
    assert!(too_small.iter().all(|v| *v > 1.6), "{too_small:?}");
}

/// Numeric, so that it does not share a mistake with what is tested.
fn by_pose(rig: &StereoRig, point_cam: &Vec3) -> nalgebra::SMatrix<f64, 3, 6> {
    let step = 1e-6;
    let columns: Vec<Vec3> = (0..6)
        .map(|i| {
            let mut tangent = Vec6::zeros();
            tangent[i] = step;
            (rig.project(&(SE3::exp(&tangent) * *point_cam)) - rig.project(point_cam)) / step
        })
        .collect();
    nalgebra::SMatrix::<f64, 3, 6>::from_columns(&columns)
}

/// One camera: lengths hold by two keyframes, which then are as good as fixed to each other.
#[test]
fn one_camera_takes_lengths_from_two_keyframes() {
    let drive = Drive::new(4, 150, false);
    let mut window = Window::new(drive.rig, drive.views.clone());
    drive.points.iter().for_each(|(point, sights)| window.add(point, sights));
    let free = window.marginal_of_last().unwrap();
    window.hold_distance(1, 2);
    let held = window.marginal_of_last().unwrap();
    // Without scale the camera may be anywhere along its way; with it, it is within millimeters to centimeters.
    assert!(free[(2, 2)].sqrt() > 1.0 && held[(2, 2)].sqrt() < 0.05, "{free} {held}");
    assert!((free[(4, 4)] / held[(4, 4)] - 1.0).abs() < 0.3, "angles do not depend on it");
}

#[test]
fn more_keyframes_and_less_noise_make_it_smaller() {
    let (drive, mut exact) = (Drive::new(5, 150, true), Drive::new(5, 150, true));
    exact.points.iter_mut().flat_map(|(_, sights)| sights).for_each(|sight| sight.information *= 4.0);
    let ratio = drive.covariance().component_div(&exact.covariance());
    assert!((0..6).all(|i| (ratio[(i, i)] - 4.0).abs() < 0.1), "{ratio}");
    let mut fewer = Drive::new(5, 150, true);
    fewer.points.iter_mut().for_each(|(_, sights)| sights.retain(|sight| sight.view != 2));
    let gain = fewer.covariance().component_div(&drive.covariance());
    assert!((0..6).all(|i| gain[(i, i)] > 1.0), "{gain}");
}

#[test]
fn what_nothing_determines_stays_loose() {
    let drive = Drive::new(3, 20, true);
    let window = Window::new(drive.rig, drive.views.clone());
    let covariance = window.marginal_of_last().unwrap();
    assert!((covariance[(0, 0)].sqrt() - LOOSE_M).abs() < 1e-6, "no observations: {covariance}");
    // Points that one view alone sees say nothing.
    let mut window = Window::new(drive.rig, drive.views.clone());
    for (point, _) in &drive.points {
        window.add(point, &[Sight { view: 2, information: 4.0, stereo: true }]);
    }
    let covariance = window.marginal_of_last().unwrap();
    assert!((covariance[(0, 0)].sqrt() - LOOSE_M).abs() < 0.1, "{covariance}");
}
