//! PLY, nerfstudio and trajectories.

use dsslam_export::{PlyFrame, Scene, Tint, nerfstudio_json, ply, trajectory};
use geometry::{Mat4, Vec3, Vec4};
use serde_json::Value;

use super::world::*;

/// Position and color of each vertex of a file with this crate's properties.
fn read_ply(bytes: &[u8]) -> Vec<(Vec3, [u8; 3], u16)> {
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let header = std::str::from_utf8(&bytes[..at]).unwrap();
    let n: usize = header.lines().find_map(|l| l.strip_prefix("element vertex ")?.parse().ok()).unwrap();
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"), "{header}");
    assert_eq!(bytes.len() - at, n * 21);
    let vertex = |v: &[u8]| {
        let real = |i: usize| f64::from(f32::from_le_bytes(v[4 * i..4 * i + 4].try_into().unwrap()));
        (Vec3::new(real(0), real(1), real(2)), [v[12], v[13], v[14]], u16::from_le_bytes([v[15], v[16]]))
    };
    bytes[at..].chunks_exact(21).map(vertex).collect()
}

#[test]
fn ply_has_the_points_with_their_colors() {
    let scene = Scene::of(&street(), 0).unwrap();
    let colors = Tint::Observations.colors(&scene);
    let vertices = read_ply(&ply(&scene, &colors, PlyFrame::Map));
    assert_eq!(vertices.len(), scene.points.len());
    for ((position, color, observations), (point, expected)) in
        vertices.iter().zip(scene.points.iter().zip(&colors))
    {
        assert!((position - point.position).norm() < 1e-5);
        assert_eq!((color, usize::from(*observations)), (expected, point.track.len()));
    }
    let up = read_ply(&ply(&scene, &colors, PlyFrame::ZUp));
    for ((up, ..), (position, ..)) in up.iter().zip(&vertices) {
        assert_eq!(*up, Vec3::new(position.x, position.z, -position.y));
    }
}

fn matrix(value: &Value) -> Mat4 {
    let rows: Vec<f64> = value
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|row| row.as_array().unwrap())
        .map(|x| x.as_f64().unwrap())
        .collect();
    let last = [0.0, 0.0, 0.0, 1.0];
    Mat4::from_row_slice(&[&rows[..], &last[..16 - rows.len()]].concat())
}

#[test]
fn nerfstudio_cameras_see_the_points_where_ours_do() {
    let scene = Scene::of(&street(), 0).unwrap();
    let text = nerfstudio_json(&scene, "images", "sparse_pc.ply");
    let root: Value = serde_json::from_str(&text).unwrap();
    let number = |key: &str| root[key].as_f64().unwrap();
    assert_eq!((number("w"), number("h"), number("cx")), (80.0, 60.0, CAMERA.cx + 0.5));
    assert_eq!(root["ply_file_path"], "sparse_pc.ply");
    assert_eq!(root["frames"][1]["file_path"], "images/000004.png");
    let points = read_ply(&ply(&scene, &Tint::Age.colors(&scene), PlyFrame::ZUp));
    let applied = matrix(&root["applied_transform"]);
    for (v, frame) in root["frames"].as_array().unwrap().iter().enumerate() {
        let camera_from_world = matrix(&frame["transform_matrix"]).try_inverse().unwrap();
        for ((position, ..), point) in points.iter().zip(&scene.points) {
            let world = Vec4::new(position.x, position.y, position.z, 1.0);
            assert!((applied * point.position.push(1.0) - world).norm() < 1e-5);
            let seen = camera_from_world * world;
            assert!(seen.z < 0.0, "looks along -z");
            let x = number("cx") + number("fl_x") * seen.x / -seen.z;
            let y = number("cy") - number("fl_y") * seen.y / -seen.z;
            let ours = scene.project(v, &point.position).unwrap();
            assert!((ours.x + 0.5 - x).abs() < 1e-3 && (ours.y + 0.5 - y).abs() < 1e-3);
        }
    }
}

#[test]
fn two_cameras_stand_at_their_frames() {
    let mut map = street();
    let mut other = (*rig(geometry::Distortion::default())).clone();
    other.width = 90;
    insert(&mut map, &other.into(), 20, map::Parent::Closest, Vec::new());
    let text = nerfstudio_json(&Scene::of(&map, 0).unwrap(), "images", "points.ply");
    let root: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&root["w"], &root["frames"][0]["w"], &root["frames"][3]["w"]),
        (&Value::Null, &80.into(), &90.into())
    );
}

#[test]
fn the_trajectory_has_a_pose_per_keyframe_by_time() {
    let mut map = street();
    insert(&mut map, &rig(geometry::Distortion::default()), 2, map::Parent::Closest, Vec::new());
    insert(&mut map, &rig(geometry::Distortion::default()), 8, map::Parent::Closest, Vec::new());
    let poses = trajectory(&Scene::of(&map, 0).unwrap()).poses;
    let times: Vec<f64> = poses.iter().map(|pose| pose.timestamp_s).collect();
    assert_eq!(times, [0.0, 0.2, 0.4, 0.8], "frame 8 once");
    let keyframes = [0, 3, 1, 2];
    for (pose, keyframe) in poses.iter().zip(keyframes) {
        assert!((cam_from_world(keyframe) * pose.world_from_cam).log().norm() < 1e-12);
    }
}
