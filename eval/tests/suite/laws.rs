//! Laws that hold for every trajectory: what moves an estimate as a whole does not change its error.

use dsslam_eval::{
    Alignment, KITTI_LENGTHS_M, RpeOptions, apply_alignment, ate, estimate_alignment, kitti_drift, rpe,
    scale_drift,
};
use geometry::{SE3, SO3, Sim3, Vec3, Vec6};
use proptest::prelude::*;

fn vec3(size: f64) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from)
}

fn motion(angle: f64, distance: f64) -> impl Strategy<Value = SE3> {
    (vec3(angle), vec3(distance)).prop_map(|(phi, t)| SE3::new(SO3::exp(&phi), t))
}

/// A drive of 30 to 60 steps of 3 to 9 m with turns, and an estimate that errs a little at each step.
fn drive() -> impl Strategy<Value = (Vec<SE3>, Vec<SE3>)> {
    let step = (vec3(0.15), 3.0..9.0, vec3(0.02), vec3(0.2));
    prop::collection::vec(step, 30..60).prop_map(|steps| {
        let (mut gt, mut est) = (vec![SE3::identity()], vec![SE3::identity()]);
        for (turn, length, turn_error, error) in steps {
            let step = SE3::new(SO3::exp(&turn), Vec3::new(0.0, 0.0, length));
            gt.push(gt[gt.len() - 1] * step);
            est.push(est[est.len() - 1] * step * SE3::new(SO3::exp(&turn_error), error));
        }
        (gt, est)
    })
}

fn moved(by: &SE3, poses: &[SE3]) -> Vec<SE3> {
    poses.iter().map(|pose| by * pose).collect()
}

fn scaled(by: f64, poses: &[SE3]) -> Vec<SE3> {
    poses.iter().map(|pose| SE3::new(pose.rotation, by * pose.translation)).collect()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-8 * (1.0 + a.abs())
}

proptest! {
    #[test]
    fn ate_ignores_a_rigid_motion_of_the_estimate((gt, est) in drive(), by in motion(3.0, 100.0)) {
        for alignment in [Alignment::Se3, Alignment::Sim3] {
            let (a, b) = (ate(&est, &gt, alignment).unwrap().error_m, ate(&moved(&by, &est), &gt, alignment).unwrap().error_m);
            prop_assert!(close(a.rmse, b.rmse) && close(a.max, b.max), "{} and {}", a.rmse, b.rmse);
        }
    }

    #[test]
    fn sim3_ate_ignores_scale_and_se3_ate_does_not((gt, est) in drive(), by in 0.05..20.0) {
        let rmse = |est: &[SE3], alignment| ate(est, &gt, alignment).unwrap().error_m.rmse;
        prop_assert!(close(rmse(&est, Alignment::Sim3), rmse(&scaled(by, &est), Alignment::Sim3)));
        prop_assert!(rmse(&scaled(2.0, &gt), Alignment::Se3) > 1.0);
        prop_assert!(rmse(&est, Alignment::Sim3) <= rmse(&est, Alignment::Se3) + 1e-9);
    }

    #[test]
    fn the_alignment_is_the_motion_that_was_applied((gt, _) in drive(), by in motion(3.0, 100.0), scale in 0.1..10.0) {
        let inverse = Sim3::new(by.rotation, by.translation, scale).inverse();
        let est = apply_alignment(&inverse, &gt);
        let found = estimate_alignment(&est, &gt, Alignment::Sim3).unwrap();
        prop_assert!(close(found.scale, scale), "{} and {scale}", found.scale);
        prop_assert!((found.translation - by.translation).norm() < 1e-6);
        prop_assert!((found.rotation.matrix() - by.rotation.matrix()).norm() < 1e-8);
    }

    #[test]
    fn equal_trajectories_have_no_error((gt, _) in drive()) {
        for alignment in [Alignment::None, Alignment::Se3, Alignment::Sim3] {
            prop_assert!(ate(&gt, &gt, alignment).unwrap().error_m.max < 1e-9);
        }
        let drift = kitti_drift(&gt, &gt, &[20.0, 50.0]).unwrap();
        prop_assert!(drift.t_rel_percent.unwrap() < 1e-9);
        // The arc cosine of a cosine that is wrong in its last digit: about 1e-8 rad over 20 m.
        prop_assert!(drift.r_rel_deg_per_100m.unwrap() < 1e-4);
        let relative = rpe(&gt, &gt, &RpeOptions::default()).unwrap();
        prop_assert!(relative.translation.max < 1e-9 && relative.rotation_deg.max < 1e-9);
        prop_assert!(scale_drift(&gt, &gt, 20.0).unwrap().abs() < 1e-9);
    }

    #[test]
    fn drift_and_rpe_ignore_global_motions((gt, est) in drive(), a in motion(3.0, 100.0), b in motion(3.0, 100.0)) {
        let (one, two) = (kitti_drift(&est, &gt, &[20.0, 50.0]).unwrap(), kitti_drift(&moved(&a, &est), &moved(&b, &gt), &[20.0, 50.0]).unwrap());
        prop_assert!(one.n_segments > 0);
        prop_assert_eq!(one.n_segments, two.n_segments);
        prop_assert!(close(one.t_rel_percent.unwrap(), two.t_rel_percent.unwrap()));
        prop_assert!((one.r_rel_deg_per_100m.unwrap() - two.r_rel_deg_per_100m.unwrap()).abs() < 1e-6);
        let one = rpe(&est, &gt, &RpeOptions::default()).unwrap();
        let two = rpe(&moved(&a, &est), &moved(&b, &gt), &RpeOptions::default()).unwrap();
        prop_assert!(close(one.translation.rmse, two.translation.rmse) && close(one.rotation_deg.rmse, two.rotation_deg.rmse));
    }

    #[test]
    fn drift_of_a_constant_error_per_meter_is_that_error(gain in 0.9..1.1, n in 300usize..400) {
        let straight = |step: f64| -> Vec<SE3> { (0..n).map(|i| SE3::exp(&Vec6::new(0.0, 0.0, step * i as f64, 0.0, 0.0, 0.0))).collect() };
        let drift = kitti_drift(&straight(gain), &straight(1.0), &KITTI_LENGTHS_M).unwrap();
        // Segments end up to one frame (a meter) beyond their nominal length of at least 100 m.
        let expected = 100.0 * (gain - 1.0f64).abs();
        let t = drift.t_rel_percent.unwrap();
        prop_assert!(t >= expected - 1e-9 && t <= 1.0101 * expected + 1e-9, "{t} for {expected}");
    }
}
