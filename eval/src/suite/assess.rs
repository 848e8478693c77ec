//! Evaluation of a finished run: its trajectory against the suite's ground truth.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use geometry::{SE3, Vec3};
use io::Trajectory;

use super::plan::SequencePlan;
use super::record::RunSummary;
use crate::alignment::{Alignment, apply_alignment, positions};
use crate::association::{Association, TIMESTAMP_TOLERANCE_S};
use crate::evaluation::{Evaluated, EvaluationOptions, Matched, evaluate};
use crate::read::{Format, read_trajectory_file};

/// Figures of the run in `folder`; `None` when the sequence has no ground truth.
///
/// KITTI: row i of `trajectory.kitti.txt` belongs to row i of the ground truth, frames that the summary lists as without
/// a pose count as lost. TUM and EuRoC: `trajectory.tum.txt` by timestamp.
///
/// # Errors
/// A file cannot be read, or the trajectory cannot be compared with the ground truth.
pub fn assess(
    folder: &Path,
    sequence: &SequencePlan,
    summary: &RunSummary,
    options: &EvaluationOptions,
) -> Result<Option<Evaluated>> {
    let Some(matched) = matched(folder, sequence, summary)? else { return Ok(None) };
    evaluate(&matched, options).map(Some)
}

/// Options for the run: Sim3 where the program itself aligned with it (monocular).
pub(super) fn options_for(summary: &RunSummary, lengths_m: &[f64]) -> EvaluationOptions {
    let is_sim3 = summary.alignment.as_deref() == Some("Sim3");
    EvaluationOptions {
        alignment: if is_sim3 { Alignment::Sim3 } else { Alignment::Se3 },
        lengths_m: lengths_m.to_vec(),
        ..EvaluationOptions::default()
    }
}

fn matched(folder: &Path, sequence: &SequencePlan, summary: &RunSummary) -> Result<Option<Matched>> {
    let Some(path) = &sequence.ground_truth else { return Ok(None) };
    let mut gt = read_trajectory_file(path, None)?;
    if gt.format != Format::Kitti {
        let est = read_trajectory_file(&folder.join("trajectory.tum.txt"), Some(Format::Tum))?;
        let by_time = Association::Timestamp { tolerance_s: TIMESTAMP_TOLERANCE_S };
        return Matched::new(&est, &gt, by_time).map(Some);
    }
    let est = read_trajectory_file(&folder.join("trajectory.kitti.txt"), Some(Format::Kitti))?;
    let (n_est, n_gt) = (est.trajectory.poses.len(), gt.trajectory.poses.len());
    ensure!(n_est <= n_gt, "the run has {n_est} frames, the ground truth {} only {n_gt}", path.display());
    gt.trajectory = Trajectory { poses: gt.trajectory.poses[..n_est].to_vec() };
    let mut matched = Matched::new(&est, &gt, Association::Index)?;
    for lost in &summary.without_pose {
        if let Some(slot) = matched.est.get_mut(lost.frame) {
            *slot = None;
        }
    }
    Ok(Some(matched))
}

/// Positions of a run for plots, in the ground truth's world, metres.
#[derive(Clone, Debug)]
pub struct RunPaths {
    /// Aligned estimate; `None` where the frame was lost.
    pub estimate: Vec<Option<Vec3>>,
    /// Ground truth; empty when there is none.
    pub ground_truth: Vec<Vec3>,
}

/// Positions of the run in `folder`, aligned as its evaluation was.
///
/// # Errors
/// As [`assess`].
pub fn run_paths(folder: &Path, sequence: &SequencePlan, summary: &RunSummary) -> Result<RunPaths> {
    let options = options_for(summary, &[]);
    let Some(matched) = matched(folder, sequence, summary)? else {
        let est = read_trajectory_file(&folder.join("trajectory.kitti.txt"), Some(Format::Kitti))?;
        let estimate = est.trajectory.poses.iter().map(|p| Some(p.world_from_cam.translation)).collect();
        return Ok(RunPaths { estimate, ground_truth: Vec::new() });
    };
    let evaluated =
        evaluate(&matched, &options).with_context(|| format!("cannot evaluate {}", folder.display()))?;
    let aligned = |pose: &SE3| apply_alignment(&evaluated.gt_from_est, &[*pose])[0].translation;
    Ok(RunPaths {
        estimate: matched.est.iter().map(|pose| pose.as_ref().map(aligned)).collect(),
        ground_truth: positions(&matched.gt),
    })
}
