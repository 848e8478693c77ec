//! Trajectories: time-stamped camera poses, read and written in the formats of KITTI, TUM and EuRoC.

mod euroc;
mod kitti;
mod tum;

use std::path::Path;

use geometry::SE3;

use crate::file::{FileError, Line, TextFile, counted};

pub use euroc::{read_euroc, write_euroc};
pub use kitti::{read_kitti_poses, write_kitti};
pub use tum::{read_tum, write_tum};

/// A camera pose with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampedPose {
    /// Seconds. KITTI pose files carry no times: there it is the row number until [`Trajectory::with_times`].
    pub timestamp_s: f64,
    /// Pose of the camera (of the body in EuRoC's ground truth) in the world, metres.
    pub world_from_cam: SE3,
}

/// Poses in strictly increasing order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectory {
    /// The poses, earliest first.
    pub poses: Vec<StampedPose>,
}

/// The file formats of trajectories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrajectoryFormat {
    /// Twelve numbers a line: the upper 3x4 of `world_from_cam`, row by row.
    Kitti,
    /// Eight numbers a line: seconds, position, quaternion x y z w.
    Tum,
    /// Comma separated: nanoseconds, position, quaternion w x y z, anything more.
    Euroc,
}

impl Trajectory {
    /// The same poses with the times of their rows (KITTI); rows beyond the shorter of the two are left out.
    pub fn with_times(&self, times_s: &[f64]) -> Self {
        let poses = self
            .poses
            .iter()
            .zip(times_s)
            .map(|(pose, &timestamp_s)| StampedPose { timestamp_s, ..*pose })
            .collect();
        Self { poses }
    }

    /// The pose nearest in time, if one lies within `tolerance_s`; the earlier of two equally near ones.
    pub fn find_nearest(&self, timestamp_s: f64, tolerance_s: f64) -> Option<&StampedPose> {
        let after = self.poses.partition_point(|pose| pose.timestamp_s < timestamp_s);
        let distance = |pose: &&StampedPose| (pose.timestamp_s - timestamp_s).abs();
        self.poses[after.saturating_sub(1)..self.poses.len().min(after + 1)]
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .filter(|pose| distance(pose) <= tolerance_s)
    }
}

/// Reads a trajectory in whichever of the three formats the file is.
///
/// # Errors
/// [`FileError`] when no format fits the first line with data, or from the format's reader.
pub fn read_trajectory(path: &Path) -> Result<Trajectory, FileError> {
    match detect_format(path)? {
        TrajectoryFormat::Kitti => read_kitti_poses(path),
        TrajectoryFormat::Tum => read_tum(path),
        TrajectoryFormat::Euroc => read_euroc(path),
    }
}

/// Tells the format from the first line that holds data.
fn detect_format(path: &Path) -> Result<TrajectoryFormat, FileError> {
    const EXPECTED: &str = "a trajectory (KITTI: 12 numbers a line, TUM: 8, EuRoC: at least 8 with commas)";
    let file = TextFile::read(path, EXPECTED)?;
    let line = file.data_lines().next().ok_or_else(|| file.empty(EXPECTED))?;
    if line.text.contains(',') {
        return Ok(TrajectoryFormat::Euroc);
    }
    match line.text.split_whitespace().count() {
        12 => Ok(TrajectoryFormat::Kitti),
        8 => Ok(TrajectoryFormat::Tum),
        n => Err(line.error(counted(n, "field"), EXPECTED)),
    }
}

/// Refuses a time that does not lie after the one before it.
pub(crate) fn check_increasing(line: &Line<'_>, previous: Option<f64>, time_s: f64) -> Result<(), FileError> {
    match previous {
        Some(before) if time_s <= before => Err(line
            .error(format!("time {time_s} after {before} of the entry before"), "strictly increasing times")),
        _ => Ok(()),
    }
}

/// A rotation out of quaternion components as files round them; refuses what is far from unit length.
fn rotation_from_quaternion(line: &Line<'_>, wxyz: [f64; 4]) -> Result<geometry::SO3, FileError> {
    /// Files keep four decimals or more; a wider deviation is no rounding.
    const TOLERANCE: f64 = 0.01;
    let [w, x, y, z] = wxyz;
    let quaternion = nalgebra::Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    if (norm - 1.0).abs() > TOLERANCE {
        return Err(line.error(format!("a quaternion of length {norm:.6}"), "a unit quaternion"));
    }
    Ok(geometry::SO3::from_quaternion(&nalgebra::UnitQuaternion::from_quaternion(quaternion)))
}
