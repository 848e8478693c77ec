//! A pose from the keyframes around the last one.

use std::sync::Arc;

use geometry::SE3;
use map::RelativePose;

use super::*;
use crate::scene::{Scene, Shot, add_under, at, chain, gap, line, params, shot};

fn last(map: &Map, frame: &Arc<Frame>, keyframe: u32) -> LastFrame {
    LastFrame::new(frame.clone(), RelativePose::new(map, KeyframeId(keyframe), SE3::identity()), &[])
}

/// The answer for a frame of these shots, 0.8 m to the side and turned.
fn tracked(n_landmarks: usize, shots: &[Shot]) -> (SE3, Result<RefinedPose, Lost>) {
    let scene = Scene::wall(n_landmarks);
    let map = scene.map(&[SE3::identity()]);
    let turned = geometry::SO3::exp(&geometry::Vec3::new(0.02, -0.05, 0.1));
    let pose = SE3::new(turned, geometry::Vec3::new(-0.8, 0.1, 0.3));
    let frame = scene.frame(1, &pose, shots);
    (pose, track_reference_keyframe(&frame, &map, &last(&map, &frame, 0), &params()))
}

fn all(n: usize) -> Vec<Shot> {
    (0..n).map(shot).collect()
}

#[test]
fn the_pose_is_found_without_a_prediction() {
    let (truth, found) = tracked(60, &all(60));
    let found = found.unwrap();
    assert!(gap(&found.cam_from_world, &truth) < 1e-3);
    assert_eq!(found.inliers.len(), 60);
}

#[test]
fn wrong_matches_do_not_matter() {
    // A third of the features is somewhere else.
    let mut shots = all(60);
    shots[..20].iter_mut().enumerate().for_each(|(i, s)| s.shift_px = [60.0 - 7.0 * i as f64, 40.0]);
    let (truth, found) = tracked(60, &shots);
    let found = found.unwrap();
    assert!(gap(&found.cam_from_world, &truth) < 2e-3);
    assert_eq!(found.inliers.iter().map(|m| m.0).collect::<Vec<_>>(), (20..60).collect::<Vec<_>>());
}

#[test]
fn fifteen_matches_are_needed() {
    assert!(tracked(15, &all(15)).1.is_ok());
    let lost = tracked(14, &all(14)).1.unwrap_err();
    assert_eq!(lost, Lost::TooFewMatches { found: 14, needed: 15 });
}

#[test]
fn ten_inliers_are_needed() {
    let spoilt = |n: usize| {
        let mut shots = all(24);
        shots[..n].iter_mut().enumerate().for_each(|(i, s)| {
            let angle = i as f64;
            s.shift_px = [150.0 * angle.sin(), 120.0 * angle.cos()];
        });
        tracked(24, &shots).1
    };
    assert_eq!(spoilt(14).unwrap().inliers.len(), 10);
    let lost = spoilt(16).unwrap_err();
    assert!(matches!(lost, Lost::TooFewPredictedInliers { needed: 10, .. }), "{lost:?}");
}

#[test]
fn the_reference_its_best_neighbors_and_the_newest_are_tried() {
    // Neighbors in the chain are covisible; keyframe 6 hangs under the first and shares nothing.
    let mut map = chain(&line(6, 1.0), 8);
    let pose = at(9.0, 0.0, 0.0);
    let under = map::Parent::Under(KeyframeId(0));
    add_under(&mut map, Scene::wall(4).whole(6, &pose), &pose, &[], &[], under);
    let tried = |reference| candidates(&map, KeyframeId(reference)).iter().map(|id| id.0).collect::<Vec<_>>();
    assert_eq!(tried(2), vec![2, 1, 3, 6]);
    assert_eq!(tried(6), vec![6]);
    assert_eq!(tried(77), vec![6], "a reference that is gone leaves the newest");
}
