//! BoofCV's `stereo_params.xml`: two pinholes with radial (and tangential) distortion, and the way from right to left.

use geometry::{CameraModel, Distortion, SE3, Vec3};

use super::{CameraFile, DatasetError, FileCamera, part};
use crate::document::Field;
use crate::file::counted;

/// The outermost element of the file.
const ROOT: &str = "boofcv.struct.calib.StereoParameters";

pub(super) fn is(root: &Field<'_>) -> bool {
    root.at(ROOT).is_there()
}

/// Reads a stereo calibration of BoofCV.
pub(super) fn read(root: &Field<'_>) -> Result<CameraFile, DatasetError> {
    let root = root.inner(ROOT);
    let left = camera(&root.at("left"))?;
    let mut right = camera(&root.at("right"))?;
    right.body_from_cam = motion(&root.at("rightToLeft"))?;
    Ok(CameraFile {
        right_fields: ("right", "rightToLeft"),
        ..CameraFile::new(root.path, "BoofCV", vec![left, right])
    })
}

fn camera(element: &Field<'_>) -> Result<FileCamera, DatasetError> {
    let [fx, fy, cx, cy] = ["fx", "fy", "cx", "cy"].map(|name| element.at(name));
    let camera = part::pinhole_of_fields([&fx, &fy, &cx, &cy])?;
    let [skew, p1, p2] = part::or_zero(["skew", "t1", "t2"].map(|name| element.at(name)))?;
    if skew != 0.0 {
        return Err(element.at("skew").wrong("0"));
    }
    let radial = element.at("radial");
    let k = radial.if_there(|field| field.numbers("radial coefficients"))?.unwrap_or_default();
    if k.len() > 3 {
        return Err(radial.error(counted(k.len(), "radial coefficient"), "at most 3"));
    }
    let k = |i: usize| k.get(i).copied().unwrap_or(0.0);
    let distortion = Distortion { k1: k(0), k2: k(1), p1, p2, k3: k(2) };
    let size = part::size_of_fields(&element.at("width"), &element.at("height"))?;
    let model = CameraModel::Pinhole { camera, distortion };
    Ok(FileCamera { model, size, body_from_cam: SE3::identity() })
}

/// A rotation, row by row, and a translation.
fn motion(element: &Field<'_>) -> Result<SE3, DatasetError> {
    let rotation = part::rotation(&element.at("r"))?;
    let t = element.at("t");
    let [x, y, z] = ["x", "y", "z"].map(|name| t.at(name).number(part::NUMBER));
    Ok(SE3::new(rotation, Vec3::new(x?, y?, z?)))
}
