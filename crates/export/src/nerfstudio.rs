//! nerfstudio's `transforms.json` (<https://docs.nerf.studio/quickstart/data_conventions.html>).
//!
//! Its cameras look along -z with y up, its world has z up, and its principal points count as COLMAP's do.

use geometry::{Mat4, SE3};
use serde_json::{Map, Value, json};

use crate::colmap::HALF_PX;
use crate::scene::{Camera, Scene, View};

/// `transforms.json` of a scene whose images lie in the folder `images` and whose points in the file `points`, both named as seen from
/// the folder of the JSON file. The points are those of [`crate::ply`] with [`crate::PlyFrame::ZUp`].
pub fn nerfstudio_json(scene: &Scene, images: &str, points: &str) -> String {
    let mut root = Map::new();
    root.insert("camera_model".to_owned(), json!("OPENCV"));
    if let [only] = scene.cameras.as_slice() {
        root.extend(intrinsics(only));
    }
    let frame = |view: &View| {
        let mut frame = Map::new();
        frame.insert("file_path".to_owned(), json!(format!("{images}/{}", view.name)));
        frame.insert("transform_matrix".to_owned(), rows(&world_from_camera(&view.cam_from_world), 4));
        frame.insert("colmap_im_id".to_owned(), json!(view.keyframe + 1));
        if scene.cameras.len() > 1 {
            frame.extend(intrinsics(&scene.cameras[view.camera]));
        }
        Value::Object(frame)
    };
    root.insert("frames".to_owned(), scene.views.iter().map(frame).collect());
    root.insert("applied_transform".to_owned(), rows(&z_up_from_map(), 3));
    root.insert("ply_file_path".to_owned(), json!(points));
    format!("{:#}\n", Value::Object(root))
}

fn intrinsics(camera: &Camera) -> Map<String, Value> {
    let pinhole = &camera.pinhole;
    let values = [
        ("w", json!(camera.width)),
        ("h", json!(camera.height)),
        ("fl_x", json!(pinhole.fx)),
        ("fl_y", json!(pinhole.fy)),
        ("cx", json!(pinhole.cx + HALF_PX)),
        ("cy", json!(pinhole.cy + HALF_PX)),
        ("k1", json!(0.0)),
        ("k2", json!(0.0)),
        ("p1", json!(0.0)),
        ("p2", json!(0.0)),
    ];
    values.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// (x, y, z) to (x, z, -y): our y points down.
fn z_up_from_map() -> Mat4 {
    Mat4::new(1., 0., 0., 0., 0., 0., 1., 0., 0., -1., 0., 0., 0., 0., 0., 1.)
}

/// The pose of the camera with x right, y up, z backwards in the world with z up.
fn world_from_camera(cam_from_world: &SE3) -> Mat4 {
    let flip = Mat4::from_diagonal(&geometry::Vec4::new(1.0, -1.0, -1.0, 1.0));
    z_up_from_map() * cam_from_world.inverse().matrix() * flip
}

fn rows(matrix: &Mat4, n: usize) -> Value {
    (0..n).map(|row| Value::from(matrix.row(row).iter().copied().collect::<Vec<f64>>())).collect()
}
