//! KITTI's `calib.txt`: a line `P0: ...` per camera with its 3x4 projection matrix K [I | t], row by row.

use std::path::Path;

use geometry::{Distortion, Pinhole, StereoRig, Vec3};

use super::{Calibration, DatasetError};
use crate::file::{FileError, Line, TextFile, shown};

const EXPECTED: &str = "12 numbers (projection matrix, row by row)";

/// One rectified camera: x_cam = x_cam0 + t.
struct Projection {
    camera: Pinhole,
    /// t in meters.
    offset: Vec3,
    line: usize,
}

/// The calibration of a pair, and where its left camera stands.
pub(super) struct KittiCalibration {
    pub(super) calibration: Calibration,
    /// Position of the left camera in the frame of camera 0, meters; the ground truth is that of camera 0.
    pub(super) left_in_camera0: Vec3,
}

/// Reads the left camera and, if a name is given, the right one; the baseline is the difference of their offsets.
pub(super) fn read(path: &Path, left: &str, right: Option<&str>) -> Result<KittiCalibration, DatasetError> {
    let file = TextFile::read(path, "a KITTI calibration file")?;
    let left = find_projection(&file, left)?;
    let baseline_m = match right {
        Some(name) => baseline(&file, &left, &find_projection(&file, name)?)?,
        None => 0.0,
    };
    let calibration = Calibration {
        rig: StereoRig { camera: left.camera, baseline_m },
        distortion: Distortion::default(),
        source: path.display().to_string(),
    };
    Ok(KittiCalibration { calibration, left_in_camera0: -left.offset })
}

fn find_projection(file: &TextFile, name: &str) -> Result<Projection, DatasetError> {
    let found = file.data_lines().find_map(|line| {
        let (key, numbers) = line.text.split_once(':')?;
        (key.trim() == name).then_some((line, numbers))
    });
    let Some((line, numbers)) = found else {
        return Err(DatasetError::MissingCamera { path: file.path.clone(), camera: name.to_string() });
    };
    let matrix = line.numbers::<12>(numbers.split_whitespace(), EXPECTED)?;
    Ok(projection(&line, name, &matrix)?)
}

/// Takes K [I | t] apart; the matrix must have that form.
fn projection(line: &Line<'_>, name: &str, matrix: &[f64; 12]) -> Result<Projection, FileError> {
    let [fx, skew, cx, px, zero, fy, cy, py, r0, r1, r2, pz] = *matrix;
    for (value, what) in [(fx, "fx"), (fy, "fy")] {
        if value <= 0.0 {
            return Err(line.error(format!("{what} = {value} in {name}"), "a focal length above 0 px"));
        }
    }
    if [skew, zero, r0, r1] != [0.0; 4] || r2 != 1.0 {
        return Err(
            line.error(shown(line.text), "a rectified projection matrix fx 0 cx tx 0 fy cy ty 0 0 1 tz")
        );
    }
    let offset = Vec3::new((px - cx * pz) / fx, (py - cy * pz) / fy, pz);
    Ok(Projection { camera: Pinhole { fx, fy, cx, cy }, offset, line: line.number })
}

/// Baseline in meters; the two cameras must be rectified and the right one must stand to the right.
fn baseline(file: &TextFile, left: &Projection, right: &Projection) -> Result<f64, FileError> {
    let error = |found: String, expected: &str| FileError::Line {
        path: file.path.clone(),
        line: right.line,
        found,
        expected: expected.to_string(),
    };
    if left.camera != right.camera {
        let found = format!("fx fy cx cy = {} for the right camera", intrinsics(&right.camera));
        return Err(error(
            found,
            &format!("{} as for the left camera (rectified)", intrinsics(&left.camera)),
        ));
    }
    // b = (P[3] of left - P[3] of right) / fx
    let baseline_m = left.offset.x - right.offset.x;
    if baseline_m <= 0.0 {
        return Err(error(
            format!("a baseline of {baseline_m} m"),
            "a baseline above 0 m (right camera to the right)",
        ));
    }
    Ok(baseline_m)
}

fn intrinsics(camera: &Pinhole) -> String {
    format!("{} {} {} {}", camera.fx, camera.fy, camera.cx, camera.cy)
}
