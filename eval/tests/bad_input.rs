//! Bad input, each with its exact message.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::path::{Path, PathBuf};

use common::fixture;
use dsslam_eval::{
    Alignment, Association, EvaluationOptions, Format, KITTI_LENGTHS_M, Matched, associate, ate, evaluate,
    kitti_drift, read_trajectory_file,
};
use geometry::{SE3, SO3, Vec3};
use io::Trajectory;

const ROW: &str = "1 0 0 0 0 1 0 0 0 0 1 0";

/// The message of reading a file with this text; its path replaced by FILE.
fn message(text: &str) -> String {
    message_as(text, None)
}

fn message_as(text: &str, format: Option<Format>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("poses.txt");
    std::fs::write(&path, text).unwrap();
    let error = read_trajectory_file(&path, format).unwrap_err();
    format!("{error:#}").replace(&path.display().to_string(), "FILE")
}

fn trajectory(path: &Path) -> Trajectory {
    read_trajectory_file(path, None).unwrap().trajectory
}

#[test]
fn files_that_hold_nothing() {
    assert_eq!(message(""), "FILE: the file is empty");
    assert_eq!(message("# only a comment\n\n"), "FILE: the file is empty");
    assert_eq!(message_as("", Some(Format::Tum)), "FILE: the file is empty");
    let error = read_trajectory_file(&PathBuf::from("/nowhere/poses.txt"), None).unwrap_err();
    assert_eq!(
        format!("{error:#}"),
        "cannot read /nowhere/poses.txt: No such file or directory (os error 2)"
    );
}

#[test]
fn rows_of_the_wrong_length() {
    let eleven = "1 0 0 0 0 1 0 0 0 0 1";
    let formats = "expected 12 (KITTI; 13 with the frame number in front), 8 (TUM) or values separated by commas (EuRoC)";
    assert_eq!(message(eleven), format!("FILE:1: found 11 numbers; {formats}"));
    assert_eq!(
        message(&format!("{ROW}\n{eleven}\n")),
        "FILE:2: found 11 numbers, expected 12 (the 3x4 pose, row by row)"
    );
    assert_eq!(
        message(&format!("5 {ROW}\n{ROW}\n")),
        "FILE:2: found 12 numbers, expected 13 (frame number and 3x4 pose)"
    );
    assert_eq!(
        message("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 1\n"),
        "FILE:2: found 7 numbers, expected 8 (timestamp tx ty tz qx qy qz qw)"
    );
    assert_eq!(
        message("1000,0,0,0,1,0,0\n"),
        "FILE:1: found 7 fields, expected at least 8 (ns, px, py, pz, qw, qx, qy, qz)"
    );
}

#[test]
fn values_that_are_no_numbers() {
    assert_eq!(message(&ROW.replacen('1', "nan", 1)), "FILE:1: found nan, expected a finite number");
    assert_eq!(message(&ROW.replacen('1', "inf", 1)), "FILE:1: found inf, expected a finite number");
    assert_eq!(message(&ROW.replacen('1', "one", 1)), "FILE:1: found 'one', expected a number");
    assert_eq!(message("1 0 0 NaN 0 0 0 1"), "FILE:1: found NaN, expected a finite number");
    assert_eq!(message("1.5,0,0,0,1,0,0,0"), "FILE:1: found '1.5', expected whole nanoseconds");
    assert_eq!(message(&format!("1.5 {ROW}")), "FILE:1: 1.5 is no frame number");
}

#[test]
fn rotations_that_are_none() {
    assert_eq!(
        message(&ROW.replacen('1', "2", 1)),
        "FILE:1: the first three columns are no rotation (R^T R differs from the identity by 3.000)"
    );
    let mirrored = ROW.replacen('1', "-1", 1);
    assert!(message(&mirrored).starts_with("FILE:1: the first three columns are no rotation"));
    assert_eq!(message("1 0 0 0 0 0 0 0.5"), "FILE:1: the quaternion has length 0.500000, expected 1");
}

#[test]
fn times_that_do_not_increase() {
    let tum = |t: f64| format!("{t} 0 0 0 0 0 0 1\n");
    assert_eq!(
        message(&(tum(2.0) + &tum(1.5))),
        "FILE:2: timestamps are not increasing: 1.500000 s after 2.000000 s"
    );
    assert_eq!(message(&format!("5 {ROW}\n5 {ROW}\n")), "FILE:2: frame number 5 after 5 does not increase");
    // Equal times happen in published ground truth: the first row counts, and the reader says how many it left out.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    std::fs::write(&path, tum(1.0) + &tum(1.0) + &tum(2.0)).unwrap();
    let file = read_trajectory_file(&path, None).unwrap();
    assert_eq!((file.trajectory.poses.len(), file.n_repeated_times), (2, 1));
}

#[test]
fn different_lengths() {
    let gt = trajectory(&fixture("kitti_gt.txt"));
    let est = Trajectory { poses: gt.poses[..250].to_vec() };
    assert_eq!(
        associate(&est, &gt, Association::Index).unwrap_err().to_string(),
        "different lengths: the estimate has 250 poses, the ground truth 300; matching by index needs one pose per frame \
         (fill lost frames, or put the frame number in front of the 12 values)"
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
fn files_that_do_not_belong_together() {
    let kitti = read_trajectory_file(&fixture("kitti_est.txt"), None).unwrap();
    let tum = read_trajectory_file(&fixture("tum_gt.txt"), None).unwrap();
    assert_eq!(
        Matched::new(&kitti, &tum, Association::Timestamp { tolerance_s: 0.01 }).unwrap_err().to_string(),
        "a KITTI file has no timestamps: match by index, or give both files in a format with times"
    );
    let mut numbered = read_trajectory_file(&fixture("kitti_est_numbered.txt"), None).unwrap();
    numbered.trajectory.poses.last_mut().unwrap().timestamp_s = 400.0;
    assert_eq!(
        Matched::new(&numbered, &kitti, Association::Index).unwrap_err().to_string(),
        "the estimate has a frame 400, the ground truth ends at frame 299"
    );
}

#[test]
fn positions_that_determine_no_alignment() {
    let at = |x: f64| SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0));
    let still = vec![at(1.0); 5];
    assert_eq!(
        ate(&still, &still, Alignment::Se3).unwrap_err().to_string(),
        "alignment SE3 is not determined: the 5 positions lie on one line or in one place"
    );
    assert_eq!(
        ate(&still[..2], &still[..2], Alignment::Sim3).unwrap_err().to_string(),
        "alignment Sim3 needs at least 3 matched poses, found 2"
    );
    assert_eq!(ate(&still, &still, Alignment::None).unwrap().rmse, 0.0);
}

/// No error but figures without a value, which the program prints as "not defined".
#[test]
fn no_segment_long_enough() {
    let tum = read_trajectory_file(&fixture("tum_gt.txt"), None).unwrap();
    let matched = Matched::new(&tum, &tum, Association::Timestamp { tolerance_s: 0.01 }).unwrap();
    let figures = evaluate(&matched, &EvaluationOptions::default()).unwrap().figures;
    assert_eq!((figures.t_rel_percent, figures.r_rel_deg_per_100m, figures.n_segments), (None, None, 0));
    assert_eq!(figures.scale_drift_percent_per_100m, None);
    let shorter = EvaluationOptions { lengths_m: vec![5.0], ..EvaluationOptions::default() };
    assert!(evaluate(&matched, &shorter).unwrap().figures.t_rel_percent.is_some());
}
