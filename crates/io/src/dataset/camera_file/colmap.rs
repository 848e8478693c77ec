//! COLMAP's `cameras.txt`: a line per camera with id, model, width, height and parameters.

use geometry::{CameraModel, Pinhole, SE3};

use super::{CameraFile, DatasetError, FileCamera, lens};
use crate::file::{FileError, Line, TextFile, counted};
use crate::images::ImageSize;

/// COLMAP's pixel (0.5, 0.5) is the center of the upper left one, ours is (0, 0).
const HALF_PX: f64 = 0.5;

const MODELS: &str = "SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, OPENCV_FISHEYE, \
                      SIMPLE_RADIAL_FISHEYE or RADIAL_FISHEYE";

/// Whether a line is that of a camera.
pub(super) fn is(line: &Line<'_>) -> bool {
    let mut fields = line.text.split_whitespace();
    let (id, model) = (fields.next().unwrap_or(""), fields.next().unwrap_or(""));
    id.parse::<u64>().is_ok()
        && model.len() > 2
        && model.bytes().all(|byte| byte.is_ascii_uppercase() || byte == b'_')
}

/// Reads the first camera.
pub(super) fn read(file: &TextFile) -> Result<CameraFile, DatasetError> {
    let lines: Vec<Line<'_>> = file.data_lines().collect();
    let Some(first) = lines.first() else { return Err(file.empty(super::EXPECTED).into()) };
    let mut notes = vec![format!(
        "{}: half a pixel is taken from the principal point, because COLMAP counts from the corner of a pixel",
        file.path.display()
    )];
    if lines.len() > 1 {
        notes.push(format!(
            "{}: the first of {} is used",
            file.path.display(),
            counted(lines.len(), "camera")
        ));
    }
    Ok(CameraFile { notes, ..CameraFile::new(&file.path, "COLMAP cameras.txt", vec![camera(first)?]) })
}

fn camera(line: &Line<'_>) -> Result<FileCamera, FileError> {
    let fields: Vec<&str> = line.text.split_whitespace().collect();
    let [_, model, width, height, rest @ ..] = &fields[..] else {
        return Err(
            line.error(counted(fields.len(), "field"), "an id, a model, width, height and parameters")
        );
    };
    let side = |text: &str| {
        let side = text.parse().ok().filter(|side| (1..=65535).contains(side));
        side.ok_or_else(|| line.error(crate::file::shown(text), "pixels, from 1 to 65535"))
    };
    let size = ImageSize { width: side(width)?, height: side(height)? };
    let p = rest.iter().map(|field| line.number(field)).collect::<Result<Vec<_>, _>>()?;
    let model = self::model(model, &p).ok_or_else(|| {
        line.error(
            format!("{model} with {}", counted(p.len(), "parameter")),
            format!("{MODELS}, with its parameters"),
        )
    })?;
    Ok(FileCamera { model, size: Some(size), body_from_cam: SE3::identity() })
}

/// The camera of a model's parameters, in COLMAP's order; a focal length must be above 0.
pub(super) fn model(name: &str, parameters: &[f64]) -> Option<CameraModel> {
    let one = |f: f64, cx: f64, cy: f64| Pinhole { fx: f, fy: f, cx: cx - HALF_PX, cy: cy - HALF_PX };
    let two = |fx: f64, fy: f64, cx: f64, cy: f64| Pinhole { fy, ..one(fx, cx, cy) };
    let model = match (name, parameters) {
        ("SIMPLE_PINHOLE", &[f, cx, cy]) => lens::radtan(one(f, cx, cy), &[]),
        ("PINHOLE", &[fx, fy, cx, cy]) => lens::radtan(two(fx, fy, cx, cy), &[]),
        ("SIMPLE_RADIAL", &[f, cx, cy, k]) => lens::radtan(one(f, cx, cy), &[k, 0.0, 0.0, 0.0]),
        ("RADIAL", &[f, cx, cy, k1, k2]) => lens::radtan(one(f, cx, cy), &[k1, k2, 0.0, 0.0]),
        ("OPENCV", &[fx, fy, cx, cy, ref k @ ..]) if k.len() == 4 => lens::radtan(two(fx, fy, cx, cy), k),
        ("FULL_OPENCV", &[fx, fy, cx, cy, ref k @ ..]) if k.len() == 8 => {
            lens::radtan(two(fx, fy, cx, cy), k)
        }
        ("OPENCV_FISHEYE", &[fx, fy, cx, cy, ref k @ ..]) if k.len() == 4 => {
            lens::fisheye(two(fx, fy, cx, cy), k)
        }
        ("SIMPLE_RADIAL_FISHEYE", &[f, cx, cy, k]) => lens::fisheye(one(f, cx, cy), &[k, 0.0, 0.0, 0.0]),
        ("RADIAL_FISHEYE", &[f, cx, cy, k1, k2]) => lens::fisheye(one(f, cx, cy), &[k1, k2, 0.0, 0.0]),
        _ => None,
    }?;
    let pinhole = model.pinhole();
    (pinhole.fx > 0.0 && pinhole.fy > 0.0).then_some(model)
}
