//! Which pose of the estimate belongs to which pose of the ground truth: by frame index or by nearest timestamp.

use std::fmt;

use anyhow::{Result, ensure};

/// Tolerance of timestamps that the field uses (TUM, EuRoC), seconds.
pub const TIMESTAMP_TOLERANCE_S: f64 = 0.01;

/// How poses are matched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Association {
    /// Pose i belongs to pose i: KITTI.
    Index,
    /// As by index, after the estimate was laid out over the frames of the ground truth by the numbers in its file.
    FrameNumber,
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
            Association::FrameNumber => f.write_str("by frame number"),
            Association::Timestamp { tolerance_s } => write!(f, "nearest timestamp within {tolerance_s} s"),
        }
    }
}

/// Indices (estimate, ground truth) of the poses that belong together, by their increasing stamps, in order.
///
/// # Errors
/// By index: different lengths. By timestamp: no pair within the tolerance (both time ranges are in the message).
/// Either way: an empty trajectory.
pub fn match_stamps(est: &[f64], gt: &[f64], association: Association) -> Result<Vec<(usize, usize)>> {
    ensure!(!est.is_empty(), "the estimate is empty");
    ensure!(!gt.is_empty(), "the ground truth is empty");
    match association {
        Association::Index | Association::FrameNumber => by_index(est.len(), gt.len()),
        Association::Timestamp { tolerance_s } => by_timestamp(est, gt, tolerance_s),
    }
}

fn by_index(n_est: usize, n_gt: usize) -> Result<Vec<(usize, usize)>> {
    ensure!(
        n_est == n_gt,
        "different lengths: the estimate has {n_est} poses, the ground truth {n_gt}; matching by index needs one \
         pose per frame (fill lost frames, or prefix each row with its frame number)"
    );
    Ok((0..n_est).map(|i| (i, i)).collect())
}

fn by_timestamp(est: &[f64], gt: &[f64], tolerance_s: f64) -> Result<Vec<(usize, usize)>> {
    ensure!(
        tolerance_s.is_finite() && tolerance_s >= 0.0,
        "the tolerance must be >= 0, found {tolerance_s} s"
    );
    // As evo does: each pose of the shorter trajectory takes the nearest of the longer one.
    let est_is_longer = est.len() > gt.len();
    let (short, long) = if est_is_longer { (gt, est) } else { (est, gt) };
    let mut matches = Vec::with_capacity(short.len());
    for (i, &time_s) in short.iter().enumerate() {
        let nearest = nearest_in_time(long, time_s);
        if (long[nearest] - time_s).abs() <= tolerance_s {
            matches.push(if est_is_longer { (nearest, i) } else { (i, nearest) });
        }
    }
    ensure!(
        !matches.is_empty(),
        "no overlap in time: the estimate covers {}, the ground truth {}; no pair within {tolerance_s} s",
        time_range(est),
        time_range(gt)
    );
    Ok(matches)
}

/// Index of the time nearest to `time_s` (the earlier one of two that are equally near); `times` is sorted.
fn nearest_in_time(times: &[f64], time_s: f64) -> usize {
    let after = times.partition_point(|&t| t < time_s);
    if after == 0 {
        return 0;
    }
    if after == times.len() {
        return after - 1;
    }
    let (gap_before, gap_after) = ((time_s - times[after - 1]).abs(), (times[after] - time_s).abs());
    if gap_before <= gap_after { after - 1 } else { after }
}

fn time_range(times: &[f64]) -> String {
    match (times.first(), times.last()) {
        (Some(first), Some(last)) => format!("{first:.3} to {last:.3} s"),
        _ => "nothing".to_owned(),
    }
}
