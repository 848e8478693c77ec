//! DSSLAM's own calibration file: cameras with model, resolution, intrinsics and lens, and the way from left to right.

use geometry::SE3;

use super::{CameraFile, DatasetError, FileCamera, lens, part};
use crate::document::Field;
use crate::file::counted;

const CAMERAS: &str = "a list of one camera, or of the left and the right one";
const MOTION: &str = "3 rows of 4 numbers (rotation and translation in meters: x_right = R x_left + t)";
const KEYS: [&str; 5] = ["fps", "cameras", "right_from_left", "depth_units_per_metre", "baseline_m"];
const CAMERA_KEYS: [&str; 4] = ["model", "resolution", "intrinsics", "distortion"];

pub(super) fn is(root: &Field<'_>) -> bool {
    root.at("cameras").is_there() || KEYS.iter().any(|key| root.at(key).is_there() && *key != "baseline_m")
}

/// Reads a calibration in our own format (described in docs/inputs.md).
pub(super) fn read(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    check_keys(root, &KEYS)?;
    let list = root.at("cameras");
    list.need(CAMERAS)?;
    let items = list.items();
    if !list.is_list() || !(1..=2).contains(&items.len()) {
        return Err(list.error(counted(items.len(), "camera"), CAMERAS));
    }
    let mut cameras = items.iter().map(read_camera).collect::<Result<Vec<_>, _>>()?;
    let motion = root.at("right_from_left");
    match cameras.get_mut(1) {
        Some(right) => {
            motion.need(MOTION)?;
            right.body_from_cam = read_motion(&motion)?.inverse();
        }
        None if motion.is_there() => {
            return Err(motion.error("1 camera for a motion between two", "it only with two cameras"));
        }
        None => {}
    }
    Ok(CameraFile {
        frame_rate_hz: part::rate(&root.at("fps"))?,
        depth_units_per_metre: part::depth_units(&root.at("depth_units_per_metre"))?,
        baseline_m: root.at("baseline_m").if_there(|field| field.positive("meters, above 0"))?,
        right_fields: ("cameras[1].resolution", "right_from_left"),
        ..CameraFile::new(root.path, "our YAML", cameras)
    })
}

fn read_camera(camera: &Field<'_>) -> Result<FileCamera, DatasetError> {
    check_keys(camera, &CAMERA_KEYS)?;
    let pinhole = part::pinhole(&camera.at("intrinsics"), "4 numbers (fx, fy, cx, cy in pixels)")?;
    let model = lens::model(pinhole, &camera.at("model"), &camera.at("distortion"))?;
    let size = camera.at("resolution").if_there(part::size)?;
    Ok(FileCamera { model, size, body_from_cam: SE3::identity() })
}

/// Three rows of four numbers, or four with the last one 0 0 0 1.
fn read_motion(motion: &Field<'_>) -> Result<SE3, DatasetError> {
    let rows = motion.items();
    if !(3..=4).contains(&rows.len()) {
        return Err(motion.error(counted(rows.len(), "row"), MOTION));
    }
    if let Some(row) = rows.iter().find(|row| row.items().len() != 4) {
        return Err(motion.error(format!("a row of {}", counted(row.items().len(), "number")), MOTION));
    }
    part::rigid(motion, MOTION)
}

/// Our own format has no field that is not read.
fn check_keys(section: &Field<'_>, known: &[&str]) -> Result<(), DatasetError> {
    match section.keys().find(|key| !known.contains(key)) {
        Some(key) => Err(section.at(key).error("an unknown field", format!("one of {}", known.join(", ")))),
        None => Ok(()),
    }
}
