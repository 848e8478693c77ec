//! Bad input, each with its exact message.

use std::path::Path;

use super::support::{associate, fixture};
use dsslam_eval::{
    Alignment, Association, Estimate, Evaluation, EvaluationOptions, KITTI_LENGTHS_M, ate, kitti_drift,
};
use geometry::{SE3, SO3, Vec3};
use io::{Trajectory, read_trajectory};

fn trajectory(path: &Path) -> Trajectory {
    read_trajectory(path, None).unwrap().trajectory
}

#[test]
fn different_lengths() {
    let gt = trajectory(&fixture("kitti_gt.txt"));
    let est = Trajectory { poses: gt.poses[..250].to_vec() };
    assert_eq!(
        associate(&est, &gt, Association::Index).unwrap_err().to_string(),
        "different lengths: the estimate has 250 poses, the ground truth 300; matching by index needs one pose per frame \
         (fill lost frames, or prefix each row with its frame number)"
    );
    let (est, gt) = (vec![SE3::identity(); 3], vec![SE3::identity(); 4]);
    let expected =
        "the estimate has 3 poses but the ground truth has 4: match them first, by index or by timestamp";
    assert_eq!(ate(&est, &gt, Alignment::Se3).unwrap_err().to_string(), expected);
    assert_eq!(kitti_drift(&est, &gt, &KITTI_LENGTHS_M).unwrap_err().to_string(), expected);
}

#[test]
fn no_overlap_in_time() {
    let gt = trajectory(&fixture("tum_gt.txt"));
    let mut est = gt.clone();
    est.poses.iter_mut().for_each(|pose| pose.timestamp_s -= 1000.0);
    assert_eq!(
        associate(&est, &gt, Association::Timestamp { tolerance_s: 0.01 }).unwrap_err().to_string(),
        "no overlap in time: the estimate covers 1499999000.000 to 1499999014.950 s, the ground truth 1500000000.000 to \
         1500000014.950 s; no pair within 0.01 s"
    );
    assert_eq!(
        associate(&est, &gt, Association::Timestamp { tolerance_s: -1.0 }).unwrap_err().to_string(),
        "the tolerance must be >= 0, found -1 s"
    );
    let empty = Trajectory { poses: Vec::new() };
    assert_eq!(associate(&empty, &gt, Association::Index).unwrap_err().to_string(), "the estimate is empty");
    assert_eq!(
        associate(&gt, &empty, Association::Index).unwrap_err().to_string(),
        "the ground truth is empty"
    );
}

#[test]
fn frames_that_the_ground_truth_does_not_have() {
    let kitti = trajectory(&fixture("kitti_est.txt"));
    let mut numbered = read_trajectory(&fixture("kitti_est_numbered.txt"), None).unwrap();
    numbered.trajectory.poses.last_mut().unwrap().timestamp_s = 400.0;
    assert_eq!(
        Estimate::of_numbered_file(&numbered, &kitti).unwrap_err().to_string(),
        "the estimate has a frame 400 that the ground truth, which ends at frame 299, does not have"
    );
}

#[test]
fn nothing_that_could_be_evaluated() {
    let gt = trajectory(&fixture("tum_gt.txt"));
    let message = |estimate: Estimate| {
        Evaluation::of(&estimate, &gt, &EvaluationOptions::default()).unwrap_err().to_string()
    };
    assert_eq!(message(Estimate::new([])), "the estimate is empty");
    assert_eq!(message(Estimate::new([(1.0, None), (2.0, None)])), "none of the 2 frames has a pose");
    let stamps = gt.poses.iter().enumerate();
    let two = stamps.map(|(i, pose)| (pose.timestamp_s, (i < 2).then_some(pose.world_from_cam)));
    assert_eq!(message(Estimate::new(two)), "alignment SE3 needs at least 3 matched poses, found 2");
}

#[test]
fn positions_that_determine_no_alignment() {
    let at = |x: f64| SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0));
    let still = vec![at(1.0); 5];
    assert_eq!(
        ate(&still, &still, Alignment::Se3).unwrap_err().to_string(),
        "alignment SE3 is not determined: the 5 positions lie on a line or at a single point"
    );
    assert_eq!(
        ate(&still[..2], &still[..2], Alignment::Sim3).unwrap_err().to_string(),
        "alignment Sim3 needs at least 3 matched poses, found 2"
    );
    assert_eq!(ate(&still, &still, Alignment::None).unwrap().error_m.rmse, 0.0);
}

/// No error but figures without a value, which the program prints as "not defined".
#[test]
fn no_segment_long_enough() {
    let tum = read_trajectory(&fixture("tum_gt.txt"), None).unwrap();
    let evaluate = |options: &EvaluationOptions| {
        Evaluation::of(&Estimate::of_file(&tum), &tum.trajectory, options).unwrap()
    };
    let found = evaluate(&EvaluationOptions::default());
    assert_eq!((found.t_rel_percent, found.r_rel_deg_per_100m, found.n_segments), (None, None, 0));
    assert_eq!(found.scale_drift_percent_per_100m, None);
    let shorter = EvaluationOptions { lengths_m: vec![5.0], ..EvaluationOptions::default() };
    assert!(evaluate(&shorter).t_rel_percent.is_some());
}
