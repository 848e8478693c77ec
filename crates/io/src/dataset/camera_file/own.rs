//! DSSLAM's own calibration file: cameras with model, resolution, intrinsics and lens, and the way from left to right.

use geometry::{CameraModel, SE3};
use serde::Deserialize;
use serde_saphyr::Spanned;

use super::super::fields::{Fields, document};
use super::super::{DatasetError, RawCamera};
use super::CameraFile;
use crate::file::{TextFile, counted, shown};

const MODELS: &str = "pinhole-radtan, kannala-brandt or none";
const CAMERAS: &str = "a list of one camera, or of the left and the right one";
const MOTION: &str = "3 rows of 4 numbers (rotation and translation in meters: x_right = R x_left + t)";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    fps: Option<Spanned<f64>>,
    cameras: Option<Spanned<Vec<Camera>>>,
    right_from_left: Option<Spanned<Vec<Vec<f64>>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Camera {
    model: Option<Spanned<String>>,
    resolution: Option<Spanned<Vec<u64>>>,
    intrinsics: Option<Spanned<Vec<f64>>>,
    distortion: Option<Spanned<Vec<f64>>>,
}

/// Reads a calibration in our own format (described in docs/inputs.md).
///
/// # Errors
/// [`DatasetError`] naming the field, what was found and what was expected.
pub(super) fn read(file: &TextFile) -> Result<CameraFile, DatasetError> {
    let document: Document = document(file)?;
    let fields = Fields::of(&file.path);
    let list = fields.need("cameras", document.cameras, CAMERAS)?;
    if !(1..=2).contains(&list.value.len()) {
        return Err(fields.wrong("cameras", &list, counted(list.value.len(), "camera"), CAMERAS));
    }
    let (n_cameras, place) = (list.value.len(), list.referenced);
    let mut cameras = Vec::new();
    for (i, camera) in list.value.into_iter().enumerate() {
        cameras.push(read_camera(&fields, i, camera)?);
    }
    match (cameras.get_mut(1), &document.right_from_left) {
        (Some(right), motion) => {
            let motion = fields.need("right_from_left", motion.as_ref(), MOTION)?;
            right.body_from_cam = read_motion(&fields, motion)?.inverse();
        }
        (None, Some(motion)) => {
            let found =
                format!("{} for a motion between two (line {})", counted(n_cameras, "camera"), place.line());
            return Err(fields.wrong("right_from_left", motion, found, "it only with two cameras"));
        }
        (None, None) => {}
    }
    Ok(CameraFile {
        path: file.path.clone(),
        cameras,
        frame_rate_hz: read_rate(&fields, document.fps)?,
        right_fields: ("cameras[1].resolution", "right_from_left"),
    })
}

fn read_camera(fields: &Fields, i: usize, camera: Camera) -> Result<RawCamera, DatasetError> {
    let name = |field: &str| format!("cameras[{i}].{field}");
    let pinhole =
        fields.pinhole(&name("intrinsics"), camera.intrinsics, "4 numbers (fx, fy, cx, cy in pixels)")?;
    let model = fields.need(&name("model"), camera.model, MODELS)?;
    let (field, coefficients) = (name("distortion"), camera.distortion);
    let model = match (model.value.as_str(), coefficients) {
        ("pinhole-radtan", coefficients) => fields.radial_tangential(&field, pinhole, coefficients)?,
        ("kannala-brandt", coefficients) => fields.fisheye(&field, pinhole, coefficients)?,
        ("none", None) => CameraModel::Pinhole { camera: pinhole, distortion: Default::default() },
        ("none", Some(given)) => {
            let found = counted(given.value.len(), "number");
            return Err(fields.wrong(&field, &given, found, "nothing, since the model is none"));
        }
        (other, _) => return Err(fields.wrong(&name("model"), &model, shown(other), MODELS)),
    };
    let size = fields.size(&name("resolution"), camera.resolution)?;
    Ok(RawCamera { model, size, body_from_cam: SE3::identity() })
}

/// Three rows of four numbers, or four with the last one 0 0 0 1.
fn read_motion(fields: &Fields, motion: &Spanned<Vec<Vec<f64>>>) -> Result<SE3, DatasetError> {
    const FIELD: &str = "right_from_left";
    let rows = &motion.value;
    if !(3..=4).contains(&rows.len()) {
        return Err(fields.wrong(FIELD, motion, counted(rows.len(), "row"), MOTION));
    }
    if let Some(row) = rows.iter().find(|row| row.len() != 4) {
        let found = format!("a row of {}", counted(row.len(), "number"));
        return Err(fields.wrong(FIELD, motion, found, MOTION));
    }
    let mut data = rows.concat();
    if rows.len() == 3 {
        data.extend([0.0, 0.0, 0.0, 1.0]);
    }
    fields.rigid(FIELD, motion, &data, MOTION)
}

fn read_rate(fields: &Fields, fps: Option<Spanned<f64>>) -> Result<Option<f64>, DatasetError> {
    match fps {
        Some(fps) if !(fps.value > 0.0 && fps.value.is_finite()) => {
            Err(fields.wrong("fps", &fps, fps.value.to_string(), "images per second, above 0"))
        }
        fps => Ok(fps.map(|fps| fps.value)),
    }
}
