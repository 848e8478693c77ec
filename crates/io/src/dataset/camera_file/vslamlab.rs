//! VSLAM-LAB's `calibration.yaml`: a list of cameras with their names.

use geometry::Pinhole;

use super::lens::{self, Lens};
use super::{CameraFile, DatasetError, FileCamera, part};
use crate::document::Field;

pub(super) fn is(root: &Field<'_>) -> bool {
    root.at("cameras").items().first().is_some_and(|camera| camera.at("focal_length").is_there())
}

/// Reads `rgb_0` and `rgb_1`.
pub(super) fn read(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    let items = root.at("cameras").items();
    let cameras = items.iter().take(2).map(camera).collect::<Result<Vec<_>, _>>()?;
    let depth = items.iter().map(|item| item.at("depth_factor")).find(Field::is_there);
    Ok(CameraFile {
        frame_rate_hz: part::rate(&items[0].at("fps"))?,
        depth_units_per_metre: depth.map(|field| part::depth_units(&field)).transpose()?.flatten(),
        right_fields: ("cameras[1].image_dimension", "cameras[1].T_BS"),
        ..CameraFile::new(root.path, "VSLAM-LAB calibration.yaml", cameras)
    })
}

fn camera(camera: &Field<'_>) -> Result<FileCamera, DatasetError> {
    let [fx, fy] = camera.at("focal_length").exactly("2 numbers (fx, fy in pixels)")?;
    let [cx, cy] = camera.at("principal_point").exactly("2 numbers (cx, cy in pixels)")?;
    if !(fx > 0.0 && fy > 0.0) {
        return Err(camera.at("focal_length").wrong(part::FOCAL));
    }
    let name = camera.any(&["distortion_type", "distortion_model"]);
    let lens = lens::in_field(&name)?.unwrap_or(Lens::Pinhole);
    let model = lens::of(Pinhole { fx, fy, cx, cy }, lens, &camera.at("distortion_coefficients"))?;
    let size = camera.at("image_dimension").if_there(part::size)?;
    let pose = camera.at("T_BS").if_there(|pose| part::rigid(pose, part::POSE))?;
    Ok(FileCamera { model, size, body_from_cam: pose.unwrap_or_default() })
}
