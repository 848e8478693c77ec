//! Trajectories: time-stamped camera poses, read and written in the formats of KITTI, TUM and EuRoC.

mod euroc;
mod kitti;
mod tum;

use std::path::Path;

use geometry::SE3;

use crate::file::{FileError, Line, TextFile, counted};

pub use euroc::write_euroc;
pub use kitti::write_kitti;
pub use tum::write_tum;

/// A camera pose with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampedPose {
    /// Seconds. KITTI pose files carry no times: there it is the row or frame number until
    /// [`TrajectoryFile::with_frame_times`].
    pub timestamp_s: f64,
    /// Pose of the camera (of the body in EuRoC's ground truth) in the world, meters.
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
    /// Twelve numbers a line: the upper 3x4 of `world_from_cam`, row by row; or 13 with a frame number or a time in front.
    Kitti,
    /// Eight numbers a line: seconds, position, quaternion x y z w.
    Tum,
    /// Comma separated: nanoseconds, position, quaternion w x y z, anything more.
    Euroc,
}

/// What the timestamps of a file's poses are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamps {
    /// Row numbers from 0, because the file gives nothing else: one pose per frame.
    Rows,
    /// Frame numbers of the file, so that frames may be missing.
    FrameNumbers,
    /// Seconds.
    Times,
}

/// A trajectory as its file gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectoryFile {
    /// The poses.
    pub trajectory: Trajectory,
    /// Layout of the file.
    pub format: TrajectoryFormat,
    /// What the timestamps are.
    pub stamps: Stamps,
    /// Rows left out because their time equals that of the row before.
    pub n_repeated_times: usize,
}

impl Trajectory {
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

impl TrajectoryFile {
    /// The poses with times in seconds: poses of frames get those of their frames, `times_s`; poses of later frames
    /// are skipped.
    pub fn with_frame_times(mut self, times_s: &[f64]) -> Trajectory {
        if self.stamps != Stamps::Times {
            let time = |pose: &StampedPose| {
                let timestamp_s = *times_s.get(pose.timestamp_s as usize)?;
                Some(StampedPose { timestamp_s, ..*pose })
            };
            self.trajectory.poses = self.trajectory.poses.iter().filter_map(time).collect();
        }
        self.trajectory
    }
}

/// Reads a trajectory; without `format` the first line with data decides.
///
/// KITTI matrices are kept as the file has them, not made orthonormal: the benchmark's tools take them as they are, and its
/// published figures depend on it in the seventh digit. Of successive rows with one time the first is kept: published ground
/// truth (TUM fr2/desk) repeats times where its four decimals do not tell two poses apart. Poses of EuRoC's ground truth are
/// those of the body: compose with `T_BS` of a camera's `sensor.yaml`.
///
/// # Errors
/// [`FileError`] for a missing or empty file, a row of the wrong length, a value that is not a finite number, a matrix or
/// quaternion that is not a rotation, or times (frame numbers) that do not increase.
pub fn read_trajectory(path: &Path, format: Option<TrajectoryFormat>) -> Result<TrajectoryFile, FileError> {
    let expected = format.map_or(ANY_FORMAT, TrajectoryFormat::row);
    let file = TextFile::read(path, expected)?;
    let first = file.data_lines().next().ok_or_else(|| file.empty(expected))?;
    let format = format.map_or_else(|| detect(&first), Ok)?;
    let is_stamped = first.text.split_whitespace().count() == kitti::STAMPED_COLUMNS;
    let mut poses: Vec<StampedPose> = Vec::new();
    let mut n_repeated_times = 0;
    for line in file.data_lines() {
        let pose = match format {
            TrajectoryFormat::Kitti if is_stamped => kitti::stamped_row(&line)?,
            TrajectoryFormat::Kitti => kitti::row(&line, poses.len())?,
            TrajectoryFormat::Tum => tum::row(&line)?,
            TrajectoryFormat::Euroc => euroc::row(&line)?,
        };
        let previous_s = poses.last().map(|pose| pose.timestamp_s);
        if format != TrajectoryFormat::Kitti && previous_s == Some(pose.timestamp_s) {
            n_repeated_times += 1;
            continue;
        }
        check_increasing(&line, previous_s, pose.timestamp_s)?;
        poses.push(pose);
    }
    let stamps = match format {
        TrajectoryFormat::Kitti if !is_stamped => Stamps::Rows,
        TrajectoryFormat::Kitti if poses.iter().all(|pose| is_frame_number(pose.timestamp_s)) => {
            Stamps::FrameNumbers
        }
        _ => Stamps::Times,
    };
    Ok(TrajectoryFile { trajectory: Trajectory { poses }, format, stamps, n_repeated_times })
}

/// What a file of unknown format should hold.
const ANY_FORMAT: &str = "a trajectory (KITTI: 12 numbers a line, 13 with a frame number or time in front; TUM: 8; EuRoC: at \
                          least 8 with commas)";

impl TrajectoryFormat {
    /// What a row of the format should hold.
    fn row(self) -> &'static str {
        match self {
            TrajectoryFormat::Kitti => kitti::EXPECTED,
            TrajectoryFormat::Tum => tum::EXPECTED,
            TrajectoryFormat::Euroc => euroc::EXPECTED,
        }
    }
}

/// Tells the format from a line with data.
fn detect(line: &Line<'_>) -> Result<TrajectoryFormat, FileError> {
    if line.text.contains(',') {
        return Ok(TrajectoryFormat::Euroc);
    }
    match line.text.split_whitespace().count() {
        12 | kitti::STAMPED_COLUMNS => Ok(TrajectoryFormat::Kitti),
        8 => Ok(TrajectoryFormat::Tum),
        n => Err(line.error(counted(n, "field"), ANY_FORMAT)),
    }
}

fn is_frame_number(stamp: f64) -> bool {
    stamp >= 0.0 && stamp.fract() == 0.0
}

/// Refuses a time that does not lie after the one before it.
pub(crate) fn check_increasing(line: &Line<'_>, previous: Option<f64>, time_s: f64) -> Result<(), FileError> {
    match previous {
        Some(before) if time_s <= before => Err(line.error(
            format!("time {time_s} after {before} of the previous entry"),
            "strictly increasing times",
        )),
        _ => Ok(()),
    }
}

/// A rotation out of quaternion components as files round them; refuses what is far from unit length.
fn rotation_from_quaternion(line: &Line<'_>, wxyz: [f64; 4]) -> Result<geometry::SO3, FileError> {
    /// Files keep four decimals or more; a larger deviation is not due to rounding.
    const TOLERANCE: f64 = 0.01;
    let [w, x, y, z] = wxyz;
    let quaternion = nalgebra::Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    if (norm - 1.0).abs() > TOLERANCE {
        return Err(line.error(format!("a quaternion of length {norm:.6}"), "a unit quaternion"));
    }
    Ok(geometry::SO3::from_quaternion(&nalgebra::UnitQuaternion::from_quaternion(quaternion)))
}
