//! Settings files of ORB-SLAM2 and ORB-SLAM3, of which the camera is read: flat keys such as `Camera.fx` and `Camera1.fx`.

use geometry::{CameraModel, Distortion, KannalaBrandt, SE3};

use super::lens::{self, Lens};
use super::{CameraFile, DatasetError, FileCamera, part};
use crate::document::Field;
use crate::file::shown;

const TYPES: &str = "PinHole, KannalaBrandt8 or Rectified";

pub(super) fn is(root: &Field<'_>) -> bool {
    ["Camera.fx", "Camera1.fx", "LEFT.K"].iter().any(|key| root.at(key).is_there())
}

/// Reads the cameras: of raw images those of `LEFT.*`, `RIGHT.*` or `Camera1.*`, `Camera2.*`, of rectified ones `Camera.*`.
pub(super) fn read(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    let size = part::size_of_fields(&root.at("Camera.width"), &root.at("Camera.height"))?;
    let depth_units_per_metre = part::depth_units(&root.any(&["RGBD.DepthMapFactor", "DepthMapFactor"]))?
        .filter(|&units| units > 1.0);
    let (format, cameras, baseline_m) = if root.at("LEFT.K").is_there() {
        ("ORB-SLAM2 settings", raw_pair(root)?, None)
    } else if root.at("Camera1.fx").is_there() {
        let (cameras, baseline_m) = third(root, size)?;
        ("ORB-SLAM3 settings", cameras, baseline_m)
    } else {
        let camera = camera(root, "Camera", size)?;
        let fx = camera.model.pinhole().fx;
        let bf = root.any(&["Camera.bf", "bf"]);
        let bf = bf.if_there(|field| field.positive("focal length times baseline, px m, above 0"))?;
        ("ORB-SLAM2 settings", vec![camera], bf.map(|bf| bf / fx))
    };
    Ok(CameraFile {
        frame_rate_hz: part::rate(&root.at("Camera.fps"))?,
        depth_units_per_metre,
        baseline_m,
        right_fields: ("Camera2", "Stereo.T_c1_c2"),
        ..CameraFile::new(root.path, format, cameras)
    })
}

/// `Camera1` and, where it is there, `Camera2`, or the baseline of rectified images.
fn third(
    root: &Field<'_>,
    size: Option<crate::images::ImageSize>,
) -> Result<(Vec<FileCamera>, Option<f64>), DatasetError> {
    let mut cameras = vec![camera(root, "Camera1", size)?];
    if root.at("Camera2.fx").is_there() {
        let mut right = camera(root, "Camera2", size)?;
        // x_c1 = T x_c2.
        right.body_from_cam = part::rigid(&root.at("Stereo.T_c1_c2"), part::POSE)?;
        cameras.push(right);
        return Ok((cameras, None));
    }
    let baseline = root.at("Stereo.b");
    Ok((cameras, baseline.if_there(|field| field.positive("a baseline in meters, above 0"))?))
}

/// The camera whose fields begin with `name`.
fn camera(
    root: &Field<'_>,
    name: &str,
    size: Option<crate::images::ImageSize>,
) -> Result<FileCamera, DatasetError> {
    let at = |field: &str| root.at(&format!("{name}.{field}"));
    let camera = part::pinhole_of_fields([&at("fx"), &at("fy"), &at("cx"), &at("cy")])?;
    let kind = root.at("Camera.type");
    let lens = if kind.is_there() {
        let word = kind.text(TYPES)?;
        lens::named(word)
            .filter(|lens| *lens != Lens::Radtan)
            .ok_or_else(|| kind.error(shown(word), TYPES))?
    } else {
        Lens::Pinhole
    };
    let model = match lens {
        Lens::Fisheye => {
            let [k1, k2, k3, k4] = part::or_zero(["k1", "k2", "k3", "k4"].map(at))?;
            CameraModel::KannalaBrandt(KannalaBrandt { camera, k1, k2, k3, k4 })
        }
        Lens::None => CameraModel::Pinhole { camera, distortion: Distortion::default() },
        Lens::Pinhole | Lens::Radtan => {
            let [k1, k2, p1, p2, k3] = part::or_zero(["k1", "k2", "p1", "p2", "k3"].map(at))?;
            CameraModel::Pinhole { camera, distortion: Distortion { k1, k2, p1, p2, k3 } }
        }
    };
    Ok(FileCamera { model, size, body_from_cam: SE3::identity() })
}

/// The raw cameras of ORB-SLAM2's EuRoC settings with their rectification.
fn raw_pair(root: &Field<'_>) -> Result<Vec<FileCamera>, DatasetError> {
    let raw = |side: &str| -> Result<FileCamera, DatasetError> {
        let at = |field: &str| root.at(&format!("{side}.{field}"));
        let pinhole = part::pinhole_of_matrix(&at("K"))?;
        let size = part::size_of_fields(&at("width"), &at("height"))?;
        let model = lens::of(pinhole, Lens::Radtan, &at("D"))?;
        Ok(FileCamera { model, size, body_from_cam: SE3::identity() })
    };
    let (left, mut right) = (raw("LEFT")?, raw("RIGHT")?);
    let turn = |side: &str| part::rotation(&root.at(&format!("{side}.R")));
    part::place_right(turn("LEFT")?, &mut right, turn("RIGHT")?, &root.at("RIGHT.P"))?;
    Ok(vec![left, right])
}
