//! The scene: frames follow their keyframes, blocks tell what to draw, the truth is laid onto the map.

use geometry::{SE3, Sensor, Vec3};
use map::{KeyframeId, Map};

use super::world::{bent_path, camera_at, row, start, tracked};
use crate::{
    Alignment, DeltaOptions, DeltaTracker, End, FinalPose, FrameState, KEYFRAMES_PER_BLOCK, PATH_PER_BLOCK,
    POINTS_PER_BLOCK, Pose, Record, Scene,
};

fn x_of(scene: &Scene, frame: u32) -> f64 {
    scene.frame(frame).unwrap().world_from_cam.unwrap().translation.x
}

/// A scene of a row of keyframes and what tells it of changes.
fn scene_of(map: &Map) -> (Scene, DeltaTracker) {
    let (mut scene, mut tracker) = (Scene::default(), DeltaTracker::new(DeltaOptions::default()));
    scene.apply(&start(100, Sensor::Stereo));
    scene.apply(&Record::Map(tracker.advance(map, 0)));
    (scene, tracker)
}

#[test]
fn frames_move_with_their_keyframes() {
    let mut map = row(5);
    let (mut scene, mut tracker) = scene_of(&map);
    scene.apply(&tracked(17, 3.25, Some(3), 3.0));
    assert!((x_of(&scene, 17) - 3.25).abs() < 1e-12);
    scene.take_dirty();
    map.set_estimates(&[(KeyframeId(3), camera_at(4.0))], &[]).unwrap();
    scene.apply(&Record::Map(tracker.advance(&map, 17)));
    assert!((x_of(&scene, 17) - 4.25).abs() < 1e-12);
    assert!(scene.take_dirty().path.contains(&0));
}

#[test]
fn frames_of_a_removed_keyframe_move_with_its_heir() {
    let mut map = row(5);
    let (mut scene, mut tracker) = scene_of(&map);
    scene.apply(&tracked(17, 3.25, Some(3), 3.0));
    map.remove_keyframe(KeyframeId(3)).unwrap();
    scene.apply(&Record::Map(tracker.advance(&map, 18)));
    assert!((x_of(&scene, 17) - 3.25).abs() < 1e-9, "it stays where it was");
    let (heir, _) = map.resolve_keyframe(KeyframeId(3)).unwrap();
    let moved = map.keyframe(heir).unwrap().cam_from_world * camera_at(10.0);
    map.set_estimates(&[(heir, moved)], &[]).unwrap();
    scene.apply(&Record::Map(tracker.advance(&map, 19)));
    assert!((x_of(&scene, 17) - 13.25).abs() < 1e-9);
}

#[test]
fn a_frame_that_becomes_a_keyframe_is_where_the_keyframe_is() {
    let mut map = row(2);
    let (mut scene, mut tracker) = scene_of(&map);
    // Frame 10 is tracked near keyframe 1, then inserted as keyframe 2, then that one is moved.
    scene.apply(&tracked(10, 1.9, Some(1), 1.0));
    super::world::insert(&mut map, 10, 2.0, &[4, 5, 6, 7], 4);
    scene.apply(&Record::Map(tracker.advance(&map, 10)));
    assert!((x_of(&scene, 10) - 2.0).abs() < 1e-12);
    map.set_estimates(&[(KeyframeId(1), camera_at(1.5))], &[]).unwrap();
    scene.apply(&Record::Map(tracker.advance(&map, 11)));
    assert!((x_of(&scene, 10) - 2.0).abs() < 1e-12, "it does not follow the old one any more");
    // The very first frame has no keyframe to refer to.
    scene.apply(&tracked(0, 0.0, None, 0.0));
    assert_eq!(x_of(&scene, 0), 0.0);
}

#[test]
fn lengths_follow_the_scale_of_the_keyframe() {
    let map = row(3);
    let (mut scene, mut tracker) = scene_of(&map);
    scene.apply(&tracked(7, 1.5, Some(1), 1.0));
    let mut delta = DeltaTracker::new(DeltaOptions::default()).advance(&map, 7);
    delta.keyframes.iter_mut().for_each(|k| k.scale = 2.0);
    scene.apply(&Record::Map(delta));
    assert!((x_of(&scene, 7) - 2.0).abs() < 1e-12, "half a meter became one");
    assert!(tracker.advance(&map, 8).is_empty());
}

#[test]
fn blocks_tell_what_changed_and_hold_everything_once() {
    let map = row(KEYFRAMES_PER_BLOCK + 6);
    let (mut scene, mut tracker) = scene_of(&map);
    let dirty = scene.take_dirty();
    let blocks = |set: &std::collections::BTreeSet<u32>| set.iter().copied().collect::<Vec<u32>>();
    assert_eq!(blocks(&dirty.keyframes), [0, 1]);
    let drawn: usize = dirty.points.iter().map(|&b| scene.points_in(b).count()).sum();
    assert_eq!(drawn, map.n_points());
    assert!(scene.points_in(0).all(|p| p.id < POINTS_PER_BLOCK));
    // The last keyframe of the first block moves: the edge from the first of the second block ends there.
    let mut map = map;
    map.set_estimates(&[(KeyframeId(KEYFRAMES_PER_BLOCK - 1), camera_at(63.5))], &[]).unwrap();
    scene.apply(&Record::Map(tracker.advance(&map, 0)));
    let dirty = scene.take_dirty();
    assert_eq!((blocks(&dirty.keyframes), blocks(&dirty.edges)), (vec![0], vec![0, 1]));
    assert_eq!(dirty.points.len(), 0);
    assert_eq!(scene.take_dirty(), crate::Dirty::default());
}

#[test]
fn edges_join_camera_centers() {
    let (scene, _) = scene_of(&row(3));
    let parents = scene.edges_in(0, |keyframe| keyframe.parent.as_slice());
    assert_eq!(parents.len(), 2);
    assert!(parents.iter().all(|[from, to]| ((from - to) - Vec3::x()).norm() < 1e-12), "{parents:?}");
}

#[test]
fn the_path_has_no_hole_between_blocks_and_stops_at_gaps() {
    let mut scene = Scene::default();
    for index in 0..PATH_PER_BLOCK + 10 {
        scene.apply(&tracked(index, f64::from(index), None, 0.0));
    }
    let Record::Frame(mut lost) = tracked(5, 0.0, None, 0.0) else { unreachable!() };
    (lost.state, lost.pose) = (FrameState::Lost, None);
    scene.apply(&Record::Frame(lost));
    assert_eq!(scene.take_dirty().path.into_iter().collect::<Vec<u32>>(), [0, 1]);
    let first: Vec<usize> = scene.path_in(0).iter().map(Vec::len).collect();
    assert_eq!(
        first,
        [5, PATH_PER_BLOCK as usize - 6 + 1],
        "frames 0 to 4, frames 6 to the next block's first"
    );
    assert_eq!(scene.path_in(0)[1].last(), scene.path_in(1)[0].first());
    // The first frame of a block is the end of the last block's path, too.
    scene.apply(&tracked(PATH_PER_BLOCK, 0.0, None, 0.0));
    assert_eq!(scene.take_dirty().path.len(), 2);
}

/// A frame without keyframe at a position.
fn placed(index: u32, position: Vec3) -> Record {
    let Record::Frame(mut record) = tracked(index, 0.0, None, 0.0) else { unreachable!() };
    record.pose.as_mut().unwrap().world_from_cam.translation = position.into();
    Record::Frame(record)
}

#[test]
fn the_truth_is_laid_onto_the_path_and_errors_are_meters() {
    for (sensor, unit) in [(Sensor::Stereo, 1.0), (Sensor::Mono, 4.0)] {
        let mut scene = Scene::default();
        scene.apply(&start(10, sensor));
        for index in 0..10 {
            scene.apply(&placed(index, bent_path(index) / unit));
        }
        let alignment = scene.alignment().unwrap();
        assert!((alignment.meters_per_unit() - unit).abs() < 1e-9, "{sensor}");
        assert!(scene.errors_m(&alignment).iter().all(|(_, error)| *error < 1e-9), "{sensor}");
        assert_eq!(scene.true_path(&alignment).iter().map(Vec::len).collect::<Vec<_>>(), [10]);
        // One frame is half a unit off.
        scene.apply(&placed(3, bent_path(3) / unit + Vec3::y() * 0.5));
        let errors = scene.errors_m(&scene.alignment().unwrap());
        let worst = errors.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!(worst.0 == 3 && worst.1 > 0.3 * unit && worst.1 < 0.5 * unit + 1e-9, "{sensor}: {worst:?}");
    }
    assert!(Scene::default().alignment().is_none());
    let one = Alignment::of(&[(Vec3::x(), Vec3::y())], false).unwrap();
    assert_eq!(one.apply(&Vec3::x()), Vec3::y(), "one pair is laid on each other");
}

#[test]
fn the_end_puts_frames_where_they_finally_are() {
    let map = row(3);
    let (mut scene, mut tracker) = scene_of(&map);
    scene.apply(&tracked(7, 1.5, Some(1), 1.0));
    let world_from_cam = Pose::from(&camera_at(8.0).inverse());
    let trajectory = vec![FinalPose { frame: 7, world_from_cam, submap: Some(0) }];
    scene.apply(&Record::End(End { trajectory, summary: String::new(), left_out: 0 }));
    assert_eq!(x_of(&scene, 7), 8.0);
    assert_eq!(scene.frame(7).unwrap().submap, Some(0));
    assert!(tracker.finish(&map, 7).is_empty());
}

#[test]
fn numbers_that_are_no_pose_are_passed_over() {
    let (mut scene, _) = scene_of(&row(3));
    let Record::Frame(mut record) = tracked(9, 1.0, Some(1), 1.0) else { unreachable!() };
    record.pose.as_mut().unwrap().cam_from_keyframe.translation[0] = f64::NAN;
    scene.apply(&Record::Frame(record));
    assert_eq!(scene.frame(9).unwrap().world_from_cam, None);
    let pose = Pose::from(&SE3::identity());
    assert!(pose.is_valid() && !Pose { rotation_xyzw: [0.0; 4], ..pose }.is_valid());
}
