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
    let size = field.at("resolution").if_there(part::size)?;
    Ok(FileCamera { model, size, body_from_cam: SE3::identity() })
}

/// Both cameras in the body, and the fields that tell; without an IMU the body is the left camera.
fn places(left: &Field<'_>, right: &Field<'_>) -> Result<(Option<&'static str>, [SE3; 2]), DatasetError> {
    let left_place = place(left)?;
    let left_in_body = left_place.map_or(SE3::identity(), |(_, place)| place);
    let chained = right.at("T_cn_cnm1").if_there(|field| part::rigid(field, part::POSE))?;
    if let Some(right_from_left) = chained {
        let right_in_body = left_in_body * right_from_left.inverse();
        return Ok((Some("T_cn_cnm1 (right from left)"), [left_in_body, right_in_body]));
    }
    match (right.is_there(), left_place, place(right)?) {
        (true, Some((spelling, left)), Some((_, right))) => Ok((Some(spelling), [left, right])),
        (true, ..) => Err(right.at("T_cn_cnm1").wrong(part::POSE)),
        (false, ..) => Ok((None, [left_in_body; 2])),
    }
}

/// A camera in the IMU's frame, with the field that tells.
fn place(camera: &Field<'_>) -> Result<Option<(&'static str, SE3)>, DatasetError> {
    let rigid = |field: &Field<'_>| part::rigid(field, part::POSE);
    if let Some(place) = camera.at("T_imu_cam").if_there(rigid)? {
        return Ok(Some(("T_imu_cam (IMU from camera)", place)));
    }
    let inverse = camera.at("T_cam_imu").if_there(rigid)?;
    Ok(inverse.map(|inverse| ("T_cam_imu (camera from IMU)", inverse.inverse())))
}
