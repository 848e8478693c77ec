//! Prediction by the motion model: what is looked for, where, at which octaves, in which windows.

use std::sync::Arc;

use map::{KeyframeId, RelativePose};

use super::super::motion_model::MotionModel;
use super::*;
use crate::Params;
use crate::scene::{BASELINE_M, Scene, Shot, at, gap, params, shot};

const N: usize = 60;

/// A map of one keyframe at the origin, which is the last frame; the first `n_matched` features are map points.
fn last_frame(scene: &Scene, shots: &[Shot], n_matched: u32) -> (Map, LastFrame) {
    let map = scene.map(&[SE3::identity()]);
    let frame = scene.frame(0, &SE3::identity(), shots);
    let pose = RelativePose::new(&map, KeyframeId(0), SE3::identity());
    let matches: Vec<(u32, PointId)> = (0..n_matched).map(|i| (i, PointId(i))).collect();
    (map, LastFrame::new(frame, pose, &matches))
}

fn all(n: usize) -> Vec<Shot> {
    (0..n).map(shot).collect()
}

#[test]
fn map_points_come_first_then_the_nearest_features_with_depth() {
    let scene = Scene::at([12.0, 9.0, 11.0, 8.0, 10.0].map(|z| Vec3::new(0.1 * z, 0.0, z)).to_vec());
    let mut shots = all(5);
    shots[3].stereo = false;
    let (map, last) = last_frame(&scene, &shots, 1);
    let sources = last_points(&map, &last, &at(0.0, 0.0, 0.0));
    assert_eq!(sources.iter().map(|s| s.feature).collect::<Vec<_>>(), vec![0, 1, 4, 2]);
    assert_eq!(sources.iter().map(|s| s.id).collect::<Vec<_>>(), vec![Some(PointId(0)), None, None, None]);
    assert!((sources[2].position - scene.landmarks[4]).norm() < 1e-3);
    // The position of a feature's own depth is in the world, not in the camera.
    let moved = last_points(&map, &last, &at(2.0, 0.0, 0.0));
    assert!((moved[2].position - scene.landmarks[4] - Vec3::new(2.0, 0.0, 0.0)).norm() < 1e-3);
}

#[test]
fn no_more_than_six_hundred_are_looked_for() {
    let scene = Scene::wall(700);
    let (map, last) = last_frame(&scene, &all(700), 50);
    let sources = last_points(&map, &last, &SE3::identity());
    assert_eq!((sources.len(), sources.iter().filter(|s| s.id.is_some()).count()), (600, 50));
    let (map, last) = last_frame(&scene, &all(700), 650);
    assert_eq!(last_points(&map, &last, &SE3::identity()).len(), 650, "map points are all looked for");
}

/// Whether features of `octave` are found after a motion by `forward_m` along z; before they were at octave 2.
fn found_at(octave: u8, forward_m: f64, far: f64) -> bool {
    let scene = Scene::wall(N);
    let (map, last) = last_frame(&scene, &all(N), N as u32);
    let pose = at(0.0, 0.0, forward_m);
    let shots: Vec<Shot> = (0..N).map(|i| Shot { octave, ..shot(i) }).collect();
    let sources = last_points(&map, &last, &SE3::identity());
    let found =
        search_last(&scene.frame(1, &pose, &shots), &last, &SE3::identity(), &pose, &sources, 7.0, far);
    assert!(found.is_empty() || found.len() == N, "{}", found.len());
    !found.is_empty()
}

#[test]
fn the_octaves_follow_the_motion() {
    let octaves =
        |forward_m, far| (0..8).filter(|&octave| found_at(octave, forward_m, far)).collect::<Vec<u8>>();
    assert_eq!(octaves(0.0, BASELINE_M), vec![1, 2, 3]);
    assert_eq!(octaves(BASELINE_M - 0.01, BASELINE_M), vec![1, 2, 3]);
    assert_eq!(octaves(BASELINE_M + 0.01, BASELINE_M), vec![2, 3, 4, 5, 6, 7], "what comes nearer grows");
    assert_eq!(octaves(-BASELINE_M - 0.01, BASELINE_M), vec![0, 1, 2], "what goes away shrinks");
    assert_eq!(octaves(1.0, f64::INFINITY), vec![1, 2, 3], "one camera cannot tell");
}

/// The prediction for a frame at `pose`, with a motion model of `velocity` per frame.
fn predicted(pose: &SE3, velocity: Option<SE3>, shots: &[Shot], params: &Params) -> Result<Prediction, Lost> {
    let scene = Scene::wall(N);
    let (map, last) = last_frame(&scene, &all(N), N as u32 / 2);
    let mut tracker = Tracker::new(params.clone());
    tracker.velocity = velocity.map(|motion| MotionModel::between(&SE3::identity(), &motion, 0.1));
    let frame: Arc<Frame> = scene.frame(1, pose, shots);
    tracker.predict_by_motion(&frame, &map, &last, tracker.inertia(&frame, &map, &last))
}

#[test]
fn the_last_motion_goes_on() {
    // 1.3 m aside are more than 50 px: found only where the model puts it.
    let pose = at(1.3, 0.1, 0.2);
    let found = predicted(&pose, Some(pose), &all(N), &params()).unwrap();
    assert!(gap(&found.cam_from_world, &pose) < 1e-3);
    let expected: Vec<(u32, PointId)> = (0..N as u32 / 2).map(|i| (i, PointId(i))).collect();
    assert_eq!(found.matches, expected, "features with depth help, but are not map points");
    assert_eq!(found.attempt, Attempt::Motion);
    let lost = predicted(&pose, None, &all(N), &params()).unwrap_err();
    assert_eq!(lost, Lost::TooFewMatches { found: 0, needed: 20 });
    assert!(predicted(&pose, Some(pose.inverse()), &all(N), &params()).is_err(), "the other way");
}

#[test]
fn windows_grow_to_four_times_their_size() {
    // 7 px at octave 2 are 10 px; at 8 to 12 m, 0.6 m are 25 to 38 px, 1.2 m are 50 to 75.
    assert!(predicted(&at(0.6, 0.0, 0.0), None, &all(N), &params()).is_ok());
    assert!(predicted(&at(1.2, 0.0, 0.0), None, &all(N), &params()).is_err());
}

#[test]
fn twenty_matches_and_a_third_of_them_as_inliers_are_needed() {
    let pose = SE3::identity();
    assert!(predicted(&pose, None, &all(20), &params()).is_ok());
    let lost = predicted(&pose, None, &all(19), &params()).unwrap_err();
    assert_eq!(lost, Lost::TooFewMatches { found: 19, needed: 20 });
    // Of 60 matches those that went apart in all directions are not inliers.
    let spoilt = |n: usize| {
        let mut shots = all(N);
        shots[..n].iter_mut().enumerate().for_each(|(i, s)| {
            let angle = 2.4 * i as f64;
            s.shift_px = [9.0 * angle.cos(), 9.0 * angle.sin()];
        });
        predicted(&pose, None, &shots, &params())
    };
    assert!(spoilt(38).is_ok());
    assert!(matches!(spoilt(42), Err(Lost::TooFewPredictedInliers { needed: 20, .. })), "{:?}", spoilt(42));
}

#[test]
fn after_a_loss_the_camera_may_have_gone_on_or_stayed() {
    let scene = Scene::wall(N);
    let (map, last) = last_frame(&scene, &all(N), N as u32 / 2);
    let on = at(1.3, 0.1, 0.2);
    let mut tracker = Tracker::new(params());
    tracker.velocity = Some(MotionModel::between(&SE3::identity(), &on, 0.1));
    for (is_lost, pose, is_found) in
        [(true, on, true), (true, SE3::identity(), true), (false, SE3::identity(), false)]
    {
        tracker.loss.is_lost = is_lost;
        let frame = scene.frame(1, &pose, &all(N));
        let inertia = tracker.inertia(&frame, &map, &last);
        let found = tracker.predict_by_motion(&frame, &map, &last, inertia);
        assert_eq!(found.is_ok(), is_found);
        if let Ok(found) = found {
            assert!(gap(&found.cam_from_world, &pose) < 1e-3);
            assert!(found.is_rough(), "the local map is searched in wide windows");
        }
    }
}
