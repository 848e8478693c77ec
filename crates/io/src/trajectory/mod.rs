//! Trajectories: time-stamped camera poses, read and written in the formats of KITTI, TUM and EuRoC.

mod clock;
mod euroc;
mod kitti;
mod tum;

use std::fmt::Write as _;
use std::path::Path;

use geometry::{SE3, SO3};

use crate::file::{FileError, Line, TextFile, counted, write_atomic};

pub use clock::{Clock, Stamp};
pub use euroc::{write_euroc, write_euroc_at, write_vslamlab};
pub use kitti::write_kitti;
pub use tum::{write_tum, write_tum_at};

/// A camera pose with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampedPose {
    /// Seconds. KITTI pose files carry no times: there it is the row or frame number until
    /// [`TrajectoryFile::at_frames`].
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
    /// Twelve numbers a line: the upper 3x4 of `world_from_cam`, row by row, or 16 of the whole matrix; or one more with a frame
    /// number or a time in front.
    Kitti,
    /// Eight numbers a line: seconds, position, quaternion x y z w; or seven without time.
    Tum,
    /// Comma separated: nanoseconds, position, quaternion w x y z, anything more. Under a header that names `qx` before `qw`
    /// (VSLAM-LAB) the quaternion is x y z w.
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
    /// The poses with times in seconds: poses of frames get those of their frames, `times_s`, of which the first has the number
    /// `first`; poses of later frames are skipped.
    pub fn at_frames(mut self, times_s: &[f64], first: u32) -> Trajectory {
        if self.stamps != Stamps::Times {
            let first = if self.stamps == Stamps::FrameNumbers { f64::from(first) } else { 0.0 };
            let time = |pose: &StampedPose| {
                let position = Some(pose.timestamp_s - first).filter(|position| *position >= 0.0)?;
                let timestamp_s = *times_s.get(position as usize)?;
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
    let (file, odd) = read_lenient(path, format)?;
    odd.map_or(Ok(file), |(problem, _)| Err(problem))
}

/// Reads a trajectory as far as it can be read; beside it what is wrong with the first line that cannot, and how many there are.
///
/// # Errors
/// [`FileError`] for a missing or empty file, an unknown format, and where no line can be read.
pub(crate) fn read_lenient(
    path: &Path,
    format: Option<TrajectoryFormat>,
) -> Result<(TrajectoryFile, Option<(FileError, usize)>), FileError> {
    let expected = format.map_or(ANY_FORMAT, TrajectoryFormat::row);
    let file = TextFile::read(path, expected)?;
    let mut lines = file.data_lines().peekable();
    let header = lines.next_if(is_header).map(|line| line.text.to_ascii_lowercase());
    let first = lines.peek().copied().ok_or_else(|| file.empty(expected))?;
    let format = format.map_or_else(|| detect(&first), Ok)?;
    let rows = Rows::of(format, &first, header.as_deref());
    let mut poses: Vec<StampedPose> = Vec::new();
    let mut n_repeated_times = 0;
    let mut odd: Option<(FileError, usize)> = None;
    for (number, line) in lines.enumerate() {
        let previous_s = poses.last().map(|pose| pose.timestamp_s);
        let pose = rows.read(&line, number).and_then(|pose| {
            let is_repeated = format != TrajectoryFormat::Kitti && previous_s == Some(pose.timestamp_s);
            if is_repeated {
                return Ok(None);
            }
            check_increasing(&line, previous_s, pose.timestamp_s).map(|()| Some(pose))
        });
        match pose {
            Ok(Some(pose)) => poses.push(pose),
            Ok(None) => n_repeated_times += 1,
            Err(problem) => odd = Some(odd.map_or((problem, 1), |(first, n)| (first, n + 1))),
        }
    }
    if let (true, Some((problem, _))) = (poses.is_empty(), &odd) {
        return Err(problem.clone());
    }
    let stamps = match format {
        _ if !rows.is_stamped => Stamps::Rows,
        TrajectoryFormat::Kitti if poses.iter().all(|pose| is_frame_number(pose.timestamp_s)) => {
            Stamps::FrameNumbers
        }
        _ => Stamps::Times,
    };
    Ok((TrajectoryFile { trajectory: Trajectory { poses }, format, stamps, n_repeated_times }, odd))
}

/// Reads a pose from a file of its own: a 4x4 matrix, row by row.
///
/// # Errors
/// [`FileError`] for anything else.
pub(crate) fn read_matrix(path: &Path) -> Result<SE3, FileError> {
    const EXPECTED: &str = "16 numbers (a 4x4 pose, row by row)";
    let file = TextFile::read(path, EXPECTED)?;
    let first = file.data_lines().next().ok_or_else(|| file.empty(EXPECTED))?;
    let fields = file.data_lines().flat_map(|line| line.text.split_whitespace());
    let matrix: [f64; 16] = first.numbers(fields, EXPECTED)?;
    kitti::pose_of_matrix(&first, &matrix)
}

/// How the rows of a file are read.
struct Rows {
    format: TrajectoryFormat,
    /// Whether a time or a frame number stands in front.
    is_stamped: bool,
    /// The quaternion of comma separated rows begins with w.
    w_first: bool,
}

impl Rows {
    fn of(format: TrajectoryFormat, first: &Line<'_>, header: Option<&str>) -> Self {
        let n = first.text.split_whitespace().count();
        let is_stamped = match format {
            TrajectoryFormat::Kitti => kitti::STAMPED_COLUMNS.contains(&n),
            TrajectoryFormat::Tum => n != tum::UNSTAMPED_COLUMNS,
            TrajectoryFormat::Euroc => true,
        };
        let at = |name: &str| header.and_then(|header| header.find(name));
        let w_first = at("qx").zip(at("qw")).is_none_or(|(x, w)| w < x);
        Self { format, is_stamped, w_first }
    }

    fn read(&self, line: &Line<'_>, number: usize) -> Result<StampedPose, FileError> {
        match self.format {
            TrajectoryFormat::Kitti if self.is_stamped => kitti::stamped_row(line),
            TrajectoryFormat::Kitti => kitti::row(line, number),
            TrajectoryFormat::Tum if self.is_stamped => tum::row(line),
            TrajectoryFormat::Tum => tum::unstamped_row(line, number),
            TrajectoryFormat::Euroc => euroc::row(line, self.w_first),
        }
    }
}

/// Whether a line gives names of columns.
fn is_header(line: &Line<'_>) -> bool {
    let text = line.text.to_ascii_lowercase();
    text.contains("qw") && text.contains("qx") || text.starts_with("timestamp") || text.starts_with("ts ")
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
        12 | 13 | 16 | 17 => Ok(TrajectoryFormat::Kitti),
        tum::UNSTAMPED_COLUMNS | 8 => Ok(TrajectoryFormat::Tum),
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

/// A pose with a quaternion as files round it; refuses one that is far from unit length.
fn pose(
    line: &Line<'_>,
    timestamp_s: f64,
    position: [f64; 3],
    [w, x, y, z]: [f64; 4],
) -> Result<StampedPose, FileError> {
    /// Files keep four decimals or more; a larger deviation is not due to rounding.
    const TOLERANCE: f64 = 0.01;
    let quaternion = nalgebra::Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    if (norm - 1.0).abs() > TOLERANCE {
        return Err(line.error(format!("a quaternion of length {norm:.6}"), "a unit quaternion"));
    }
    let rotation = SO3::from_quaternion(&geometry::Quaternion::from_quaternion(quaternion));
    Ok(StampedPose { timestamp_s, world_from_cam: SE3::new(rotation, position.into()) })
}

/// Position and quaternion x, y, z, w.
fn numbers(pose: &SE3) -> [f64; 7] {
    let (t, q) = (pose.translation, pose.rotation.to_quaternion());
    [t.x, t.y, t.z, q.i, q.j, q.k, q.w]
}

/// Writes a header and a row of a stamp and seven numbers per pose, exact to 1e-9 when read back.
fn write_rows<S: std::fmt::Display>(
    path: &Path,
    header: &str,
    separator: char,
    rows: impl Iterator<Item = (S, [f64; 7])>,
) -> Result<(), FileError> {
    let mut text = header.to_owned();
    for (stamp, numbers) in rows {
        // Writing to a string cannot fail.
        let _ = write!(text, "{stamp}");
        for number in numbers {
            let _ = write!(text, "{separator}{number:.12}");
        }
        text.push('\n');
    }
    write_atomic(path, text.as_bytes())
}
