//! TUM trajectories: `timestamp tx ty tz qx qy qz qw` a line, seconds and meters, `#` for comments.

use std::fmt::Write as _;
use std::path::Path;

use geometry::{SE3, Vec3};

use super::{StampedPose, Trajectory, rotation_from_quaternion};
use crate::file::{FileError, Line, write_atomic};

pub(super) const EXPECTED: &str = "8 numbers (timestamp tx ty tz qx qy qz qw)";

/// One row.
pub(super) fn row(line: &Line<'_>) -> Result<StampedPose, FileError> {
    let [timestamp_s, tx, ty, tz, qx, qy, qz, qw] = line.numbers(line.text.split_whitespace(), EXPECTED)?;
    let rotation = rotation_from_quaternion(line, [qw, qx, qy, qz])?;
    Ok(StampedPose { timestamp_s, world_from_cam: SE3::new(rotation, Vec3::new(tx, ty, tz)) })
}

/// Writes a TUM trajectory: times with nine decimals, poses exact to 1e-9 when read back.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn write_tum(path: &Path, trajectory: &Trajectory) -> Result<(), FileError> {
    let mut text = String::with_capacity(trajectory.poses.len() * 160);
    text.push_str("# timestamp tx ty tz qx qy qz qw\n");
    for pose in &trajectory.poses {
        let t = pose.world_from_cam.translation;
        let q = pose.world_from_cam.rotation.to_quaternion();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:.9} {:.12} {:.12} {:.12} {:.12} {:.12} {:.12} {:.12}",
            pose.timestamp_s, t.x, t.y, t.z, q.i, q.j, q.k, q.w
        );
    }
    write_atomic(path, text.as_bytes())
}
