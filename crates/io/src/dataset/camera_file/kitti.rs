//! KITTI's calibrations in plain text: a line per camera with its 3x4 projection matrix K [I | t], row by row; `P0` in
//! `calib.txt` of the odometry benchmark, `P_rect_00` in `calib_cam_to_cam.txt` of the raw drives and in KITTI-360's
//! `perspective.txt`.

use std::path::Path;

use geometry::{CameraModel, Distortion, Pinhole, SE3, SO3, StereoRig, Vec3};

use super::super::Calibration;
use super::{CameraFile, DatasetError, FileCamera};
use crate::file::{FileError, Line, TextFile, shown};
use crate::images::ImageSize;

/// What the format is called.
pub(super) const FORMAT: &str = "KITTI calibration";

const EXPECTED: &str = "12 numbers (projection matrix, row by row)";

/// One rectified camera: x_cam = x_cam0 + t.
struct Projection {
    camera: Pinhole,
    /// t in meters.
    offset: Vec3,
    line: usize,
}

/// The calibration of a pair, and where its left camera stands.
pub(in super::super) struct KittiCalibration {
    pub(in super::super) calibration: Calibration,
    /// Position of the left camera in the frame of camera 0, meters; the ground truth is that of camera 0.
    pub(in super::super) left_in_camera0: Vec3,
}

/// Whether a line is one of such a file.
pub(super) fn is(line: &Line<'_>) -> bool {
    let Some((key, _)) = line.text.split_once(':') else { return false };
    let numbered = |key: &str| key.len() <= 2 && !key.is_empty() && key.bytes().all(|b| b.is_ascii_digit());
    let projection = key.strip_prefix("P_rect_").or(key.strip_prefix('P'));
    projection.is_some_and(numbered) || ["calib_time", "corner_dist", "S_00", "K_00"].contains(&key)
}

/// Reads cameras 0 and 1, or the first one that is there.
pub(super) fn read(file: &TextFile) -> Result<CameraFile, DatasetError> {
    let pairs = [[0, 1], [2, 3]];
    let has = |n: usize| names(n).iter().any(|name| find(file, name).is_some());
    let [left, right] = pairs.into_iter().find(|[left, _]| has(*left)).unwrap_or(pairs[0]);
    let pair = read_pair(file, left, has(right).then_some(right))?;
    let rig = pair.calibration.rig;
    let model = CameraModel::Pinhole { camera: rig.camera, distortion: Distortion::default() };
    let size = size(file, left)?;
    let place = |x: f64| SE3::new(SO3::identity(), Vec3::new(x, 0.0, 0.0));
    let mut cameras = vec![FileCamera { model, size, body_from_cam: SE3::identity() }];
    if rig.baseline_m > 0.0 {
        cameras.push(FileCamera { model, size, body_from_cam: place(rig.baseline_m) });
    }
    Ok(CameraFile::new(&file.path, FORMAT, cameras))
}

/// Reads the left camera and, if a number is given, the right one; the baseline is the difference of their offsets.
pub(in super::super) fn read_file(
    path: &Path,
    left: usize,
    right: Option<usize>,
) -> Result<KittiCalibration, DatasetError> {
    read_pair(&TextFile::read(path, "a KITTI calibration file")?, left, right)
}

fn read_pair(file: &TextFile, left: usize, right: Option<usize>) -> Result<KittiCalibration, DatasetError> {
    let left = find_projection(file, left)?;
    let baseline_m = match right {
        Some(right) => baseline(file, &left, &find_projection(file, right)?)?,
        None => 0.0,
    };
    let calibration = Calibration {
        rig: StereoRig { camera: left.camera, baseline_m },
        distortion: Distortion::default(),
        source: file.path.display().to_string(),
    };
    Ok(KittiCalibration { calibration, left_in_camera0: -left.offset })
}

/// The names of a camera's line.
fn names(camera: usize) -> [String; 2] {
    [format!("P{camera}"), format!("P_rect_{camera:02}")]
}

/// The line of this name, and what stands in it.
fn find<'a>(file: &'a TextFile, name: &str) -> Option<(Line<'a>, &'a str)> {
    file.data_lines().find_map(|line| {
        let (key, numbers) = line.text.split_once(':')?;
        (key.trim() == name).then_some((line, numbers))
    })
}

fn find_projection(file: &TextFile, camera: usize) -> Result<Projection, DatasetError> {
    let names = names(camera);
    let Some((name, (line, numbers))) =
        names.iter().find_map(|name| Some((name.as_str(), find(file, name)?)))
    else {
        let [name, raw] = &names;
        return Err(DatasetError::unexpected(&file.path, format!("no line `{name}:` or `{raw}:`"), EXPECTED));
    };
    let matrix = line.numbers::<12>(numbers.split_whitespace(), EXPECTED)?;
    Ok(projection(&line, name, &matrix)?)
}

/// The size of the rectified images, which raw drives tell.
fn size(file: &TextFile, camera: usize) -> Result<Option<ImageSize>, FileError> {
    let Some((line, numbers)) = find(file, &format!("S_rect_{camera:02}")) else { return Ok(None) };
    let [width, height] = line.numbers(numbers.split_whitespace(), "width and height in pixels")?;
    Ok(Some(ImageSize { width: width as usize, height: height as usize }))
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
