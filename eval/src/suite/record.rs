//! What is stored of a run: how it ended (`run.json`, ours) and its numbers (`summary.json`, the program's).

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::plan::RunId;

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "state", rename_all = "lowercase")]
pub enum RunState {
    /// With a summary.
    Done,
    /// Without a usable result.
    Failed {
        /// Why.
        reason: String,
    },
}

/// `run.json`: written when a run has ended, so that its absence means "not yet".
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Which run.
    pub id: RunId,
    /// How it ended.
    #[serde(flatten)]
    pub state: RunState,
    /// The program's arguments; a run is done again when the suite changes them.
    pub arguments: Vec<String>,
    /// Time by the clock from start to end of the program, seconds.
    pub wall_s: f64,
    /// Why the program could not compare the trajectory with the ground truth, if so.
    pub evaluation_problem: Option<String>,
}

/// The keys of the program's `summary.json` that tables show; what a version does not write is `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RunSummary {
    /// Frames read.
    pub frames: Option<usize>,
    /// Frames after the map's start without a pose.
    pub lost: Option<usize>,
    /// Frames with unusable images.
    pub dropped: Option<usize>,
    /// Frames before the map's start.
    pub not_ready: Option<usize>,
    /// Keyframes.
    pub keyframes: Option<usize>,
    /// Map points.
    pub points: Option<usize>,
    /// Loops closed.
    pub loops: Option<usize>,
    /// Absolute trajectory error by the program, meters.
    pub ate_rmse_m: Option<f64>,
    /// Alignment of that error.
    pub alignment: Option<String>,
    /// Drift by the program, percent.
    pub t_rel_percent: Option<f64>,
    /// Drift by the program, degrees per 100 m.
    pub r_rel_deg_per_100m: Option<f64>,
    /// Why there is no error although there is ground truth.
    pub evaluation_problem: Option<String>,
    /// Median tracking time, milliseconds.
    pub track_ms_median: Option<f64>,
    /// Time by the clock, seconds.
    pub wall_s: Option<f64>,
    /// Processor time, seconds.
    pub cpu_s: Option<f64>,
    /// Largest resident memory, 10^6 bytes.
    pub peak_rss_mb: Option<f64>,
    /// SHA-256 of the trajectory.
    pub trajectory_sha256: Option<String>,
    /// Schedule of the stages.
    pub schedule: Option<String>,
    /// Version of the program.
    pub version: Option<String>,
    /// Times of the stages, milliseconds.
    pub stages: BTreeMap<String, serde_json::Value>,
    /// Frames without a pose of their own.
    pub without_pose: Vec<FrameWithoutPose>,
}

/// A frame without a pose of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FrameWithoutPose {
    /// Number of the frame in its sequence.
    pub frame: usize,
    /// `not_ready`, `lost` or `dropped`.
    pub state: String,
}

impl RunSummary {
    /// Frames without a pose of their own, for whichever reason.
    pub fn n_without_pose(&self) -> usize {
        let counted = [self.lost, self.dropped, self.not_ready].iter().flatten().sum();
        self.without_pose.len().max(counted)
    }
}

/// Reads a JSON file.
pub(super) fn read_json<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    serde_json::from_str(&text).with_context(|| format!("{}", path.display()))
}

/// Writes a JSON file whole or not at all, and only when it changes: several processes may share a results folder.
pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value)? + "\n";
    if std::fs::read_to_string(path).is_ok_and(|old| old == text) {
        return Ok(());
    }
    Ok(io::write_atomic(path, text.as_bytes())?)
}
