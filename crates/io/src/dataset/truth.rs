//! Ground truth of a dataset: the file that the user names, or the one in the usual place.

use std::path::PathBuf;

use super::{FrameSource, OpenOptions};
use crate::file::{FileError, counted};
use crate::trajectory::{Stamps, Trajectory, TrajectoryFormat, read_trajectory};

/// The poses of the file that `options` names, in any format, else of the first of `usual` that exists, which has `format`;
/// rows and frame numbers become the times of `frames`.
pub(super) fn read(
    options: &OpenOptions,
    usual: &[PathBuf],
    format: TrajectoryFormat,
    frames: &[FrameSource],
    warnings: &mut Vec<String>,
) -> Result<Option<Trajectory>, FileError> {
    let file = match &options.ground_truth {
        Some(named) => Some((named, None)),
        None => usual.iter().find(|path| path.is_file()).map(|path| (path, Some(format))),
    };
    let Some((path, format)) = file else { return Ok(None) };
    let truth = read_trajectory(path, format)?;
    let n_rows = truth.trajectory.poses.len();
    if truth.stamps == Stamps::Rows && n_rows < frames.len() {
        warnings.push(format!(
            "{}: {} for {}; errors are computed over the first {n_rows}",
            path.display(),
            counted(n_rows, "pose"),
            counted(frames.len(), "frame"),
        ));
    }
    let times_s: Vec<f64> = frames.iter().map(|frame| frame.timestamp_s).collect();
    Ok(Some(truth.with_frame_times(&times_s)))
}
