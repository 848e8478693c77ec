//! Cameras in JSON: nerfstudio's and instant-ngp's `transforms.json`, Replica's `cam_params.json`, intrinsics as RealSense tools write them.

use geometry::SE3;

use super::lens::{self, Lens};
use super::{CameraFile, DatasetError, FileCamera, colmap, part};
use crate::document::Field;
use crate::file::shown;

const MODELS: &str = "OPENCV, OPENCV_FISHEYE, PINHOLE, SIMPLE_PINHOLE";

pub(super) fn is(root: &Field<'_>) -> bool {
    root.at("fl_x").is_there()
        || root.at("frames").items().first().is_some_and(|frame| frame.at("fl_x").is_there())
}

/// Reads the camera of the file, or that of its first frame where each has one.
pub(super) fn read(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    let shared = root.at("fl_x").is_there();
    let camera = if shared { root.clone() } else { root.at("frames").items().swap_remove(0) };
    let number = |name: &str| -> Result<f64, DatasetError> {
        let field = camera.at(name);
        field.need(part::NUMBER)?;
        field.number(part::NUMBER)
    };
    let (fx, cx, cy) = (number("fl_x")?, number("cx")?, number("cy")?);
    let fy = camera.at("fl_y").optional(part::NUMBER)?.unwrap_or(fx);
    let k = |name: &str| Ok::<f64, DatasetError>(camera.at(name).optional(part::NUMBER)?.unwrap_or(0.0));
    let name = root.any(&["camera_model"]);
    let word = if name.is_there() { name.text(MODELS)? } else { "OPENCV" };
    let parameters = match word {
        "OPENCV_FISHEYE" => vec![fx, fy, cx, cy, k("k1")?, k("k2")?, k("k3")?, k("k4")?],
        "OPENCV" => {
            vec![fx, fy, cx, cy, k("k1")?, k("k2")?, k("p1")?, k("p2")?, k("k3")?, k("k4")?, 0.0, 0.0]
        }
        "PINHOLE" | "SIMPLE_PINHOLE" => vec![fx, fy, cx, cy],
        _ => return Err(name.error(shown(word), MODELS)),
    };
    let model = match word {
        "OPENCV" => colmap::model("FULL_OPENCV", &parameters),
        "SIMPLE_PINHOLE" => colmap::model("PINHOLE", &parameters),
        _ => colmap::model(word, &parameters),
    };
    let model = model.ok_or_else(|| camera.at("fl_x").wrong(part::FOCAL))?;
    let size = part::size_of_fields(&camera.at("w"), &camera.at("h"))?;
    let notes = vec![format!(
        "{}: half a pixel is taken from the principal point, because this format counts from the corner of a pixel",
        root.path.display()
    )];
    let camera = FileCamera { model, size, body_from_cam: SE3::identity() };
    Ok(CameraFile { notes, ..CameraFile::new(root.path, "nerfstudio transforms.json", vec![camera]) })
}

pub(super) fn is_replica(root: &Field<'_>) -> bool {
    root.at("camera").at("fx").is_there()
}

/// Reads Replica's rendered camera with the scale of its depth.
pub(super) fn read_replica(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    let camera = root.at("camera");
    let file = flat(&camera, ["fx", "fy", "cx", "cy"], ["w", "h"])?;
    Ok(CameraFile {
        depth_units_per_metre: part::depth_units(&camera.at("scale"))?,
        ..CameraFile::new(root.path, "Replica cam_params.json", vec![file])
    })
}

pub(super) fn is_flat(root: &Field<'_>) -> bool {
    root.at("fx").is_there() && (root.at("ppx").is_there() || root.at("cx").is_there())
}

/// Reads intrinsics without further ado.
pub(super) fn read_flat(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    let [cx, cy] = if root.at("ppx").is_there() { ["ppx", "ppy"] } else { ["cx", "cy"] };
    let camera = flat(root, ["fx", "fy", cx, cy], ["width", "height"])?;
    Ok(CameraFile {
        depth_units_per_metre: part::depth_units(&root.any(&[
            "depth_scale",
            "scale",
            "depth_units_per_metre",
        ]))?
        // RealSense states meters per unit.
        .map(|units| if units < 1.0 { 1.0 / units } else { units }),
        ..CameraFile::new(root.path, "intrinsics", vec![camera])
    })
}

fn flat(root: &Field<'_>, pinhole: [&str; 4], size: [&str; 2]) -> Result<FileCamera, DatasetError> {
    let [fx, fy, cx, cy] = pinhole.map(|name| root.at(name));
    let pinhole = part::pinhole_of_fields([&fx, &fy, &cx, &cy])?;
    let coefficients = root.any(&["coeffs", "distortion", "distortion_coefficients"]);
    let name = root.any(&["model", "distortion_model"]);
    // RealSense's rectified images have all coefficients 0 under whatever model.
    let is_zero = coefficients.is_there() && coefficients.numbers("coefficients")?.iter().all(|&k| k == 0.0);
    let lens = if is_zero { Some(Lens::None) } else { lens::in_field(&name)? };
    let model = lens::of(pinhole, lens.unwrap_or(Lens::Pinhole), &coefficients)?;
    let size = part::size_of_fields(&root.at(size[0]), &root.at(size[1]))?;
    Ok(FileCamera { model, size, body_from_cam: SE3::identity() })
}
