//! ROS `camera_info` as `camera_calibration` and drivers write it, one file per camera.

use std::path::PathBuf;

use geometry::SE3;

use super::lens::{self, Lens};
use super::{CameraFile, DatasetError, FileCamera, part};
use crate::document::{Field, parse};
use crate::file::TextFile;

pub(super) fn is(root: &Field<'_>) -> bool {
    // As a message (`ros2 topic echo`) its fields have other names.
    let is_message = ["k", "d"].iter().all(|key| root.at(key).is_there()) || root.at("K").is_there();
    let is_named = root.at("camera_matrix").is_there() && root.at("image_width").is_there();
    is_named || is_message && root.at("distortion_model").is_there()
}

/// Reads a camera; where the file is called `left...` and `right...` lies beside it, a pair.
pub(super) fn read(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    let camera = camera(root)?;
    let file = |cameras| CameraFile {
        right_fields: ("image_width", "projection_matrix"),
        ..CameraFile::new(root.path, "ROS camera_info", cameras)
    };
    let Some(beside) = right_beside(root) else { return Ok(file(vec![camera])) };
    let text = TextFile::read(&beside, super::EXPECTED)?;
    let document = parse(&text).map_err(|error| DatasetError::syntax(&beside, error))?;
    let other = Field::root(&beside, &document);
    let mut right = self::camera(&other)?;
    let turn = |camera: &Field<'_>| part::rotation(&camera.any(&["rectification_matrix", "R", "r"]));
    let projection = other.any(&["projection_matrix", "P", "p"]);
    part::place_right(turn(root)?, &mut right, turn(&other)?, &projection)?;
    let notes = vec![format!("{}: the right camera is read from {}", root.path.display(), beside.display())];
    Ok(CameraFile { notes, ..file(vec![camera, right]) })
}

fn camera(root: &Field<'_>) -> Result<FileCamera, DatasetError> {
    let pinhole = part::pinhole_of_matrix(&root.any(&["camera_matrix", "K", "k"]))?;
    let coefficients = root.any(&["distortion_coefficients", "D", "d"]);
    // OpenCV's example program writes no model.
    let lens = lens::in_field(&root.at("distortion_model"))?.unwrap_or(Lens::Radtan);
    let model = lens::of(pinhole, lens, &coefficients)?;
    let size =
        part::size_of_fields(&root.any(&["image_width", "width"]), &root.any(&["image_height", "height"]))?;
    Ok(FileCamera { model, size, body_from_cam: SE3::identity() })
}

/// The file of the right camera beside that of the left one.
fn right_beside(root: &Field<'_>) -> Option<PathBuf> {
    let name = root.path.file_name()?.to_str()?;
    let other = name.contains("left").then(|| name.replace("left", "right"))?;
    Some(root.path.with_file_name(other)).filter(|path| path.is_file())
}
