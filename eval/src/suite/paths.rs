//! The path of a finished run and the true one, for figures: from the files that the run wrote.

use anyhow::{Context, Result};
use geometry::Vec3;
use io::{StampedPose, Trajectory, TrajectoryFormat, read_trajectory};

use super::results::RunResult;

/// Times of the same frame in two files differ by their rounding, seconds.
const SAME_TIME_S: f64 = 1e-6;

/// Positions of a run for plots, in the ground truth's world, meters.
#[derive(Clone, Debug)]
pub struct RunPaths {
    /// Aligned estimate; `None` where the frame was lost.
    pub estimate: Vec<Option<Vec3>>,
    /// Ground truth; empty when there is none.
    pub ground_truth: Vec<Vec3>,
}

impl RunPaths {
    /// Positions of what the run's evaluation compared, aligned as there.
    ///
    /// # Errors
    /// A file is missing (runs of older versions did not write all of them), or cannot be read.
    pub fn of(run: &RunResult) -> Result<RunPaths> {
        let read = |name: &str| -> Result<Trajectory> {
            Ok(read_trajectory(&run.folder.join(name), Some(TrajectoryFormat::Tum))?.trajectory)
        };
        let position = |pose: &StampedPose| pose.world_from_cam.translation;
        let Some(evaluation) = &run.evaluation else {
            let is_compared = run.summary.as_ref().is_some_and(|summary| summary.ate_rmse_m.is_some());
            anyhow::ensure!(!is_compared, "no usable evaluation.json, which says how to align the estimate");
            let estimate =
                read("trajectory.tum.txt")?.poses.iter().map(|pose| Some(position(pose))).collect();
            return Ok(RunPaths { estimate, ground_truth: Vec::new() });
        };
        let of_what = if evaluation.compares_bodies() { "_body" } else { "" };
        let est = read(&format!("trajectory{of_what}.tum.txt"))?;
        let truth = read(&format!("ground_truth{of_what}.tum.txt"))
            .context("the true poses at the frames, which a run writes beside its trajectory")?;
        let at = |pose: &StampedPose| {
            est.find_nearest(pose.timestamp_s, SAME_TIME_S).map(|pose| evaluation.aligned(&position(pose)))
        };
        Ok(RunPaths {
            estimate: truth.poses.iter().map(at).collect(),
            ground_truth: truth.poses.iter().map(position).collect(),
        })
    }
}
