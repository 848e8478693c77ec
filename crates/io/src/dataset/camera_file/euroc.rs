//! `sensor.yaml` of an EuRoC camera: resolution, intrinsics, lens, pose in the body.

use super::{CameraFile, DatasetError, FileCamera, lens, part};
use crate::document::Field;

const MODEL: &str = "pinhole";

pub(super) fn is(root: &Field<'_>) -> bool {
    ["camera_model", "intrinsics"].iter().all(|key| root.at(key).is_there())
        || root.at("T_BS").is_there()
        || root.at("sensor_type").is_there()
}

/// Reads the camera; all fields are needed but the rate.
pub(super) fn read(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    let model = root.at("camera_model");
    model.need(MODEL)?;
    if model.text(MODEL)? != MODEL {
        return Err(model.wrong(MODEL));
    }
    let pinhole = part::pinhole(&root.at("intrinsics"), "4 numbers (fu, fv, cu, cv in pixels)")?;
    let model = lens::model(pinhole, &root.at("distortion_model"), &root.at("distortion_coefficients"))?;
    let size = root.at("resolution");
    size.need(part::SIZE)?;
    let pose = root.at("T_BS");
    pose.need(part::POSE)?;
    let body_from_cam = part::rigid(&pose, part::POSE)?;
    let camera = FileCamera { model, size: Some(part::size(&size)?), body_from_cam };
    Ok(CameraFile {
        right_fields: ("resolution", "T_BS"),
        ..CameraFile::new(root.path, "EuRoC sensor.yaml", vec![camera])
    })
}
