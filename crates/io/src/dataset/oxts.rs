//! KITTI raw's ground truth: `oxts/data`, a file per frame with latitude, longitude, altitude, roll, pitch and yaw of the inertial
//! unit, by the formulas of the dataset's development kit (Mercator projection).

use std::path::Path;

use geometry::{Mat3, SE3, SO3, Vec3};

use super::FrameSource;
use super::numbered::list_numbered;
use super::stamps::seconds;
use crate::file::{TextFile, counted};
use crate::trajectory::{StampedPose, Trajectory};

/// Radius of the earth that the kit uses, meters.
const EARTH_RADIUS_M: f64 = 6_378_137.0;

/// Poses of the inertial unit at the frames that have a file, relative to the first one, and camera 0 (rectified) in that unit;
/// `None` without such files. What cannot be read is told in `warnings` and never stops the run.
pub(super) fn read(
    root: &Path,
    frames: &[FrameSource],
    warnings: &mut Vec<String>,
) -> Option<(Trajectory, SE3)> {
    let folder = root.join("oxts/data");
    let files = list_numbered(&folder, &["txt"]).ok().filter(|files| !files.is_empty())?;
    let mut poses: Vec<StampedPose> = Vec::new();
    let (mut scale, mut n_odd) = (None, 0);
    for frame in frames {
        let Some(path) = files.get(&frame.index) else { continue };
        let Some([latitude, longitude, altitude, roll, pitch, yaw]) = first_six(path) else {
            n_odd += 1;
            continue;
        };
        let scale = *scale.get_or_insert(latitude.to_radians().cos());
        let place = Vec3::new(
            scale * EARTH_RADIUS_M * longitude.to_radians(),
            scale * EARTH_RADIUS_M * (std::f64::consts::FRAC_PI_4 + latitude.to_radians() / 2.0).tan().ln(),
            altitude,
        );
        let turn =
            SO3::exp(&(Vec3::z() * yaw)) * SO3::exp(&(Vec3::y() * pitch)) * SO3::exp(&(Vec3::x() * roll));
        let world_from_cam = SE3::new(turn, place);
        poses.push(StampedPose { timestamp_s: seconds(frame.timestamp_ns), world_from_cam });
    }
    if n_odd > 0 {
        let files = counted(n_odd, "file");
        warnings
            .push(format!("{}: {files} without six numbers left out of the ground truth", folder.display()));
    }
    // Small numbers keep their digits.
    let origin = poses.first()?.world_from_cam.inverse();
    poses.iter_mut().for_each(|pose| pose.world_from_cam = origin * pose.world_from_cam);
    Some((Trajectory { poses }, imu_from_camera0(root, warnings)))
}

fn first_six(path: &Path) -> Option<[f64; 6]> {
    let file = TextFile::read(path, "a line of numbers").ok()?;
    let line = file.data_lines().next()?;
    line.numbers::<6>(line.text.split_whitespace().take(6), "numbers").ok()
}

/// Camera 0, rectified, in the inertial unit: over the laser scanner where the files say how, else as it looks, forward.
fn imu_from_camera0(root: &Path, warnings: &mut Vec<String>) -> SE3 {
    let file = |name: &str| {
        let places = [root.join(name), root.join("..").join(name)];
        places.into_iter().find(|path| path.is_file())
    };
    let found = || {
        let velo_from_imu = motion(&file("calib_imu_to_velo.txt")?)?;
        let camera_from_velo = motion(&file("calib_velo_to_cam.txt")?)?;
        let rectified_from_camera = file("calib_cam_to_cam.txt")
            .and_then(|path| matrix(&path, "R_rect_00"))
            .map_or(SO3::identity(), |rows| SO3::from_matrix(&rows));
        let turn = SE3::new(rectified_from_camera, Vec3::zeros());
        Some((turn * camera_from_velo * velo_from_imu).inverse())
    };
    found().unwrap_or_else(|| {
        warnings.push(format!(
            "{}: no calib_imu_to_velo.txt and calib_velo_to_cam.txt, so the camera is taken to be where the inertial unit is",
            root.display()
        ));
        // x forward, y left, z up of the unit; x right, y down, z forward of the camera.
        let turn = Mat3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
        SE3::new(SO3::from_matrix(&turn), Vec3::zeros())
    })
}

/// `R: 9 numbers`, `T: 3 numbers`.
fn motion(path: &Path) -> Option<SE3> {
    let t = numbers(path, "T")?;
    let [x, y, z] = t[..] else { return None };
    Some(SE3::new(SO3::from_matrix(&matrix(path, "R")?), Vec3::new(x, y, z)))
}

fn matrix(path: &Path, name: &str) -> Option<Mat3> {
    numbers(path, name).filter(|rows| rows.len() == 9).map(|rows| Mat3::from_row_slice(&rows))
}

fn numbers(path: &Path, name: &str) -> Option<Vec<f64>> {
    let file = TextFile::read(path, "a calibration").ok()?;
    file.data_lines().find_map(|line| {
        let (key, rest) = line.text.split_once(':')?;
        let all = rest.split_whitespace().map(|word| word.parse().ok()).collect::<Option<Vec<f64>>>();
        all.filter(|_| key.trim() == name)
    })
}
