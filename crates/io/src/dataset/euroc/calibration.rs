//! The cameras of an EuRoC sequence.

use std::path::Path;

use super::super::camera_file::sensor;
use super::super::cameras::{Cameras, Origin};
use super::super::{DatasetError, Sensor};

/// Reads what the sensor needs; without any `sensor.yaml` the configuration must give the camera of rectified images.
pub(super) fn read(root: &Path, sensor: Sensor, warnings: &mut Vec<String>) -> Result<Cameras, DatasetError> {
    let [left, right] = ["cam0", "cam1"].map(|camera| root.join(camera).join("sensor.yaml"));
    if !left.exists() && (sensor == Sensor::Mono || !right.exists()) {
        warnings.push(format!(
            "{}: no such file, so the configuration must give the camera of rectified images",
            left.display()
        ));
        return Ok(Cameras::default());
    }
    let left_camera = sensor::read(&left)?;
    if sensor != Sensor::Stereo {
        return Cameras::of_one(left_camera, &left);
    }
    let right_camera = sensor::read(&right)?;
    let origin = Origin { left: &left, right: &right, size_field: "resolution", pose_field: "T_BS" };
    Cameras::of_pair(left_camera, right_camera, &origin)
}
