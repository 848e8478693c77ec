//! Ground truth of a dataset: the file that the user names, or the one in the usual place. It never stops a run: what is wrong with it is
//! told, and the rest is used.

use std::path::{Path, PathBuf};

use super::stamps::seconds;
use super::{FrameSource, OpenOptions};
use crate::file::{FileError, counted};
use crate::trajectory::{StampedPose, Stamps, Trajectory, TrajectoryFormat, read_lenient};

/// The poses of the file that `options` name, in any format, else of the first of `usual` that exists, which has `format`;
/// rows and frame numbers become the times of `frames`.
///
/// # Errors
/// [`FileError::Missing`] for a file that the user names and that is not there.
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
    let (truth, odd) = match read_lenient(path, format) {
        Ok(read) => read,
        Err(problem @ FileError::Missing { .. }) => return Err(problem),
        Err(problem) => {
            warnings.push(format!("{problem}; the run continues without ground truth"));
            return Ok(None);
        }
    };
    if let Some((first, n)) = odd {
        warnings.push(format!("{first}; {} of the ground truth left out", counted(n, "such line")));
    }
    let n_rows = truth.trajectory.poses.len();
    if truth.stamps == Stamps::Rows && n_rows < frames.len() {
        warnings.push(format!(
            "{}: {} for {}; errors are computed over the first {n_rows}",
            path.display(),
            counted(n_rows, "pose"),
            counted(frames.len(), "frame"),
        ));
    }
    let first = frames.first().map_or(0, |frame| frame.index);
    let times_s: Vec<f64> = frames.iter().map(|frame| seconds(frame.timestamp_ns)).collect();
    Ok(Some(truth.at_frames(&times_s, first)))
}

/// The poses of 7-Scenes: a file with a 4x4 matrix beside each image.
pub(super) fn of_files(frames: &[FrameSource], warnings: &mut Vec<String>) -> Option<Trajectory> {
    let pose_file = |image: &Path| {
        let name = image.file_name()?.to_str()?;
        let (stem, _) = name.split_once('.')?;
        Some(image.with_file_name(format!("{stem}.pose.txt")))
    };
    let mut poses = Vec::new();
    let mut n_odd = 0;
    for frame in frames {
        let Some(path) = pose_file(&frame.left).filter(|path| path.is_file()) else { continue };
        match crate::trajectory::read_matrix(&path) {
            Ok(world_from_cam) => {
                poses.push(StampedPose { timestamp_s: seconds(frame.timestamp_ns), world_from_cam });
            }
            Err(problem) => {
                if n_odd == 0 {
                    warnings.push(format!("{problem}; the frame has no ground truth"));
                }
                n_odd += 1;
            }
        }
    }
    (!poses.is_empty()).then_some(Trajectory { poses })
}
