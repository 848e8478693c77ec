//! Files of the tests: the small fixtures beside them, and published trajectories where they are present.

use std::path::{Path, PathBuf};

use anyhow::Result;
use dsslam_eval::{Association, match_stamps};
use geometry::SE3;
use io::{Stamps, Trajectory, read_trajectory};

/// Matched poses `world_from_cam`, in order of time.
#[derive(Debug)]
pub(crate) struct Pairs {
    pub(crate) est: Vec<SE3>,
    pub(crate) gt: Vec<SE3>,
    /// Index of each pair in the ground truth's file.
    pub(crate) gt_indices: Vec<usize>,
    /// Poses in the ground truth before matching.
    pub(crate) n_gt: usize,
}

/// Matches two trajectories.
pub(crate) fn associate(est: &Trajectory, gt: &Trajectory, association: Association) -> Result<Pairs> {
    let stamps = |t: &Trajectory| t.poses.iter().map(|pose| pose.timestamp_s).collect::<Vec<f64>>();
    let pairs = match_stamps(&stamps(est), &stamps(gt), association)?;
    Ok(Pairs {
        est: pairs.iter().map(|&(e, _)| est.poses[e].world_from_cam).collect(),
        gt: pairs.iter().map(|&(_, g)| gt.poses[g].world_from_cam).collect(),
        gt_indices: pairs.iter().map(|&(_, g)| g).collect(),
        n_gt: gt.poses.len(),
    })
}

/// A file of `tests/fixtures`.
pub(crate) fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name)
}

/// A published trajectory: `DSSLAM_TRAJECTORIES`, or `shared/reference/trajectories` beside the repository.
pub(crate) fn published(name: &str) -> Option<PathBuf> {
    let folder = match std::env::var_os("DSSLAM_TRAJECTORIES") {
        Some(folder) => PathBuf::from(folder),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/reference/trajectories"),
    };
    let path = folder.join(name);
    if path.is_file() {
        return Some(path);
    }
    eprintln!("SKIPPED: {} is absent (set DSSLAM_TRAJECTORIES)", path.display());
    None
}

/// Ground truth and estimate, matched by index (KITTI) or within 10 ms.
pub(crate) fn pairs(gt: &Path, est: &Path) -> Pairs {
    let truth = read_trajectory(gt, None).unwrap();
    let estimate = read_trajectory(est, None).unwrap();
    let association = match (truth.stamps, estimate.stamps) {
        (Stamps::Rows, Stamps::Rows) => Association::Index,
        (Stamps::Rows, _) => Association::Timestamp { tolerance_s: 0.0 },
        _ => Association::Timestamp { tolerance_s: dsslam_eval::TIMESTAMP_TOLERANCE_S },
    };
    associate(&estimate.trajectory, &truth.trajectory, association).unwrap()
}
