//! The tracker from frame to frame: what it remembers, when it gives up, when it begins anew.

use super::*;
use crate::lost::Lost;
use crate::probe::NoProbe;
use crate::scene::{Scene, Shot, at, described, params, shot};

/// A described map of a wall of 120 landmarks, seen by two keyframes.
fn world() -> (Scene, World) {
    let scene = Scene::wall(120);
    let map = scene.map(&[at(0.0, 0.0, 0.0), at(0.3, 0.0, 0.0)]);
    (scene, described(map))
}

fn track(tracker: &mut Tracker, frame: &Arc<Frame>, world: &World) -> Tracked {
    tracker.track(frame, world, false, &mut NoProbe)
}

/// A frame of the first `n` landmarks.
fn some(scene: &Scene, index: u32, x: f64, n: usize) -> Arc<Frame> {
    scene.frame(index, &at(x, 0.0, 0.0), &(0..n).map(shot).collect::<Vec<Shot>>())
}

#[test]
fn a_known_map_is_entered_by_relocalization_which_tells_no_velocity() {
    let (scene, world) = world();
    let mut tracker = Tracker::new(params());
    let first = track(&mut tracker, &some(&scene, 2, 0.1, 120), &world);
    assert_eq!(first.state, TrackState::Tracked);
    assert!(first.stats.relocalized && first.stats.without_motion_model && tracker.velocity.is_none());
    // The next frame has no motion model yet; from the third on it leads.
    let second = track(&mut tracker, &some(&scene, 3, 0.2, 120), &world);
    assert!(!second.stats.relocalized && second.stats.without_motion_model && tracker.velocity.is_some());
    let third = track(&mut tracker, &some(&scene, 4, 0.3, 120), &world);
    assert!(!third.stats.without_motion_model);
    let pose = third.pose.unwrap().cam_from_world(&world.map).unwrap();
    assert!(crate::scene::gap(&pose, &at(0.3, 0.0, 0.0)) < 1e-3);
    assert_eq!((third.inliers.len(), third.stats.inliers, third.stats.local_points), (120, 120, 120));
}

#[test]
fn a_velocity_from_before_a_relocalization_is_forgotten() {
    // The first keyframe shows another place than the two newer ones, around which the camera is.
    let scene = Scene::wall(200);
    let mut map = Map::new();
    let new: Vec<(u32, geometry::Vec3)> = (0..100).map(|i| (i, scene.landmarks[i as usize])).collect();
    let view = |index, x, range: std::ops::Range<usize>| {
        scene.frame(index, &at(x, 0.0, 0.0), &range.map(shot).collect::<Vec<Shot>>())
    };
    crate::scene::add(&mut map, view(0, 0.0, 0..100), &at(0.0, 0.0, 0.0), &[], &new);
    let new: Vec<(u32, geometry::Vec3)> = (0..100).map(|i| (i, scene.landmarks[100 + i as usize])).collect();
    crate::scene::add(&mut map, view(1, 0.0, 100..200), &at(0.0, 0.0, 0.0), &[], &new);
    let matches: Vec<(u32, u32)> = (0..100).map(|i| (i, 100 + i)).collect();
    crate::scene::add(&mut map, view(2, 0.1, 100..200), &at(0.1, 0.0, 0.0), &matches, &[]);
    let world = described(map);
    let mut tracker = Tracker::new(params());
    for (index, x) in [(3, 0.1), (4, 0.2)] {
        assert_eq!(track(&mut tracker, &view(index, x, 100..200), &world).state, TrackState::Tracked);
    }
    assert!(tracker.velocity.is_some());
    let away = track(&mut tracker, &view(5, 0.3, 0..100), &world);
    assert!(away.stats.relocalized && tracker.velocity.is_none(), "{:?}", away.state);
}

#[test]
fn thirty_points_of_the_local_map_must_agree() {
    let (scene, world) = world();
    let mut tracker = Tracker::new(params());
    track(&mut tracker, &some(&scene, 2, 0.1, 120), &world);
    let lost = track(&mut tracker.clone(), &some(&scene, 3, 0.1, 29), &world);
    assert_eq!(lost.state, TrackState::Lost(Lost::TooFewLocalInliers { found: 29, needed: 30 }));
    assert!(lost.pose.is_some(), "the last one known");
    assert_eq!(track(&mut tracker, &some(&scene, 3, 0.1, 30), &world).state, TrackState::Tracked);
}

#[test]
fn after_a_loss_few_points_suffice_where_the_camera_went_on_as_before() {
    let (scene, world) = world();
    let mut tracker = Tracker::new(params());
    for (index, x) in [(2, 0.0), (3, 0.05), (4, 0.1)] {
        track(&mut tracker, &some(&scene, index, x, 120), &world);
    }
    let fifteen = |index, x| scene.frame(index, &at(x, 0.0, 0.0), &(0..15).map(shot).collect::<Vec<Shot>>());
    let mut one = tracker.clone();
    one.params.camera.sensor = geometry::Sensor::Mono;
    for tracker in [&mut tracker, &mut one] {
        tracker.params.tracking.min_motion_matches = 10;
        tracker.params.tracking.min_predicted_inliers = 10;
        let lost = track(tracker, &fifteen(5, 0.15), &world);
        assert!(matches!(lost.state, TrackState::Lost(_)), "not before a loss: {:?}", lost.state);
    }
    let tried = |x| track(&mut tracker.clone(), &fifteen(8, x), &world).state;
    assert_eq!(tried(0.3), TrackState::Tracked, "four frames later");
    assert!(matches!(tried(0.1), TrackState::Lost(_)), "where it was last seen");
    assert!(
        matches!(track(&mut one, &fifteen(8, 0.3), &world).state, TrackState::Lost(_)),
        "without a scale"
    );
    // Until the map knows what is ahead.
    track(&mut tracker, &fifteen(8, 0.3), &world);
    let end = tracker.loss.resuming_until;
    assert_eq!(end, 8 + tracker.params.camera.max_keyframe_gap);
    let state = |index, x| track(&mut tracker.clone(), &fifteen(index, x), &world).state;
    assert_eq!(state(9, 0.35), TrackState::Tracked);
    assert!(matches!(state(end, 0.3 + 0.05 * f64::from(end - 8)), TrackState::Lost(_)));
}

#[test]
fn after_a_lasting_loss_a_new_sub_map_begins() {
    let (scene, world) = world();
    // Elsewhere: nothing looks like the map.
    let mut elsewhere = scene.clone();
    elsewhere.looks.reverse();
    elsewhere.looks.iter_mut().for_each(|look| *look = crate::scene::flipped(*look, 128));
    let mut tracker = Tracker::new(params());
    track(&mut tracker, &some(&scene, 2, 0.1, 120), &world);
    // Frames that could not start a map do not count.
    for index in 3..20 {
        let few = track(&mut tracker, &some(&elsewhere, index, 0.0, 99), &world);
        assert!(matches!(few.state, TrackState::Lost(_)));
    }
    for index in 20..30 {
        let lost = track(&mut tracker, &some(&elsewhere, index, 0.0, 100), &world);
        assert!(matches!(lost.state, TrackState::Lost(_)), "frame {index}: {:?}", lost.state);
    }
    let mut only = tracker.clone();
    let started = track(&mut tracker, &some(&elsewhere, 30, 0.0, 100), &world);
    assert_eq!(started.state, TrackState::Started);
    let Some(Placement::NewSubmap { cam_from_world }) = started.keyframe.map(|request| request.placement)
    else {
        panic!("a keyframe is asked for");
    };
    assert!(crate::scene::gap(&cam_from_world, &at(0.1, 0.0, 0.0)) < 1e-3, "where the camera was last seen");
    only.params.tracking.localize_only = true;
    let lost = track(&mut only, &some(&elsewhere, 30, 0.0, 100), &world);
    assert!(matches!(lost.state, TrackState::Lost(_)), "a map that is only read gets no sub-map");
}

#[test]
fn nothing_is_tracked_before_the_first_keyframe_is_in_the_map() {
    let scene = Scene::wall(120);
    let mut tracker = Tracker::new(params());
    let empty = World::default();
    let first = scene.whole(0, &at(0.0, 0.0, 0.0));
    assert_eq!(track(&mut tracker, &first, &empty).state, TrackState::Started);
    let second = scene.whole(1, &at(0.1, 0.0, 0.0));
    let waiting = track(&mut tracker, &second, &empty);
    assert_eq!(waiting.state, TrackState::NotReady(NotReady::MapStarting));
    let mut map = Map::new();
    let new: Vec<(u32, geometry::Vec3)> = (0..).zip(scene.landmarks.iter().copied()).collect();
    crate::scene::add(&mut map, first, &at(0.0, 0.0, 0.0), &[], &new);
    let world = World { map, ..World::default() };
    assert_eq!(track(&mut tracker, &second, &world).state, TrackState::Tracked);
}
