//! The last frame follows what happens to the map.

use map::{Batch, KeyframeId, NewKeyframe, Parent};

use super::*;
use crate::scene::{Scene, at, gap};

fn world() -> (Scene, Map, LastFrame) {
    let scene = Scene::wall(10);
    let map = scene.map(&[at(0.0, 0.0, 0.0), at(0.5, 0.0, 0.0)]);
    let pose = RelativePose::new(&map, KeyframeId(1), at(0.2, 0.0, 0.0));
    let matches: Vec<(u32, PointId)> = (0..4).map(|i| (i, PointId(i))).collect();
    let last = LastFrame::new(scene.whole(5, &at(0.7, 0.0, 0.0)), pose, &matches);
    (scene, map, last)
}

#[test]
fn its_pose_moves_with_its_keyframe() {
    let (_, mut map, last) = world();
    assert!(gap(&last.cam_from_world(&map), &at(0.7, 0.0, 0.0)) < 1e-12);
    map.set_estimates(&[(KeyframeId(1), at(0.5, 0.3, 0.0))], &[]).unwrap();
    assert!(gap(&last.cam_from_world(&map), &at(0.7, 0.3, 0.0)) < 1e-12);
}

#[test]
fn a_removed_keyframe_hands_it_on_to_its_parent() {
    let (_, mut map, last) = world();
    map.remove_keyframe(KeyframeId(1)).unwrap();
    let last = last.refreshed(&map);
    assert_eq!(last.pose.keyframe, KeyframeId(0));
    assert!(gap(&last.cam_from_world(&map), &at(0.7, 0.0, 0.0)) < 1e-12);
}

#[test]
fn merged_points_are_followed_and_removed_ones_forgotten() {
    let (_, mut map, last) = world();
    map.merge_points(PointId(9), PointId(1)).unwrap();
    map.remove_point(PointId(2)).unwrap();
    assert_eq!(last.refreshed(&map).matches, [(0, PointId(0)), (1, PointId(9)), (3, PointId(3))]);
}

#[test]
fn once_it_is_the_newest_keyframe_it_has_that_one_s_points() {
    let (scene, mut map, last) = world();
    assert!(LastFrame::of_newest_keyframe(&map, &last.frame).is_none());
    let keyframe = NewKeyframe {
        frame: last.frame.clone(),
        cam_from_world: at(0.7, 0.0, 0.0),
        matches: vec![(2, PointId(2)), (8, PointId(8))],
        parent: Parent::Closest,
    };
    map.insert(Batch { keyframe: Some(keyframe), points: Vec::new() }).unwrap();
    let last = last.refreshed(&map);
    assert_eq!(
        (last.pose.keyframe, last.matches.clone()),
        (KeyframeId(2), vec![(2, PointId(2)), (8, PointId(8))])
    );
    // The same features in another frame are not the same frame.
    assert!(LastFrame::of_newest_keyframe(&map, &scene.whole(5, &at(0.7, 0.0, 0.0))).is_none());
}

#[test]
fn times_are_counted_forwards() {
    let (scene, _, last) = world();
    let later = scene.frame(8, &at(0.0, 0.0, 0.0), &[]);
    assert!((last.seconds_to(&later) - 0.3).abs() < 1e-9);
}
