//! The text files; numbers have all their digits, so that text and binary are the same model.

use std::fmt::Write as _;

use draw::Color;

use super::{ColmapFiles, camera_id, colored, features, image_id, intrinsics, point_id, pose, track};
use crate::scene::Scene;

/// `cameras.txt`, `images.txt` and `points3D.txt` of a scene whose points have these colors.
///
/// # Panics
/// When the number of colors is not that of the points.
pub fn colmap_text(scene: &Scene, colors: &[Color]) -> ColmapFiles {
    let [cameras, images, points] =
        [cameras(scene), images(scene), points(scene, colors)].map(String::into_bytes);
    ColmapFiles { cameras, images, points }
}

// Writing to a string cannot fail.

fn cameras(scene: &Scene) -> String {
    let mut text = String::from("# CAMERA_ID, MODEL, WIDTH, HEIGHT, fx, fy, cx, cy\n");
    for (index, camera) in scene.cameras.iter().enumerate() {
        let (id, [fx, fy, cx, cy]) = (camera_id(index), intrinsics(camera));
        let _ = writeln!(text, "{id} PINHOLE {} {} {fx} {fy} {cx} {cy}", camera.width, camera.height);
    }
    text
}

fn images(scene: &Scene) -> String {
    let mut text = String::from(
        "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n",
    );
    for view in &scene.views {
        let _ = write!(text, "{}", image_id(view));
        pose(view).iter().for_each(|value| {
            let _ = write!(text, " {value}");
        });
        let _ = writeln!(text, " {} {}", camera_id(view.camera), view.name);
        for (i, (pixel, point)) in features(scene, view).enumerate() {
            let separator = if i == 0 { "" } else { " " };
            let _ = write!(text, "{separator}{} {} ", pixel.x, pixel.y);
            let _ = match point {
                Some(id) => write!(text, "{id}"),
                None => write!(text, "-1"),
            };
        }
        text.push('\n');
    }
    text
}

fn points(scene: &Scene, colors: &[Color]) -> String {
    let mut text =
        String::from("# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n");
    for (point, [r, g, b]) in colored(scene, colors) {
        let (id, p) = (point_id(point), &point.position);
        let _ = write!(text, "{id} {} {} {} {r} {g} {b} {}", p.x, p.y, p.z, point.error_px);
        for (image, feature) in track(scene, point) {
            let _ = write!(text, " {image} {feature}");
        }
        text.push('\n');
    }
    text
}
