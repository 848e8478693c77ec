//! TUM trajectories: `timestamp tx ty tz qx qy qz qw` a line, seconds and metres, `#` for comments.

use std::fmt::Write as _;
use std::path::Path;

use geometry::{SE3, Vec3};

use super::{StampedPose, Trajectory, check_increasing, rotation_from_quaternion};
use crate::file::{FileError, TextFile, write_atomic};

const EXPECTED: &str = "8 numbers (timestamp tx ty tz qx qy qz qw)";

/// Reads a TUM trajectory. Of successive rows with one time the first is kept: published ground truth (fr2/desk) repeats
/// times where its four decimals do not tell two poses apart.
///
/// # Errors
/// [`FileError`] for a missing or empty file, a count other than 8, a value that is no finite number, a quaternion far
/// from unit length, or a time before that of the row above.
pub fn read_tum(path: &Path) -> Result<Trajectory, FileError> {
    let file = TextFile::read(path, "a TUM trajectory")?;
    let mut poses: Vec<StampedPose> = Vec::new();
    for line in file.data_lines() {
        let [timestamp_s, tx, ty, tz, qx, qy, qz, qw] =
            line.numbers(line.text.split_whitespace(), EXPECTED)?;
        let rotation = rotation_from_quaternion(&line, [qw, qx, qy, qz])?;
        let previous_s = poses.last().map(|pose| pose.timestamp_s);
        if previous_s == Some(timestamp_s) {
            continue;
        }
        check_increasing(&line, previous_s, timestamp_s)?;
        poses.push(StampedPose { timestamp_s, world_from_cam: SE3::new(rotation, Vec3::new(tx, ty, tz)) });
    }
    if poses.is_empty() {
        return Err(file.empty(EXPECTED));
    }
    Ok(Trajectory { poses })
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
