//! KITTI pose files: a line per frame with the upper 3x4 of `world_from_cam`, row by row; no times.

use std::fmt::Write as _;
use std::path::Path;

use geometry::{Mat3, SE3, SO3, Vec3};

use super::{StampedPose, Trajectory};
use crate::file::{FileError, Line, write_atomic};

pub(super) const EXPECTED: &str = "12 numbers (the 3x4 pose, row by row)";
const EXPECTED_STAMPED: &str = "13 numbers (frame number or time, and the 3x4 pose, row by row)";
/// Columns of a row with a frame number or a time in front of 12 or 16.
pub(super) const STAMPED_COLUMNS: [usize; 2] = [13, 17];

/// Row number `index` of a file without frame numbers: 12 numbers, or the 16 of the whole matrix.
pub(super) fn row(line: &Line<'_>, index: usize) -> Result<StampedPose, FileError> {
    let world_from_cam = if line.text.split_whitespace().count() == 16 {
        pose_of_matrix(line, &line.numbers(line.text.split_whitespace(), EXPECTED)?)?
    } else {
        pose_from_row(line, &line.numbers(line.text.split_whitespace(), EXPECTED)?)?
    };
    Ok(StampedPose { timestamp_s: index as f64, world_from_cam })
}

/// A row with a frame number or a time in front.
pub(super) fn stamped_row(line: &Line<'_>) -> Result<StampedPose, FileError> {
    if line.text.split_whitespace().count() == STAMPED_COLUMNS[1] {
        let [timestamp_s, matrix @ ..] =
            line.numbers::<17>(line.text.split_whitespace(), EXPECTED_STAMPED)?;
        return Ok(StampedPose { timestamp_s, world_from_cam: pose_of_matrix(line, &matrix)? });
    }
    let [timestamp_s, row @ ..] = line.numbers::<13>(line.text.split_whitespace(), EXPECTED_STAMPED)?;
    Ok(StampedPose { timestamp_s, world_from_cam: pose_from_row(line, &row)? })
}

/// The pose of a 4x4 matrix, whose last row must be 0 0 0 1.
pub(super) fn pose_of_matrix(line: &Line<'_>, matrix: &[f64; 16]) -> Result<SE3, FileError> {
    let [row @ .., a, b, c, d] = matrix;
    if [*a, *b, *c, *d] != [0.0, 0.0, 0.0, 1.0] {
        return Err(line.error(format!("{a} {b} {c} {d} as last row of the matrix"), "0 0 0 1"));
    }
    pose_from_row(line, row)
}

/// The pose of twelve numbers, its rotation as it is written.
fn pose_from_row(line: &Line<'_>, row: &[f64; 12]) -> Result<SE3, FileError> {
    /// Published files keep six digits; a larger deviation is not due to rounding.
    const TOLERANCE: f64 = 0.01;
    let matrix = Mat3::new(row[0], row[1], row[2], row[4], row[5], row[6], row[8], row[9], row[10]);
    let deviation = (matrix.transpose() * matrix - Mat3::identity()).amax();
    let is_mirrored = matrix.determinant() < 0.0;
    if deviation > TOLERANCE || is_mirrored {
        let why =
            if is_mirrored { "a mirror image".to_string() } else { format!("deviation {deviation:.3}") };
        return Err(line.error(
            format!("a 3x3 matrix that is not a rotation ({why})"),
            "a pose whose first three columns are a rotation",
        ));
    }
    Ok(SE3::new(SO3::from_matrix_unchecked(matrix), Vec3::new(row[3], row[7], row[11])))
}

/// Writes a KITTI pose file, a line per pose; reading it back is exact to 1e-9 relative.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn write_kitti(path: &Path, trajectory: &Trajectory) -> Result<(), FileError> {
    let mut text = String::with_capacity(trajectory.poses.len() * 12 * 20);
    for pose in &trajectory.poses {
        let row = pose.world_from_cam.rows_3x4();
        for (column, value) in row.iter().enumerate() {
            let separator = if column == 0 { "" } else { " " };
            // Writing to a string cannot fail.
            let _ = write!(text, "{separator}{}", scientific(*value));
        }
        text.push('\n');
    }
    write_atomic(path, text.as_bytes())
}

/// A number as C's `%.12e` writes it, which is the form of KITTI's own files.
fn scientific(value: f64) -> String {
    let plain = format!("{value:.12e}");
    match plain.split_once('e') {
        Some((mantissa, exponent)) => {
            let (sign, digits) = match exponent.strip_prefix('-') {
                Some(digits) => ('-', digits),
                None => ('+', exponent),
            };
            format!("{mantissa}e{sign}{digits:0>2}")
        }
        None => plain,
    }
}
