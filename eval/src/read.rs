//! Trajectory files: KITTI poses (with or without a frame number in front), TUM and EuRoC.

use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
use geometry::{Mat3, SE3, SO3, Vec3};
use io::{StampedPose, Trajectory};
use nalgebra::{Quaternion, UnitQuaternion};
use serde::Serialize;

/// Largest entry of `R^T R - I` that still passes for rounding in a file.
const ROTATION_TOLERANCE: f64 = 0.01;

/// The layout of a trajectory file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// 12 numbers a line (3x4 of `world_from_cam`), one line per frame; or 13 with the frame number in front.
    Kitti,
    /// 8 numbers a line: seconds, position, quaternion x y z w.
    Tum,
    /// Comma separated: nanoseconds, position, quaternion w x y z, anything more.
    Euroc,
}

/// A trajectory as its file gives it.
#[derive(Clone, Debug)]
pub struct TrajectoryFile {
    /// Poses with their times; KITTI files: the time is the frame number.
    pub trajectory: Trajectory,
    /// Layout of the file.
    pub format: Format,
    /// Whether each line carries its frame number (KITTI with 13 columns), so that frames may be missing.
    pub has_frame_numbers: bool,
    /// Rows left out because their time equals that of the row before.
    pub n_repeated_times: usize,
}

/// Reads a trajectory; without `format` the first line with data decides.
///
/// KITTI matrices are kept as written, not made orthonormal: the devkit takes them as they are, and its published
/// figures depend on it in the seventh digit.
///
/// # Errors
/// The file cannot be read, is empty, has a row of the wrong length, a value that is no finite number, a matrix that
/// is no rotation, or times (frame numbers) that do not increase; the message names file and line.
pub fn read_trajectory_file(path: &Path, format: Option<Format>) -> Result<TrajectoryFile> {
    match format {
        Some(Format::Kitti) => read_kitti(path),
        Some(timed) => read_timed(path, timed),
        None => read_trajectory_file(path, Some(detect(path)?)),
    }
}

fn detect(path: &Path) -> Result<Format> {
    let text = read_text(path)?;
    let Some((number, line)) = data_lines(&text).next() else {
        bail!("{}: the file is empty", path.display())
    };
    if line.contains(',') {
        return Ok(Format::Euroc);
    }
    match line.split_ascii_whitespace().count() {
        8 => Ok(Format::Tum),
        12 | 13 => Ok(Format::Kitti),
        n => bail!(
            "{}:{number}: found {n} numbers; expected 12 (KITTI; 13 with the frame number in front), 8 (TUM) or \
             values separated by commas (EuRoC)",
            path.display()
        ),
    }
}

fn read_kitti(path: &Path) -> Result<TrajectoryFile> {
    let text = read_text(path)?;
    let mut poses: Vec<StampedPose> = Vec::new();
    let mut columns = None;
    for (number, line) in data_lines(&text) {
        let place = || format!("{}:{number}", path.display());
        let values = numbers(line.split_ascii_whitespace()).with_context(place)?;
        let n_columns = *columns.get_or_insert(values.len());
        ensure!(
            matches!(values.len(), 12 | 13) && values.len() == n_columns,
            "{}: found {} numbers, expected {}",
            place(),
            values.len(),
            if n_columns == 13 { "13 (frame number and 3x4 pose)" } else { "12 (the 3x4 pose, row by row)" }
        );
        let frame = if n_columns == 13 { values[0] } else { poses.len() as f64 };
        ensure!(frame >= 0.0 && frame.fract() == 0.0, "{}: {frame} is no frame number", place());
        if let Some(previous) = poses.last().filter(|p| p.timestamp_s >= frame) {
            bail!("{}: frame number {frame} after {} does not increase", place(), previous.timestamp_s);
        }
        let world_from_cam = pose(&values[n_columns - 12..]).with_context(place)?;
        poses.push(StampedPose { timestamp_s: frame, world_from_cam });
    }
    ensure!(!poses.is_empty(), "{}: the file is empty", path.display());
    Ok(TrajectoryFile {
        trajectory: Trajectory { poses },
        format: Format::Kitti,
        has_frame_numbers: columns == Some(13),
        n_repeated_times: 0,
    })
}

/// TUM and EuRoC: a time, a position and a quaternion.
fn read_timed(path: &Path, format: Format) -> Result<TrajectoryFile> {
    let text = read_text(path)?;
    let mut poses: Vec<StampedPose> = Vec::new();
    let mut n_repeated_times = 0;
    for (number, line) in data_lines(&text) {
        let place = || format!("{}:{number}", path.display());
        let pose = if format == Format::Tum { tum_row(line) } else { euroc_row(line) }.with_context(place)?;
        match poses.last().map(|previous| previous.timestamp_s) {
            Some(before) if pose.timestamp_s < before => bail!(
                "{}: timestamps are not increasing: {:.6} s after {before:.6} s",
                place(),
                pose.timestamp_s
            ),
            // Happens in published ground truth (TUM fr2/desk): the first of equal times counts.
            Some(before) if pose.timestamp_s == before => n_repeated_times += 1,
            _ => poses.push(pose),
        }
    }
    ensure!(!poses.is_empty(), "{}: the file is empty", path.display());
    Ok(TrajectoryFile {
        trajectory: Trajectory { poses },
        format,
        has_frame_numbers: false,
        n_repeated_times,
    })
}

fn tum_row(line: &str) -> Result<StampedPose> {
    let v = numbers(line.split_ascii_whitespace())?;
    ensure!(v.len() == 8, "found {} numbers, expected 8 (timestamp tx ty tz qx qy qz qw)", v.len());
    stamped(v[0], [v[1], v[2], v[3]], [v[7], v[4], v[5], v[6]])
}

fn euroc_row(line: &str) -> Result<StampedPose> {
    let mut fields = line.split(',').map(str::trim);
    let n = fields.clone().count();
    ensure!(n >= 8, "found {n} fields, expected at least 8 (ns, px, py, pz, qw, qx, qy, qz)");
    let stamp = fields.next().unwrap_or_default();
    let Ok(nanoseconds) = stamp.parse::<u64>() else {
        bail!("found '{stamp}', expected whole nanoseconds");
    };
    let v = numbers(fields.take(7))?;
    stamped(nanoseconds as f64 * 1e-9, [v[0], v[1], v[2]], [v[3], v[4], v[5], v[6]])
}

fn stamped(timestamp_s: f64, position: [f64; 3], wxyz: [f64; 4]) -> Result<StampedPose> {
    let q = Quaternion::new(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    let length = q.norm();
    ensure!((length - 1.0).abs() <= ROTATION_TOLERANCE, "the quaternion has length {length:.6}, expected 1");
    let rotation = SO3::from_quaternion(&UnitQuaternion::from_quaternion(q));
    Ok(StampedPose { timestamp_s, world_from_cam: SE3::new(rotation, Vec3::from(position)) })
}

fn pose(row: &[f64]) -> Result<SE3> {
    let matrix = Mat3::new(row[0], row[1], row[2], row[4], row[5], row[6], row[8], row[9], row[10]);
    let deviation = (matrix.transpose() * matrix - Mat3::identity()).amax();
    ensure!(
        deviation <= ROTATION_TOLERANCE && matrix.determinant() > 0.0,
        "the first three columns are no rotation (R^T R differs from the identity by {deviation:.3})"
    );
    Ok(SE3::new(SO3::from_matrix_unchecked(matrix), Vec3::new(row[3], row[7], row[11])))
}

fn read_text(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

/// Lines with data and their numbers from 1; blank lines and comments (`#`) left out.
fn data_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

fn numbers<'a>(fields: impl Iterator<Item = &'a str>) -> Result<Vec<f64>> {
    fields
        .map(|field| match field.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(anyhow!("found {field}, expected a finite number")),
            Err(_) => Err(anyhow!("found '{field}', expected a number")),
        })
        .collect()
}
