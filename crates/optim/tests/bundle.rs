//! Bundle adjustment on synthetic streets: known answers and laws.

mod common;

use common::{StreetOptions, cost, displaced, normal_vec3, pose_difference, random, small_motion, street};
use dsslam_optim::{
    BundleOptions, BundleProblem, BundleSolution, CHI2_MONO, CHI2_STEREO, StopReason, refine_bundle,
};
use geometry::SE3;
use rand::seq::SliceRandom;

const STREET: StreetOptions =
    StreetOptions { seed: 1, cameras: 12, points: 600, max_track: 6, noise_px: 0.5, mono_share: 0.2 };

fn to_convergence(robust: bool) -> BundleOptions {
    BundleOptions {
        max_iterations: 100,
        huber: robust.then_some(1.0),
        relative_tolerance: 1e-13,
        ..Default::default()
    }
}

/// A street with two fixed cameras, so that scale is held even where no right measurement does.
fn anchored(options: &StreetOptions) -> BundleProblem {
    let mut problem = street(options);
    problem.fixed[..2].fill(true);
    problem
}

fn worst_pose(a: &[SE3], b: &[SE3]) -> (f64, f64) {
    a.iter().zip(b).map(|(a, b)| pose_difference(a, b)).fold((0.0, 0.0), |w, d| (w.0.max(d.0), w.1.max(d.1)))
}

/// Assertion on all poses and points.
fn assert_same(a: &BundleSolution, cameras: &[SE3], points: &[geometry::Vec3], tolerance_m: f64) {
    let (meters, radians) = worst_pose(&a.cameras, cameras);
    assert!(meters < tolerance_m && radians < tolerance_m, "{meters} m, {radians} rad");
    for (i, (a, b)) in a.points.iter().zip(points).enumerate() {
        assert!((a - b).norm() < tolerance_m * (1.0 + b.norm()), "point {i}: {a} {b}");
    }
}

#[test]
fn a_displaced_street_without_noise_returns_to_rounding() {
    let truth = anchored(&StreetOptions { noise_px: 0.0, ..STREET });
    let problem = displaced(&truth, 2, 0.05, 0.005, 0.2);
    let (meters, radians) = worst_pose(&problem.cameras, &truth.cameras);
    assert!(meters > 0.05 && radians > 0.005, "not displaced: {meters} m, {radians} rad");
    let solution = refine_bundle(&problem, &to_convergence(true));
    // Rounding of pixels, 1e-13 of 1000 px, times depth over baseline and focal length.
    assert_same(&solution, &truth.cameras, &truth.points, 1e-8);
    assert_eq!(solution.report.n_inliers, problem.observations.len());
}

#[test]
fn with_noise_the_cost_is_chi_square_distributed_and_below_the_truth() {
    let truth = anchored(&STREET);
    let problem = displaced(&truth, 3, 0.05, 0.005, 0.2);
    let solution = refine_bundle(&problem, &to_convergence(false));
    let scale = 1.0 / (STREET.noise_px * STREET.noise_px);
    let n_residuals: usize = truth.observations.iter().map(|o| if o.right_u.is_nan() { 2 } else { 3 }).sum();
    let n_free = 6 * (STREET.cameras - 2) + 3 * STREET.points;
    let freedom = (n_residuals - n_free) as f64;
    let chi_sq = 2.0 * scale * solution.report.final_cost;
    assert!((chi_sq - freedom).abs() < 4.0 * (2.0 * freedom).sqrt(), "{chi_sq} of {freedom}");
    let at_truth = cost(&truth.rig, &truth.cameras, &truth.points, &truth.observations, false);
    assert!(solution.report.final_cost < at_truth);
    assert!(solution.report.initial_cost > 10.0 * at_truth, "not displaced");
}

#[test]
fn moving_the_world_moves_the_solution_along() {
    let problem = displaced(&anchored(&STREET), 4, 0.03, 0.003, 0.1);
    let old_from_new = small_motion(&mut random(5), 20.0, 1.0);
    let mut moved = problem.clone();
    moved.cameras.iter_mut().for_each(|camera| *camera = *camera * old_from_new);
    moved.points.iter_mut().for_each(|point| *point = old_from_new.inverse() * *point);
    let solution = refine_bundle(&problem, &to_convergence(true));
    let cameras: Vec<_> = solution.cameras.iter().map(|camera| *camera * old_from_new).collect();
    let points: Vec<_> = solution.points.iter().map(|point| old_from_new.inverse() * *point).collect();
    let of_moved = refine_bundle(&moved, &to_convergence(true));
    // Two descents to the same minimum stop within sqrt(tolerance * cost / curvature) of it.
    assert_same(&of_moved, &cameras, &points, 1e-5);
    assert!((of_moved.report.final_cost / solution.report.final_cost - 1.0).abs() < 1e-10);
}

#[test]
fn the_order_of_observations_does_not_matter() {
    let problem = displaced(&anchored(&STREET), 6, 0.03, 0.003, 0.1);
    let mut shuffled = problem.clone();
    shuffled.observations.shuffle(&mut random(7));
    assert_ne!(shuffled.observations, problem.observations);
    let (a, b) =
        (refine_bundle(&problem, &Default::default()), refine_bundle(&shuffled, &Default::default()));
    assert_same(&a, &b.cameras, &b.points, 1e-12);
}

#[test]
fn the_order_of_cameras_and_points_does_not_matter() {
    let problem = displaced(&anchored(&STREET), 6, 0.03, 0.003, 0.1);
    let mut reversed = problem.clone();
    reversed.cameras.reverse();
    reversed.fixed.reverse();
    reversed.points.reverse();
    for o in &mut reversed.observations {
        o.camera = problem.cameras.len() as u32 - 1 - o.camera;
        o.point = problem.points.len() as u32 - 1 - o.point;
    }
    let a = refine_bundle(&problem, &Default::default());
    let mut b = refine_bundle(&reversed, &Default::default());
    b.cameras.reverse();
    b.points.reverse();
    assert_same(&a, &b.cameras, &b.points, 1e-9);
}

#[test]
fn hubers_loss_resists_outliers_that_spoil_least_squares() {
    let mut truth = anchored(&STREET);
    let wrong: Vec<usize> = (0..truth.observations.len()).step_by(20).collect();
    for &i in &wrong {
        truth.observations[i].pixel.x += 60.0;
    }
    let problem = displaced(&truth, 8, 0.03, 0.003, 0.1);
    let robust = refine_bundle(&problem, &to_convergence(true));
    let plain = refine_bundle(&problem, &to_convergence(false));
    let (robust_m, plain_m) =
        (worst_pose(&robust.cameras, &truth.cameras).0, worst_pose(&plain.cameras, &truth.cameras).0);
    assert!(robust_m < 0.1 * plain_m, "{robust_m} m against {plain_m} m");
    for &i in &wrong {
        let limit = if truth.observations[i].right_u.is_nan() { CHI2_MONO } else { CHI2_STEREO };
        assert!(robust.chi_sq[i] > limit, "observation {i} passes as good");
    }
}

#[test]
fn the_report_tells_what_the_definitions_give() {
    let mut problem = displaced(&anchored(&STREET), 9, 0.03, 0.003, 0.1);
    problem.observations[17].pixel.y -= 40.0;
    let BundleProblem { rig, observations, .. } = &problem;
    for robust in [false, true] {
        let solution =
            refine_bundle(&problem, &BundleOptions { huber: robust.then_some(1.0), ..Default::default() });
        let before = cost(rig, &problem.cameras, &problem.points, observations, robust);
        let after = cost(rig, &solution.cameras, &solution.points, observations, robust);
        assert!((solution.report.initial_cost / before - 1.0).abs() < 1e-12);
        assert!((solution.report.final_cost / after - 1.0).abs() < 1e-12);
        let mut n_inliers = 0;
        for (i, o) in observations.iter().enumerate() {
            let (camera, point) = (&solution.cameras[o.camera as usize], &solution.points[o.point as usize]);
            let expected = common::chi_sq(rig, camera, point, o).unwrap();
            assert!((solution.chi_sq[i] - expected).abs() < 1e-9 * (1.0 + expected));
            let inlier = expected <= if o.right_u.is_nan() { CHI2_MONO } else { CHI2_STEREO };
            assert_eq!(solution.inliers[i], inlier);
            n_inliers += usize::from(inlier);
        }
        assert_eq!(problem.inliers(&solution.cameras, &solution.points), solution.inliers);
        assert_eq!(solution.report.n_inliers, n_inliers);
        assert!(solution.report.iterations > 1 && solution.report.iterations <= 10);
    }
}

#[test]
fn a_limit_on_iterations_is_kept_and_told() {
    let problem = displaced(&anchored(&STREET), 10, 0.05, 0.005, 0.2);
    let limited = |max_iterations| {
        refine_bundle(&problem, &BundleOptions { max_iterations, ..Default::default() }).report
    };
    for n in 0..4 {
        let report = limited(n);
        assert_eq!((report.iterations, report.stop), (n, StopReason::IterationLimit));
    }
    assert_eq!(limited(0).final_cost, limited(0).initial_cost);
    assert!(limited(2).final_cost < limited(1).final_cost);
    assert_eq!(limited(100).stop, StopReason::Converged);
}

#[test]
fn a_long_loop_of_cameras_is_solved_through_its_sparse_factor() {
    let truth = anchored(&StreetOptions { cameras: 150, points: 3000, noise_px: 0.0, seed: 11, ..STREET });
    let mut closed = truth.clone();
    // The last cameras see points of the first ones: as in a revisit, far off the band.
    let mut random = random(12);
    for point in 0..40 {
        let p = truth.cameras[140].inverse()
            * (normal_vec3(&mut random, 1.0) + geometry::Vec3::new(0.0, 0.0, 12.0));
        let q = truth.rig.project(&(truth.cameras[140] * p));
        let o = dsslam_optim::BundleObservation {
            camera: 140,
            point: closed.points.len() as u32,
            pixel: geometry::Vec2::new(q.x, q.y),
            right_u: q.z,
            inv_sigma_sq: 1.0,
        };
        closed.observations.push(o);
        let far = dsslam_optim::BundleObservation { camera: 5 + point % 10, ..o };
        let q = truth.rig.project(&(truth.cameras[far.camera as usize] * p));
        closed.observations.push(dsslam_optim::BundleObservation {
            pixel: geometry::Vec2::new(q.x, q.y),
            right_u: q.z,
            ..far
        });
        closed.points.push(p);
    }
    let problem = displaced(&closed, 13, 0.02, 0.001, 0.1);
    let solution = refine_bundle(&problem, &to_convergence(false));
    assert_same(&solution, &closed.cameras, &closed.points, 1e-5);
}
