//! TUM trajectories: `timestamp tx ty tz qx qy qz qw` a line, seconds and meters, `#` for comments.

use std::path::Path;

use super::{Clock, StampedPose, Trajectory, numbers, pose, write_rows};
use crate::file::{FileError, Line};

pub(super) const EXPECTED: &str = "8 numbers (timestamp tx ty tz qx qy qz qw)";

/// Columns of a row without time.
pub(super) const UNSTAMPED_COLUMNS: usize = 7;

/// One row.
pub(super) fn row(line: &Line<'_>) -> Result<StampedPose, FileError> {
    let [timestamp_s, tx, ty, tz, qx, qy, qz, qw] = line.numbers(line.text.split_whitespace(), EXPECTED)?;
    pose(line, timestamp_s, [tx, ty, tz], [qw, qx, qy, qz])
}

/// Row number `index` of a file without times.
pub(super) fn unstamped_row(line: &Line<'_>, index: usize) -> Result<StampedPose, FileError> {
    const EXPECTED: &str = "7 numbers (tx ty tz qx qy qz qw)";
    let [tx, ty, tz, qx, qy, qz, qw] = line.numbers(line.text.split_whitespace(), EXPECTED)?;
    pose(line, index as f64, [tx, ty, tz], [qw, qx, qy, qz])
}

/// Writes a TUM trajectory: times with nine decimals, poses exact to 1e-9 when read back.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn write_tum(path: &Path, trajectory: &Trajectory) -> Result<(), FileError> {
    write_tum_at(path, trajectory, &Clock::default())
}

/// As [`write_tum`], with the stamps of a sequence's frames exactly as they were read.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn write_tum_at(path: &Path, trajectory: &Trajectory, clock: &Clock) -> Result<(), FileError> {
    let row = |pose: &StampedPose| (clock.stamp(pose.timestamp_s), numbers(&pose.world_from_cam));
    write_rows(path, "# timestamp tx ty tz qx qy qz qw\n", ' ', trajectory.poses.iter().map(row))
}
