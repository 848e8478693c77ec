//! Features are placed where their points look the same; how views are compared.

use features::{Align, ExtractorConfig, FrameBuilder, StereoConfig};
use geometry::{GrayImage, SO3};

use super::*;
use crate::scene::{Scene, add, at, rig};

#[test]
fn a_step_seen_from_half_the_distance_is_twice_as_long() {
    let scene = Scene::wall(4);
    let (far, near) = (at(0.0, 0.0, 0.0), at(0.0, 0.0, 2.0));
    let (a, b) = (scene.whole(0, &far), scene.whole(1, &near));
    let position = Vec3::new(0.0, 0.0, 4.0);
    let zoom = |frame: &Frame| f64::from(frame.scales.scales[usize::from(frame.keypoints[0].octave)]);
    let twice = 2.0 * zoom(&a) / zoom(&b);
    let [[xx, xy], [yx, yy]] = warp((&a, 0, &far), (&b, 0, &near), &position).unwrap();
    assert!((xx - twice).abs() < 1e-9 && (yy - twice).abs() < 1e-9 && xy.abs() < 1e-9 && yx.abs() < 1e-9);
    let rolled = SE3::new(SO3::exp(&Vec3::new(0.0, 0.0, 0.3)), Vec3::zeros());
    let [[xx, xy], [yx, yy]] = warp((&a, 0, &far), (&a, 0, &rolled), &position).unwrap();
    let (sin, cos) = 0.3f64.sin_cos();
    assert!((xx - cos).abs() < 1e-9 && (yy - cos).abs() < 1e-9);
    assert!((yx - sin).abs() < 1e-9 && (xy + sin).abs() < 1e-9);
    assert_eq!(warp((&a, 0, &far), (&b, 0, &near), &Vec3::new(0.0, 0.0, -1.0)), None);
}

/// Depth of a wall of smooth blobs that all face the camera, meters.
const WALL_M: f64 = 5.0;

/// The wall as a camera sees it.
fn view(cam_from_world: &SE3) -> GrayImage {
    let camera = rig().stereo.camera;
    let center = cam_from_world.center();
    GrayImage::from_fn(640, 480, |x, y| {
        let ray = camera.unproject(&Vec2::new(x as f64, y as f64));
        let along = (WALL_M - center.z) / ray.z;
        let (u, v) = (4.0 * (center.x + along * ray.x), 4.0 * (center.y + along * ray.y));
        // Squares of random brightness whose edges are as soft as those of a photograph.
        let value = |i: f64, j: f64| {
            let mixed = (i * 127.1 + j * 311.7).sin() * 43758.5453;
            mixed - mixed.floor()
        };
        let step = |t: f64| (1.0 / (1.0 + (-30.0 * (t - 0.5)).exp())).clamp(0.0, 1.0);
        let (i, j) = ((u - 0.5).floor(), (v - 0.5).floor());
        let (s, t) = (step(u - 0.5 - i), step(v - 0.5 - j));
        let upper = value(i, j) * (1.0 - s) + value(i + 1.0, j) * s;
        let lower = value(i, j + 1.0) * (1.0 - s) + value(i + 1.0, j + 1.0) * s;
        (30.0 + 200.0 * (upper * (1.0 - t) + lower * t)) as u8
    })
}

#[test]
fn features_come_to_lie_where_the_first_view_had_them() {
    let config = ExtractorConfig { keep: 500, align: Align::Always, ..ExtractorConfig::default() };
    let mut builder = FrameBuilder::new(rig().into(), config, StereoConfig::default(), Default::default());
    let (first, second) = (at(0.0, 0.0, 0.0), at(0.137, -0.052, 0.3));
    let [a, b] = [(0, first), (1, second)].map(|(i, pose)| {
        let (frame, _) = builder.mono(i, f64::from(i), &view(&pose)).unwrap();
        std::sync::Arc::new(frame)
    });
    let on_wall = |i: usize| rig().stereo.camera.unproject(&a.pixel(i)) * WALL_M;
    let mut map = Map::new();
    let new: Vec<(u32, Vec3)> = (0..a.len()).map(|i| (i as u32, on_wall(i))).collect();
    add(&mut map, a.clone(), &first, &[], &new);
    // Each point with the nearest feature of its octave.
    let expected =
        |point: PointId| rig().stereo.camera.project(&(second * map.point(point).unwrap().position));
    let pairs = (0..a.len()).filter_map(|i| {
        let (id, octave) = (PointId(i as u32), a.keypoints[i].octave);
        let place = expected(id);
        let radius_px = 1.2 * f64::from(a.scales.scales[usize::from(octave)]);
        let is_near =
            |&j: &usize| b.keypoints[j].octave == octave && (b.pixel(j) - place).abs().max() <= radius_px;
        (0..b.len()).find(is_near).map(|feature| (feature as u32, id))
    });
    let matches: Vec<(u32, PointId)> = pairs.collect();
    let shifts = alignments(&b, &map, &second, &matches);
    assert!(shifts.len() > 100 && shifts.len() * 2 > matches.len(), "{} of {}", shifts.len(), matches.len());
    let error = |frame: &Frame| {
        let of = |&(feature, _, _): &(u32, f32, f32)| {
            let (_, point) = matches.iter().find(|m| m.0 == feature).unwrap();
            let scale = f64::from(frame.scales.scales[usize::from(frame.keypoints[feature as usize].octave)]);
            (frame.pixel(feature as usize) - expected(*point)).norm() / scale
        };
        let mut errors: Vec<f64> = shifts.iter().map(of).collect();
        geometry::median(&mut errors).unwrap()
    };
    let (before, after) = (error(&b), error(&b.moved(&shifts)));
    assert!(after < 0.5 * before && after < 0.15, "{before} -> {after} pixels of the level");
    assert!(alignments(&a, &map, &second, &[]).is_empty());
    let bare = Frame::new(
        1,
        1.0,
        rig().into(),
        b.scales.clone(),
        features::Features { keypoints: b.keypoints.clone(), descriptors: b.descriptors.clone() },
        b.right_u.clone(),
    );
    assert!(
        alignments(&bare, &map, &second, &matches).is_empty(),
        "without surroundings there is nothing to compare"
    );
}
