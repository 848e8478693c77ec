//! `sensor.yaml` of an EuRoC camera: resolution, intrinsics, lens, pose in the body.

use std::path::Path;

use geometry::CameraModel;
use serde::Deserialize;
use serde_saphyr::Spanned;

use super::super::fields::{Fields, document};
use super::super::{DatasetError, RawCamera};
use crate::file::{TextFile, shown};

const LENSES: &str = "radial-tangential, equidistant or none";

/// The fields of the file that are read; all are needed but the rate.
#[derive(Deserialize)]
struct Document {
    #[serde(rename = "T_BS")]
    pose: Option<Spanned<Pose>>,
    resolution: Option<Spanned<Vec<u64>>>,
    camera_model: Option<Spanned<String>>,
    intrinsics: Option<Spanned<Vec<f64>>>,
    distortion_model: Option<Spanned<String>>,
    distortion_coefficients: Option<Spanned<Vec<f64>>>,
}

/// A 4 by 4 matrix, row by row.
#[derive(Deserialize)]
struct Pose {
    data: Vec<f64>,
}

/// Reads the camera of a `sensor.yaml`.
///
/// # Errors
/// [`DatasetError`] naming the field, what was found and what was expected.
pub(in super::super) fn read(path: &Path) -> Result<RawCamera, DatasetError> {
    camera(&TextFile::read(path, "the calibration of a camera (EuRoC)")?)
}

/// The camera that a file describes.
pub(super) fn camera(file: &TextFile) -> Result<RawCamera, DatasetError> {
    const POSE: &str = "16 numbers (a rigid motion as a 4x4 matrix, row by row)";
    let document: Document = document(file)?;
    let fields = Fields::of(&file.path);
    let camera_model = fields.need("camera_model", document.camera_model, "pinhole")?;
    if camera_model.value != "pinhole" {
        return Err(fields.wrong("camera_model", &camera_model, shown(&camera_model.value), "pinhole"));
    }
    let pinhole =
        fields.pinhole("intrinsics", document.intrinsics, "4 numbers (fu, fv, cu, cv in pixels)")?;
    let lens = fields.need("distortion_model", document.distortion_model, LENSES)?;
    let (field, coefficients) = ("distortion_coefficients", document.distortion_coefficients);
    let model = match lens.value.as_str() {
        "radial-tangential" | "radtan" => fields.radial_tangential(field, pinhole, coefficients)?,
        "equidistant" => fields.fisheye(field, pinhole, coefficients)?,
        "none" => CameraModel::Pinhole { camera: pinhole, distortion: Default::default() },
        other => return Err(fields.wrong("distortion_model", &lens, shown(other), LENSES)),
    };
    let size = fields.size("resolution", document.resolution)?;
    let pose = fields.need("T_BS", document.pose, POSE)?;
    let body_from_cam = fields.rigid("T_BS", &pose, &pose.value.data, POSE)?;
    Ok(RawCamera { model, size, body_from_cam })
}
