//! Kalibr's `camchain.yaml`: `cam0`, `cam1`, ... with intrinsics, lens and the way from the camera before or from the IMU.

use geometry::SE3;

use super::{CameraFile, DatasetError, FileCamera, lens, part};
use crate::document::Field;
use crate::file::shown;

pub(super) fn is(root: &Field<'_>) -> bool {
    root.at("cam0").at("intrinsics").is_there()
}

/// Reads the first two cameras. The way between them is `T_cn_cnm1` of the second one; else it comes from the places of both by
/// the IMU, `T_cam_imu` (x_cam = T x_imu) or, as OpenVINS writes it, `T_imu_cam` (the inverse).
pub(super) fn read(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    let fields = [root.at("cam0"), root.at("cam1")];
    let mut cameras = vec![camera(&fields[0])?];
    let mut notes = Vec::new();
    let [left, right] = &fields;
    if right.is_there() {
        cameras.push(camera(right)?);
    }
    let (spelling, places) = places(left, right)?;
    for (camera, place) in cameras.iter_mut().zip(places) {
        camera.body_from_cam = place;
    }
    notes.extend(
        spelling.map(|spelling| format!("{}: the cameras' places are read from {spelling}", left_path(root))),
    );
    if root.at("cam2").is_there() {
        notes.push(format!("{}: cam0 and cam1 are used, further cameras are not", left_path(root)));
    }
    Ok(CameraFile {
        notes,
        right_fields: (
            "cam1.resolution",
            if right.at("T_cn_cnm1").is_there() { "cam1.T_cn_cnm1" } else { "cam1.T_cam_imu" },
        ),
        ..CameraFile::new(root.path, "Kalibr camchain", cameras)
    })
}

fn left_path(root: &Field<'_>) -> String {
    root.path.display().to_string()
}

fn camera(field: &Field<'_>) -> Result<FileCamera, DatasetError> {
    const MODEL: &str = "pinhole (omni, ds and eucm are not read; calibrate wide lenses with pinhole-equi)";
    let model = field.at("camera_model");
    model.need(MODEL)?;
    let word = model.text(MODEL)?;
    if word != "pinhole" {
        return Err(model.error(shown(word), MODEL));
    }
    let pinhole = part::pinhole(&field.at("intrinsics"), "4 numbers (fu, fv, pu, pv in pixels)")?;
    let model = lens::model(pinhole, &field.at("distortion_model"), &field.at("distortion_coeffs"))?;
    let size = field.at("resolution").there().map(|field| part::size(&field)).transpose()?;
    Ok(FileCamera { model, size, body_from_cam: SE3::identity() })
}

/// Both cameras in the body, and the fields that tell; without an IMU the body is the left camera.
fn places(left: &Field<'_>, right: &Field<'_>) -> Result<(Option<&'static str>, [SE3; 2]), DatasetError> {
    let left_in_body = match place(left)? {
        Some((_, place)) => place,
        None => SE3::identity(),
    };
    let chained = right.at("T_cn_cnm1");
    if chained.is_there() {
        let right_from_left = part::rigid(&chained, part::POSE)?;
        return Ok((
            Some("T_cn_cnm1 (right from left)"),
            [left_in_body, left_in_body * right_from_left.inverse()],
        ));
    }
    match (right.is_there(), place(left)?, place(right)?) {
        (true, Some((spelling, left)), Some((_, right))) => Ok((Some(spelling), [left, right])),
        (true, ..) => Err(right.at("T_cn_cnm1").wrong(part::POSE)),
        (false, ..) => Ok((None, [left_in_body; 2])),
    }
}

/// A camera in the IMU's frame, with the field that tells.
fn place(camera: &Field<'_>) -> Result<Option<(&'static str, SE3)>, DatasetError> {
    let inverse = camera.at("T_imu_cam");
    if inverse.is_there() {
        return Ok(Some(("T_imu_cam (IMU from camera)", part::rigid(&inverse, part::POSE)?)));
    }
    let field = camera.at("T_cam_imu");
    if !field.is_there() {
        return Ok(None);
    }
    Ok(Some(("T_cam_imu (camera from IMU)", part::rigid(&field, part::POSE)?.inverse())))
}
