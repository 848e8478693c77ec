//! The covariance predicts how solutions of noisy measurements scatter.

use geometry::{Pinhole, SO3, Vec6};
use nalgebra::{DMatrix, DVector};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

/// Noise of the measurements, pixels.
const SIGMA_PX: f64 = 0.4;
/// Noisy solutions.
const N_TRIALS: u64 = 200;

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
                    let pixel = (SIGMA_PX * scale).powi(-2);
                    sights.push(Sight { view, pixel, disparity: if stereo { 16.0 * pixel } else { 0.0 } });
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

    /// The error of the last view, seen from the first one, after all measurements were made with noise and all unknowns solved for
    /// by Gauss-Newton with numeric derivatives.
    fn solved(&self, seed: u64) -> Vec6 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut noise = || {
            let u: f64 = 1.0 - random.random::<f64>();
            (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * random.random::<f64>()).cos()
        };
        let (mut views, mut points) = (self.views.clone(), self.points.clone());
        let mut measured = Vec::new();
        for (number, (point, sights)) in self.points.iter().enumerate() {
            for sight in sights {
                let roots = Vec3::new(sight.pixel, sight.pixel, sight.disparity).map(f64::sqrt);
                let whitened = self.whitened(&self.views[sight.view], point, &roots);
                let noise = Vec3::new(noise(), noise(), if roots.z > 0.0 { noise() } else { 0.0 });
                measured.push((number, sight.view, roots, whitened + noise));
            }
        }
        let n_poses = 6 * (views.len() - 1);
        for _ in 0..4 {
            let n = n_poses + 3 * points.len();
            let (mut normal, mut gradient) = (DMatrix::<f64>::zeros(n, n), DVector::<f64>::zeros(n));
            for &(number, view, roots, measured) in &measured {
                let (pose, point) = (views[view], points[number].0);
                let error = self.whitened(&pose, &point, &roots) - measured;
                let step = 1e-6;
                let mut columns = Vec::new();
                for i in 0..6 * usize::from(view > 0) {
                    let moved = SE3::exp(&(Vec6::identity_column(i) * step)) * pose;
                    let slope = (self.whitened(&moved, &point, &roots) - measured - error) / step;
                    columns.push((6 * (view - 1) + i, slope));
                }
                for i in 0..3 {
                    let moved = point + Vec3::identity_column(i) * step;
                    let slope = (self.whitened(&pose, &moved, &roots) - measured - error) / step;
                    columns.push((n_poses + 3 * number + i, slope));
                }
                for (row, a) in &columns {
                    gradient[*row] += a.dot(&error);
                    columns.iter().for_each(|(column, b)| normal[(*row, *column)] += a.dot(b));
                }
            }
            let step = normal.cholesky().unwrap().solve(&(-gradient));
            for (view, pose) in views.iter_mut().skip(1).enumerate() {
                *pose = SE3::exp(&step.fixed_rows::<6>(6 * view).into_owned()) * *pose;
            }
            for (number, (point, _)) in points.iter_mut().enumerate() {
                *point += step.fixed_rows::<3>(n_poses + 3 * number);
            }
        }
        let last = views.len() - 1;
        (views[last] * self.views[last].inverse()).log()
    }

    /// Column, row and disparity of a point, each times the root of its information.
    fn whitened(&self, view: &SE3, point: &Vec3, roots: &Vec3) -> Vec3 {
        let uvr = self.rig.project(&(*view * *point));
        Vec3::new(uvr.x, uvr.y, uvr.x - uvr.z).component_mul(roots)
    }
}

/// A column of the identity.
trait IdentityColumn {
    fn identity_column(i: usize) -> Self;
}

impl IdentityColumn for Vec6 {
    fn identity_column(i: usize) -> Self {
        Vec6::from_fn(|row, _| if row == i { 1.0 } else { 0.0 })
    }
}

impl IdentityColumn for Vec3 {
    fn identity_column(i: usize) -> Self {
        Vec3::from_fn(|row, _| if row == i { 1.0 } else { 0.0 })
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
    let drive = Drive::new(4, 40, true);
    let covariance = drive.covariance();
    let errors: Vec<Vec6> = (0..N_TRIALS).map(|seed| drive.solved(seed)).collect();
    assert_right(&scatter(&errors, &covariance));
    // A map taken for exact, so that only the frame's own noise counts, would promise far too much.
    let mut exact = Drive::new(4, 40, true);
    let sure =
        |sight: &mut Sight| (sight.pixel, sight.disparity) = (1e6 * sight.pixel, 1e6 * sight.disparity);
    exact.points.iter_mut().flat_map(|(_, sights)| sights).filter(|s| s.view < 3).for_each(sure);
    let promised = scatter(&errors, &exact.covariance());
    assert!(promised.iter().sum::<f64>() > 2.0 * 6.0, "{promised:?}");
    // Points alone unsure, but keyframes exact: errors in common would be missing.
    let mut fixed = Window::new(drive.rig, drive.views.clone());
    drive.points.iter().for_each(|(point, sights)| fixed.add(point, sights));
    (0..12).for_each(|i| fixed.normal[i][i] += 1e12);
    let promised = scatter(&errors, &fixed.marginal_of_last().unwrap());
    assert!(promised.iter().copied().fold(0.0, f64::max) > 1.6, "{promised:?}");
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
    exact.points.iter_mut().flat_map(|(_, sights)| sights).for_each(|sight| {
        sight.pixel *= 4.0;
        sight.disparity *= 4.0;
    });
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
        window.add(point, &[Sight { view: 2, pixel: 4.0, disparity: 4.0 }]);
    }
    let covariance = window.marginal_of_last().unwrap();
    assert!((covariance[(0, 0)].sqrt() - LOOSE_M).abs() < 0.1, "{covariance}");
}
