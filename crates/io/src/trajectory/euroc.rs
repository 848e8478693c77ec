//! EuRoC ground truth (`state_groundtruth_estimate0/data.csv`): nanoseconds, position, quaternion w x y z, more columns.

use std::path::Path;

use super::{Clock, StampedPose, Trajectory, numbers, pose, write_rows};
use crate::dataset::stamps::seconds;
use crate::file::{FileError, Line, counted};

pub(super) const EXPECTED: &str = "at least 8 comma-separated numbers (ns, px, py, pz, qw, qx, qy, qz)";

/// One row; what stands after the first eight columns (velocities, biases) is left alone.
pub(super) fn row(line: &Line<'_>, w_first: bool) -> Result<StampedPose, FileError> {
    let n_fields = line.text.split(',').count();
    if n_fields < 8 {
        return Err(line.error(counted(n_fields, "field"), EXPECTED));
    }
    let mut fields = line.text.split(',').map(str::trim);
    let stamp = fields.next().unwrap_or_default();
    let stamp_ns: i64 =
        stamp.parse().map_err(|_| line.error(crate::file::shown(stamp), "whole nanoseconds"))?;
    let [px, py, pz, a, b, c, d] = line.numbers(fields.take(7), EXPECTED)?;
    pose(line, seconds(stamp_ns), [px, py, pz], if w_first { [a, b, c, d] } else { [d, a, b, c] })
}

/// Writes poses in the first eight columns of EuRoC's ground truth: times rounded to nanoseconds (times before 1970 count as 0), poses
/// exact to 1e-9 when read back.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn write_euroc(path: &Path, trajectory: &Trajectory) -> Result<(), FileError> {
    write_euroc_at(path, trajectory, &Clock::default())
}

/// As [`write_euroc`], with the stamps of a sequence's frames exactly as they were read.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn write_euroc_at(path: &Path, trajectory: &Trajectory, clock: &Clock) -> Result<(), FileError> {
    const HEADER: &str = "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n";
    let row = |pose: &StampedPose| {
        let [x, y, z, i, j, k, w] = numbers(&pose.world_from_cam);
        (clock.nanoseconds(pose.timestamp_s).max(0), [x, y, z, w, i, j, k])
    };
    write_rows(path, HEADER, ',', trajectory.poses.iter().map(row))
}

/// Writes poses in the form of VSLAM-LAB's results: `ts (ns),tx,ty,tz,qx,qy,qz,qw`, with the stamps of a sequence's frames exactly as
/// they were read.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn write_vslamlab(path: &Path, trajectory: &Trajectory, clock: &Clock) -> Result<(), FileError> {
    let row = |pose: &StampedPose| (clock.nanoseconds(pose.timestamp_s), numbers(&pose.world_from_cam));
    write_rows(path, "ts (ns),tx,ty,tz,qx,qy,qz,qw\n", ',', trajectory.poses.iter().map(row))
}
