//! Rotations from directions.

use std::sync::Arc;

use super::*;
use crate::CameraParams;
use crate::scene::{Scene, Shot, shot};
use geometry::SE3;

fn frame(index: u32, pose: &SE3, change: impl Fn(&mut Shot)) -> Arc<Frame> {
    let mut shots: Vec<Shot> = (0..160).map(|i| Shot { stereo: false, octave: 0, ..shot(i) }).collect();
    shots.iter_mut().for_each(change);
    Scene::wall(160).frame(index, pose, &shots)
}

/// What a frame at a pose says of the first one, with a prediction that is 0.02 rad (10 px) off.
fn seen(pose: &SE3, radius_px: f32, change: impl Fn(&mut Shot)) -> SeenRotation {
    let predicted = SO3::exp(&Vec3::new(0.0, 0.02, 0.0)) * pose.rotation;
    let (then, now) = (frame(0, &SE3::identity(), |_| {}), frame(1, pose, change));
    rotation_between(&then, &now, &predicted, radius_px, &Params::of(CameraParams::mono(10.0))).unwrap()
}

#[test]
fn a_turn_is_found_with_a_third_of_the_features_moving() {
    let turn = SO3::exp(&Vec3::new(0.03, -0.05, 0.02));
    let found = seen(&SE3::new(turn, Vec3::zeros()), 20.0, |s| {
        if s.landmark % 3 == 0 {
            s.shift_px = [7.0, -6.0];
        }
    });
    assert!((found.now_from_then * turn.inverse()).angle() < 1e-4);
    let still = (0..160).filter(|i| i % 3 != 0).count();
    assert!(found.inliers >= still - 15 && found.inliers <= still, "{found:?}");
    assert!(found.matches > found.inliers + 30, "{found:?}");
}

#[test]
fn a_move_is_not_explained_by_a_turn() {
    // A meter to the side: 42 to 62 px, of which a turn explains the mean.
    let found = seen(&SE3::new(SO3::identity(), Vec3::new(1.0, 0.0, 0.0)), 80.0, |_| {});
    assert!(found.matches > 100 && found.inliers * 2 < found.matches, "{found:?}");
}
