//! The cameras of an EuRoC sequence.

use std::path::Path;

use geometry::SE3;

use super::super::camera_file::read_calibration;
use super::super::cameras::{Cameras, Origin};
use super::super::given::{Given, Own};
use super::super::{DatasetError, RawCamera, Sensor};
use crate::images::ImageSize;

/// Where TUM-VI and people who calibrate themselves have the calibration of both cameras.
const CHAINS: [&str; 5] = [
    "camchain.yaml",
    "dso/camchain.yaml",
    "mav0/camchain.yaml",
    "camchain-imucam.yaml",
    "kalibr_imucam_chain.yaml",
];

/// Reads what the sensor needs, with the sensor that is left of `(wanted, sensor)`; without any `sensor.yaml` the configuration must
/// give the camera of rectified images.
pub(super) fn read(
    dir: &Path,
    root: &Path,
    (wanted, sensor): (Option<Sensor>, Sensor),
    given: &Given,
    images: Option<ImageSize>,
    warnings: &mut Vec<String>,
) -> Result<(Sensor, Cameras), DatasetError> {
    let [left, right] = ["cam0", "cam1"].map(|camera| root.join(camera).join("sensor.yaml"));
    if given.file.is_none() {
        return Ok((sensor, own(dir, [&left, &right], sensor, images, warnings)?));
    }
    // The places of the layout's cameras in the body, which the given file may not know.
    let own = [&left, &right].into_iter().map_while(|path| camera(path, images).ok().flatten());
    let own: Vec<RawCamera> = own.collect();
    let source = right.display().to_string();
    let pair = (own.len() == 2).then_some(Own { cameras: &own, source: &source });
    let replaced = given.replace((wanted, sensor), pair, images, dir, warnings)?;
    let Some((sensor, mut cameras)) = replaced else { return Ok((sensor, Cameras::default())) };
    let file = given.file.as_ref();
    let knows_body = file.is_some_and(|file| file.cameras[0].body_from_cam != SE3::identity());
    let was_placed = sensor == Sensor::Stereo && file.is_some_and(|file| !file.has_pair());
    if let Some(left) = own.first().filter(|_| !knows_body && !was_placed) {
        cameras.body_from_left = left.body_from_cam * cameras.body_from_left;
    }
    Ok((sensor, cameras))
}

/// What the sequence's own files say.
fn own(
    dir: &Path,
    [left, right]: [&Path; 2],
    sensor: Sensor,
    images: Option<ImageSize>,
    warnings: &mut Vec<String>,
) -> Result<Cameras, DatasetError> {
    if !left.exists() && (sensor == Sensor::Mono || !right.exists()) {
        if let Some(chain) = CHAINS.iter().map(|name| dir.join(name)).find(|path| path.is_file()) {
            let file = read_calibration(&chain)?;
            warnings.extend(file.notes.iter().cloned());
            return file.in_body(sensor, images);
        }
        warnings.push(format!(
            "{}: no such file, so the configuration must give the camera of rectified images",
            left.display()
        ));
        return Ok(Cameras::default());
    }
    match (camera(left, images)?, sensor) {
        (Some(left_camera), Sensor::Stereo) => {
            let Some(right_camera) = camera(right, images)? else { return Ok(Cameras::default()) };
            let origin = Origin { left, right, size_field: "resolution", pose_field: "T_BS" };
            Cameras::of_pair(left_camera, right_camera, &origin)
        }
        (Some(left_camera), _) => Cameras::of_one(left_camera, left),
        (None, _) => Ok(Cameras::default()),
    }
}

/// The camera of a `sensor.yaml`.
fn camera(path: &Path, images: Option<ImageSize>) -> Result<Option<RawCamera>, DatasetError> {
    Ok(read_calibration(path)?.raw(Sensor::Mono, images)?.into_iter().next())
}
