//! Motion-only optimization on synthetic frames.

mod common;

use common::{frame, normal_vec3, numeric_normal, pose_difference, random, rig, small_motion};
use dsslam_optim::{
    CHI2_MONO, CHI2_STEREO, PoseObservation, PoseOptions, PoseSolution, StopReason, refine_pose,
};
use geometry::{SE3, Vec2, Vec3, Vec6};
use proptest::prelude::*;

fn refine(initial: SE3, observations: &[PoseObservation]) -> PoseSolution {
    refine_pose(&rig(), initial, observations, &PoseOptions::default())
}

/// Plain least squares over all observations.
fn least_squares(initial: SE3, observations: &[PoseObservation]) -> SE3 {
    let options = PoseOptions { limit_factor: 1e12, plain_tolerance: 1e-14, max_iterations: 50 };
    refine_pose(&rig(), initial, observations, &options).cam_from_world
}

/// Conformance check: 200 points, half of them grossly wrong.
#[test]
fn with_half_the_points_wrong_the_pose_is_within_three_sigma_of_least_squares_on_the_right_ones() {
    for seed in 0..40 {
        let mono_share = f64::from((seed % 3) as u8) / 2.0;
        let (truth, observations) = frame(seed, 200, 1.0, 0.5, mono_share);
        let initial = small_motion(&mut random(seed + 1000), 0.2, 0.02) * truth;
        let (meters, radians) = pose_difference(&initial, &truth);
        assert!(meters > 0.03 && radians > 0.003, "not displaced");

        let right = &observations[100..];
        let expected = least_squares(truth, right);
        let (information, gradient) = numeric_normal(&rig(), &expected, right);
        let covariance = information.try_inverse().unwrap();
        assert!((covariance * gradient).norm() < 1e-6, "least squares has not converged");

        let solution = refine(initial, &observations);
        let d = (solution.cam_from_world * expected.inverse()).log();
        for k in 0..6 {
            let sigma = covariance[(k, k)].sqrt();
            assert!(d[k].abs() < 3.0 * sigma, "seed {seed}, component {k}: {} of sigma {sigma}", d[k]);
        }
        let n_kept = solution.inliers[100..].iter().filter(|&&i| i).count();
        let n_wrong = solution.inliers[..100].iter().filter(|&&i| i).count();
        assert!(n_kept >= 85 && n_wrong <= 5, "seed {seed}: {n_kept} right, {n_wrong} wrong ones kept");
    }
}

#[test]
fn without_noise_the_pose_returns_to_rounding() {
    for seed in 0..10 {
        let (truth, observations) = frame(seed, 60, 0.0, 0.0, 0.5);
        let initial = small_motion(&mut random(seed + 50), 0.3, 0.03) * truth;
        let solution = refine(initial, &observations);
        let (meters, radians) = pose_difference(&solution.cam_from_world, &truth);
        assert!(meters < 1e-9 && radians < 1e-10, "{meters} m, {radians} rad");
        assert!(solution.inliers.iter().all(|&i| i));
        assert_eq!(solution.report.stop, StopReason::Converged);
    }
}

#[test]
fn moving_the_world_moves_the_pose_along() {
    let (truth, observations) = frame(3, 150, 1.0, 0.2, 0.4);
    let initial = small_motion(&mut random(4), 0.1, 0.01) * truth;
    let old_from_new = small_motion(&mut random(5), 30.0, 1.0);
    let moved: Vec<_> = observations
        .iter()
        .map(|o| PoseObservation { point_world: old_from_new.inverse() * o.point_world, ..*o })
        .collect();
    let (a, b) = (refine(initial, &observations), refine(initial * old_from_new, &moved));
    let (meters, radians) = pose_difference(&(a.cam_from_world * old_from_new), &b.cam_from_world);
    assert!(meters < 1e-10 && radians < 1e-11, "{meters} m, {radians} rad");
    assert_eq!(a.inliers, b.inliers);
}

/// The unused lanes of the last pack hold the world's origin, which may lie behind the camera.
#[test]
fn an_origin_behind_the_camera_disturbs_nothing() {
    let (truth, observations) = frame(3, 41, 0.0, 0.0, 0.5);
    for z in [-50.0, 0.0, 50.0] {
        let new_from_old = SE3::new(truth.rotation, truth.translation - Vec3::new(0.0, 0.0, z));
        let moved: Vec<_> = observations
            .iter()
            .map(|o| PoseObservation { point_world: new_from_old * o.point_world, ..*o })
            .collect();
        let truth = SE3::new(SE3::identity().rotation, Vec3::new(0.0, 0.0, z));
        let solution = refine(small_motion(&mut random(4), 0.1, 0.01) * truth, &moved);
        assert!(pose_difference(&solution.cam_from_world, &truth).0 < 1e-8, "{:?}", solution.report);
    }
}

#[test]
fn the_order_of_observations_does_not_matter() {
    let (truth, observations) = frame(6, 151, 1.0, 0.2, 0.4);
    let initial = small_motion(&mut random(7), 0.1, 0.01) * truth;
    let reversed: Vec<_> = observations.iter().rev().copied().collect();
    let (a, b) = (refine(initial, &observations), refine(initial, &reversed));
    let (meters, radians) = pose_difference(&a.cam_from_world, &b.cam_from_world);
    assert!(meters < 1e-9 && radians < 1e-10, "{meters} m, {radians} rad");
    assert!(a.inliers.iter().rev().eq(b.inliers.iter()));
}

#[test]
fn the_report_tells_what_the_definitions_give() {
    let (truth, observations) = frame(8, 120, 1.0, 0.3, 0.5);
    let initial = small_motion(&mut random(9), 0.05, 0.005) * truth;
    let solution = refine(initial, &observations);
    let (mut before, mut after) = (0.0, 0.0);
    for (o, &is_inlier) in observations.iter().zip(&solution.inliers) {
        let at = |pose: &SE3| common::chi_sq(&rig(), pose, &o.point_world, &common::as_bundle(o));
        let limit = if o.right_u.is_nan() { CHI2_MONO } else { CHI2_STEREO };
        assert_eq!(is_inlier, at(&solution.cam_from_world).is_some_and(|c| c <= limit));
        if is_inlier {
            before += 0.5 * at(&initial).unwrap();
            after += 0.5 * at(&solution.cam_from_world).unwrap();
        }
    }
    let report = solution.report;
    assert!(
        (report.initial_cost / before - 1.0).abs() < 1e-12 && (report.final_cost / after - 1.0).abs() < 1e-12
    );
    assert_eq!(report.n_inliers, solution.inliers.iter().filter(|&&i| i).count());
    assert!(report.iterations >= 3);
}

#[test]
fn an_outlier_at_the_prediction_returns() {
    let (truth, observations) = frame(10, 100, 0.5, 0.0, 0.0);
    let initial = small_motion(&mut random(11), 0.3, 0.05) * truth;
    let n_at_start = observations
        .iter()
        .filter(|o| {
            common::chi_sq(&rig(), &initial, &o.point_world, &common::as_bundle(o)).is_some_and(|c| c < 25.0)
        })
        .count();
    assert!(n_at_start < 10, "the prediction is too good for this test: {n_at_start}");
    assert!(refine(initial, &observations).report.n_inliers > 95);
}

#[test]
fn points_behind_the_camera_and_broken_numbers_are_outliers() {
    let (truth, mut observations) = frame(12, 80, 0.0, 0.0, 0.3);
    let world_from_cam = truth.inverse();
    observations[0].point_world = world_from_cam * Vec3::new(0.5, 0.2, -6.0);
    observations[1].point_world = truth.center();
    observations[2].point_world.x = f64::NAN;
    observations[3].pixel.y = f64::INFINITY;
    observations[4].inv_sigma_sq = 0.0;
    observations[5].inv_sigma_sq = f64::NAN;
    observations[6].point_world = world_from_cam * Vec3::new(1e300, 0.0, 1.0);
    let solution = refine(small_motion(&mut random(13), 0.1, 0.01) * truth, &observations);
    let (meters, radians) = pose_difference(&solution.cam_from_world, &truth);
    assert!(meters < 1e-8 && radians < 1e-9, "{meters} m, {radians} rad");
    assert!(solution.inliers[..7].iter().all(|&i| !i) && solution.inliers[7..].iter().all(|&i| i));
    assert!(solution.report.final_cost.is_finite() && solution.report.initial_cost.is_finite());
}

#[test]
fn too_few_observations_return_the_prediction() {
    let (truth, observations) = frame(14, 5, 0.0, 0.0, 0.0);
    for n in 0..=5 {
        let solution = refine(truth, &observations[..n]);
        assert_eq!(solution.cam_from_world, truth);
        assert_eq!((solution.report.stop, solution.report.iterations), (StopReason::NoData, 0));
        assert_eq!(solution.report.n_inliers, n);
    }
    let lost = SE3::new(truth.rotation, Vec3::new(f64::NAN, 0.0, 0.0));
    assert_eq!(refine(lost, &frame(14, 50, 0.0, 0.0, 0.0).1).report.stop, StopReason::NoData);
}

#[test]
fn one_point_seen_many_times_gives_a_finite_pose() {
    let point_world = Vec3::new(1.0, 0.5, 8.0);
    let pixel = rig().project(&point_world) + Vec3::new(3.0, 1.0, 3.0);
    let observation = PoseObservation {
        point_world,
        pixel: Vec2::new(pixel.x, pixel.y),
        right_u: pixel.z,
        inv_sigma_sq: 1.0,
    };
    let solution = refine(SE3::identity(), &[observation; 20]);
    assert!(solution.cam_from_world.is_finite());
    assert!(solution.report.final_cost < 1e-9, "{:?}", solution.report);
    assert!(solution.cam_from_world.log().norm() < 0.5, "the free directions ran away");
}

proptest! {
    #[test]
    fn any_garbage_gives_a_finite_pose(seed in any::<u64>(), n in 0usize..40, scale in -9i32..7) {
        let mut random = random(seed);
        let observations: Vec<_> = (0..n)
            .map(|_| {
                let pixel = normal_vec3(&mut random, 1e3);
                PoseObservation {
                    point_world: normal_vec3(&mut random, 10f64.powi(scale)),
                    pixel: Vec2::new(pixel.x, pixel.y),
                    right_u: if pixel.z < 0.0 { f64::NAN } else { pixel.z },
                    inv_sigma_sq: 1.0,
                }
            })
            .collect();
        let initial = SE3::exp(&Vec6::new(0.1, -0.2, 0.3, 0.4, 0.5, -0.6));
        let solution = refine(initial, &observations);
        prop_assert!(solution.cam_from_world.is_finite());
        prop_assert_eq!(solution.inliers.len(), n);
    }
}
