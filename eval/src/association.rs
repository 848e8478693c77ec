//! Which pose of the estimate belongs to which pose of the ground truth: by frame index or by nearest timestamp.

use std::fmt;

use anyhow::{Result, ensure};
use geometry::SE3;
use io::{StampedPose, Trajectory};

/// Tolerance of timestamps that the field uses (TUM, EuRoC), seconds.
pub const TIMESTAMP_TOLERANCE_S: f64 = 0.01;

/// How poses are matched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Association {
    /// Pose i belongs to pose i: KITTI.
    Index,
    /// The nearest timestamp, at most this many seconds away: TUM and EuRoC.
    Timestamp {
        /// Largest difference, seconds.
        tolerance_s: f64,
    },
}

impl fmt::Display for Association {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Association::Index => f.write_str("by frame index"),
            Association::Timestamp { tolerance_s } => write!(f, "nearest timestamp within {tolerance_s} s"),
        }
    }
}

/// Matched poses `world_from_cam`, in order of time.
#[derive(Clone, Debug)]
pub struct Pairs {
    /// Poses of the estimate.
    pub est: Vec<SE3>,
    /// Poses of the ground truth, one for each of the estimate's.
    pub gt: Vec<SE3>,
    /// Index of each pair in the estimate's file.
    pub est_indices: Vec<usize>,
    /// Index of each pair in the ground truth's file.
    pub gt_indices: Vec<usize>,
    /// Timestamp of the estimate's pose, seconds (or frame number).
    pub timestamps_s: Vec<f64>,
    /// Poses in the estimate before matching.
    pub n_est: usize,
    /// Poses in the ground truth before matching.
    pub n_gt: usize,
    /// How they were matched.
    pub association: Association,
}

/// Matches two trajectories.
///
/// # Errors
/// By index: different lengths. By timestamp: no pair within the tolerance (both time ranges are in the message).
/// Either way: an empty trajectory.
pub fn associate(est: &Trajectory, gt: &Trajectory, association: Association) -> Result<Pairs> {
    ensure!(!est.poses.is_empty(), "the estimate is empty");
    ensure!(!gt.poses.is_empty(), "the ground truth is empty");
    match association {
        Association::Index => by_index(est, gt),
        Association::Timestamp { tolerance_s } => by_timestamp(est, gt, tolerance_s),
    }
}

fn by_index(est: &Trajectory, gt: &Trajectory) -> Result<Pairs> {
    let (n_est, n_gt) = (est.poses.len(), gt.poses.len());
    ensure!(
        n_est == n_gt,
        "different lengths: the estimate has {n_est} poses, the ground truth {n_gt}; matching by index needs one \
         pose per frame (fill lost frames, or put the frame number in front of the 12 values)"
    );
    let all: Vec<(usize, usize)> = (0..n_est).map(|i| (i, i)).collect();
    Ok(pairs(est, gt, &all, Association::Index))
}

fn by_timestamp(est: &Trajectory, gt: &Trajectory, tolerance_s: f64) -> Result<Pairs> {
    ensure!(
        tolerance_s.is_finite() && tolerance_s >= 0.0,
        "the tolerance must be >= 0, found {tolerance_s} s"
    );
    // As evo does: each pose of the shorter trajectory takes the nearest of the longer one.
    let est_is_longer = est.poses.len() > gt.poses.len();
    let (short, long) = if est_is_longer { (gt, est) } else { (est, gt) };
    let mut matches = Vec::with_capacity(short.poses.len());
    for (i, pose) in short.poses.iter().enumerate() {
        let nearest = nearest_in_time(&long.poses, pose.timestamp_s);
        if (long.poses[nearest].timestamp_s - pose.timestamp_s).abs() <= tolerance_s {
            matches.push(if est_is_longer { (nearest, i) } else { (i, nearest) });
        }
    }
    ensure!(
        !matches.is_empty(),
        "no overlap in time: the estimate covers {}, the ground truth {}; no pair within {tolerance_s} s",
        time_range(est),
        time_range(gt)
    );
    Ok(pairs(est, gt, &matches, Association::Timestamp { tolerance_s }))
}

/// Index of the pose nearest to `time_s` (the earlier one of two that are equally near); `poses` is sorted.
fn nearest_in_time(poses: &[StampedPose], time_s: f64) -> usize {
    let after = poses.partition_point(|p| p.timestamp_s < time_s);
    if after == 0 {
        return 0;
    }
    if after == poses.len() {
        return after - 1;
    }
    let gap_before = (time_s - poses[after - 1].timestamp_s).abs();
    let gap_after = (poses[after].timestamp_s - time_s).abs();
    if gap_before <= gap_after { after - 1 } else { after }
}

fn pairs(est: &Trajectory, gt: &Trajectory, matches: &[(usize, usize)], association: Association) -> Pairs {
    Pairs {
        est: matches.iter().map(|&(e, _)| est.poses[e].world_from_cam).collect(),
        gt: matches.iter().map(|&(_, g)| gt.poses[g].world_from_cam).collect(),
        est_indices: matches.iter().map(|&(e, _)| e).collect(),
        gt_indices: matches.iter().map(|&(_, g)| g).collect(),
        timestamps_s: matches.iter().map(|&(e, _)| est.poses[e].timestamp_s).collect(),
        n_est: est.poses.len(),
        n_gt: gt.poses.len(),
        association,
    }
}

fn time_range(trajectory: &Trajectory) -> String {
    match (trajectory.poses.first(), trajectory.poses.last()) {
        (Some(first), Some(last)) => format!("{:.3} to {:.3} s", first.timestamp_s, last.timestamp_s),
        _ => "nothing".to_owned(),
    }
}
