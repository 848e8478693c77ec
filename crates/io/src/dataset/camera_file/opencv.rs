//! Matrices as OpenCV's `FileStorage` writes them (YAML, XML, JSON), under the names that its examples and tutorials use.

use geometry::{SE3, Vec3};

use super::lens::{self, Lens};
use super::{CameraFile, DatasetError, FileCamera, part};
use crate::document::Field;

const MATRICES: [&str; 10] = [
    "K",
    "K1",
    "M1",
    "camera_matrix",
    "cameraMatrix",
    "cameraMatrix1",
    "Camera_Matrix",
    "CameraMatrix",
    "KL",
    "mtx",
];
const LENSES: [&str; 10] = [
    "D",
    "D1",
    "distortion_coefficients",
    "distCoeffs",
    "distCoeffs1",
    "Distortion_Coefficients",
    "DistCoeffs",
    "DL",
    "dist",
    "dist_coeffs",
];
const RIGHT_MATRICES: [&str; 4] = ["K2", "M2", "cameraMatrix2", "KR"];
const RIGHT_LENSES: [&str; 4] = ["D2", "distCoeffs2", "DR", "dist2"];

pub(super) fn is(root: &Field<'_>) -> bool {
    root.any(&MATRICES).is_there()
}

/// Reads one camera, or two with `R` and `T` (x_right = R x_left + T).
pub(super) fn read(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    let size = size(root)?;
    let camera = |matrix: &Field<'_>, coefficients: &Field<'_>| -> Result<FileCamera, DatasetError> {
        let pinhole = part::pinhole_of_matrix(matrix)?;
        let lens = lens::in_field(&root.at("distortion_model"))?.unwrap_or(Lens::Pinhole);
        let model = lens::of(pinhole, lens, coefficients)?;
        Ok(FileCamera { model, size, body_from_cam: SE3::identity() })
    };
    let mut cameras = vec![camera(&root.any(&MATRICES), &root.any(&LENSES))?];
    let right = root.any(&RIGHT_MATRICES);
    if right.is_there() {
        let [x, y, z] = root.at("T").exactly("3 numbers (x_right = R x_left + T, meters)")?;
        let right_from_left = SE3::new(part::rotation(&root.at("R"))?, Vec3::new(x, y, z));
        let mut right = camera(&right, &root.any(&RIGHT_LENSES))?;
        right.body_from_cam = right_from_left.inverse();
        cameras.push(right);
    }
    Ok(CameraFile {
        right_fields: ("image_size", "T"),
        ..CameraFile::new(root.path, "OpenCV FileStorage", cameras)
    })
}

fn size(root: &Field<'_>) -> Result<Option<crate::images::ImageSize>, DatasetError> {
    let list = root.any(&["image_size", "imageSize", "image_Size", "size", "resolution"]);
    if list.is_there() {
        return part::size(&list).map(Some);
    }
    let width = root.any(&["image_width", "image_Width", "width", "imageWidth"]);
    part::size_of_fields(&width, &root.any(&["image_height", "image_Height", "height", "imageHeight"]))
}
