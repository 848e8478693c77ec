//! The binary files, little-endian.

use draw::Color;

use super::{
    ColmapFiles, PINHOLE, camera_id, colored, features, image_id, intrinsics, point_id, pose, track,
};
use crate::scene::Scene;

/// What COLMAP writes for a feature without a point.
const NO_POINT: u64 = u64::MAX;

/// `cameras.bin`, `images.bin` and `points3D.bin` of a scene whose points have these colors.
///
/// # Panics
/// When the number of colors is not that of the points.
pub fn colmap_binary(scene: &Scene, colors: &[Color]) -> ColmapFiles {
    ColmapFiles { cameras: cameras(scene), images: images(scene), points: points(scene, colors) }
}

fn count(n: usize) -> [u8; 8] {
    (n as u64).to_le_bytes()
}

fn reals(bytes: &mut Vec<u8>, values: &[f64]) {
    values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
}

fn cameras(scene: &Scene) -> Vec<u8> {
    let mut bytes = count(scene.cameras.len()).to_vec();
    for (index, camera) in scene.cameras.iter().enumerate() {
        bytes.extend(camera_id(index).to_le_bytes());
        bytes.extend(PINHOLE.to_le_bytes());
        bytes.extend(count(camera.width));
        bytes.extend(count(camera.height));
        reals(&mut bytes, &intrinsics(camera));
    }
    bytes
}

fn images(scene: &Scene) -> Vec<u8> {
    let mut bytes = count(scene.views.len()).to_vec();
    for view in &scene.views {
        bytes.extend(image_id(view).to_le_bytes());
        reals(&mut bytes, &pose(view));
        bytes.extend(camera_id(view.camera).to_le_bytes());
        bytes.extend(view.name.as_bytes());
        bytes.push(0);
        let features = features(scene, view);
        bytes.extend(count(features.len()));
        for (pixel, point) in features {
            reals(&mut bytes, &[pixel.x, pixel.y]);
            bytes.extend(point.unwrap_or(NO_POINT).to_le_bytes());
        }
    }
    bytes
}

fn points(scene: &Scene, colors: &[Color]) -> Vec<u8> {
    let mut bytes = count(scene.points.len()).to_vec();
    for (point, color) in colored(scene, colors) {
        bytes.extend(point_id(point).to_le_bytes());
        reals(&mut bytes, &[point.position.x, point.position.y, point.position.z]);
        bytes.extend(color);
        reals(&mut bytes, &[point.error_px]);
        let track = track(scene, point);
        bytes.extend(count(track.len()));
        for (image, feature) in track {
            bytes.extend(image.to_le_bytes());
            bytes.extend(feature.to_le_bytes());
        }
    }
    bytes
}
