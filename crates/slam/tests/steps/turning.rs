//! What counts as a turn on the spot, and how far it is followed.

use super::*;
use crate::CameraParams;
use crate::scene::{Scene, Shot, shot};

fn scene() -> Scene {
    let ring = (0..900).map(|i| {
        let (angle, height) = (f64::from(i) * 0.41, f64::from(i % 13) * 0.25 - 1.5);
        Vec3::new(10.0 * angle.sin(), height, 10.0 * angle.cos())
    });
    Scene::at(ring.collect())
}

/// What a camera at `center` that has turned to the right by `yaw` sees of a ring of points around the origin.
fn frame(index: u32, yaw: f64, center: &Vec3) -> Arc<Frame> {
    let scene = scene();
    let pose = SE3::new(SO3::exp(&Vec3::new(0.0, yaw, 0.0)), *center).inverse();
    let is_seen = |i: &usize| {
        let point = pose * scene.landmarks[*i];
        point.z > 1.0 && (point.x / point.z).abs() < 0.6
    };
    let shots: Vec<Shot> = (0..scene.len()).filter(is_seen).map(|i| Shot { octave: 0, ..shot(i) }).collect();
    scene.frame(index, &pose, &shots)
}

fn begun() -> Turning {
    let anchor = RelativePose::of_keyframe(map::KeyframeId(0));
    Turning::new(&frame(0, 0.0, &Vec3::zeros()), anchor, SO3::identity())
}

#[test]
fn a_whole_turn_comes_back_to_where_it_began() {
    let (mut turning, params) = (begun(), Params::of(CameraParams::mono(10.0)));
    for i in 1..=126 {
        let yaw = f64::from(i) * 0.05;
        turning.follow(&frame(i, yaw, &Vec3::zeros()), &params).unwrap_or_else(|| panic!("frame {i}"));
        let expected = SO3::exp(&Vec3::new(0.0, -yaw, 0.0));
        let error = (turning.now_from_anchor * expected.inverse()).angle();
        assert!(error < 2e-3, "frame {i} is {error} rad off");
    }
    // One for each 0.12 rad, not one for each frame.
    assert!((40..60).contains(&turning.views.len()), "{}", turning.views.len());
}

#[test]
fn a_camera_that_moves_on_is_not_followed() {
    let (mut turning, params) = (begun(), Params::of(CameraParams::mono(10.0)));
    assert!(turning.follow(&frame(1, 0.05, &Vec3::new(0.01, 0.0, 0.0)), &params).is_some());
    assert!(turning.follow(&frame(2, 0.1, &Vec3::new(0.0, 0.0, 4.0)), &params).is_none());
}

#[test]
fn the_position_is_held_and_only_the_rotation_changes() {
    let scene = Scene::wall(60);
    let place = SE3::new(SO3::exp(&Vec3::new(0.1, 0.0, 0.0)), Vec3::new(0.3, 0.2, -0.1));
    let map = scene.map(&[place]);
    let mut turning = begun();
    turning.now_from_anchor = SO3::exp(&Vec3::new(0.0, 1.2, 0.0));
    let pose = turning.pose(&map).cam_from_world(&map).unwrap();
    assert!((pose.center() - place.center()).norm() < 1e-9);
    assert!((pose.rotation * place.rotation.inverse() * turning.now_from_anchor.inverse()).angle() < 1e-9);
}
