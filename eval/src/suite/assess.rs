//! Evaluation of a finished run: its trajectory against the suite's ground truth.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use geometry::Vec3;
use io::{Stamps, Trajectory, TrajectoryFormat, read_trajectory};

use super::plan::SequencePlan;
use super::record::RunSummary;
use crate::alignment::{Alignment, positions};
use crate::association::Association;
use crate::evaluation::{Estimate, Evaluation, EvaluationOptions};

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
) -> Result<Option<Evaluation>> {
    let Some(path) = &sequence.ground_truth else { return Ok(None) };
    let gt = read_trajectory(path, None)?;
    if gt.stamps == Stamps::Times {
        let est = read_trajectory(&folder.join("trajectory.tum.txt"), Some(TrajectoryFormat::Tum))?;
        return Evaluation::of(&Estimate::of_file(&est), &gt.trajectory, options).map(Some);
    }
    let est = read_trajectory(&folder.join("trajectory.kitti.txt"), Some(TrajectoryFormat::Kitti))?;
    let mut est = Estimate::of_file(&est);
    let (n_est, n_gt) = (est.poses.len(), gt.trajectory.poses.len());
    ensure!(n_est <= n_gt, "the run has {n_est} frames, the ground truth {} only {n_gt}", path.display());
    let gt = Trajectory { poses: gt.trajectory.poses[..n_est].to_vec() };
    for lost in &summary.without_pose {
        if let Some(slot) = est.poses.get_mut(lost.frame) {
            *slot = None;
        }
    }
    let options = EvaluationOptions { association: Association::Index, ..options.clone() };
    Evaluation::of(&est, &gt, &options).map(Some)
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
    let evaluation = assess(folder, sequence, summary, &options)
        .with_context(|| format!("cannot evaluate {}", folder.display()))?;
    let Some(evaluation) = evaluation else {
        let est = read_trajectory(&folder.join("trajectory.kitti.txt"), Some(TrajectoryFormat::Kitti))?;
        let estimate = est.trajectory.poses.iter().map(|p| Some(p.world_from_cam.translation)).collect();
        return Ok(RunPaths { estimate, ground_truth: Vec::new() });
    };
    let aligned = |pose: &Option<geometry::SE3>| Some(evaluation.aligned(&pose.as_ref()?.translation));
    Ok(RunPaths {
        estimate: evaluation.matched.est.iter().map(aligned).collect(),
        ground_truth: positions(&evaluation.matched.gt),
    })
}
