//! Features matched with the points of a keyframe by their looks.

use geometry::SE3;
use map::{KeyframeId, Map};

use super::*;
use crate::scene::{Scene, Shot, at, described, shot};

fn by_words(map: &Map, frame: &Frame, eligible: Option<&[bool]>) -> Vec<(u32, u32)> {
    let world = described(map.clone());
    let seen = world.places.describe(frame).unwrap();
    let keyframe = world.map.keyframe(KeyframeId(0)).unwrap();
    match_by_words(frame, &seen.direct, eligible, keyframe, &world.places)
}

/// A frame that sees the landmarks of a map in reverse order.
fn reversed(n: usize, change: impl Fn(&mut Shot)) -> (Map, std::sync::Arc<Frame>) {
    let scene = Scene::wall(n);
    let map = scene.map(&[SE3::identity(), at(0.2, 0.0, 0.0)]);
    let mut shots: Vec<Shot> = (0..n).rev().map(shot).collect();
    shots.iter_mut().for_each(change);
    (map, scene.frame(2, &at(0.1, 0.0, 0.0), &shots))
}

#[test]
fn both_ways_match_what_looks_alike() {
    let (map, frame) = reversed(20, |_| {});
    let keyframe = map.keyframe(KeyframeId(0)).unwrap();
    assert_eq!(match_all(&frame, keyframe), (0..20).map(|i| (i, PointId(19 - i))).collect::<Vec<_>>());
    assert_eq!(by_words(&map, &frame, None), (0..20).map(|i| (i, 19 - i)).collect::<Vec<_>>());
}

#[test]
fn fifty_bits_are_alike_and_more_are_not() {
    for (bits, n) in [(50, 20), (51, 0)] {
        let (map, frame) = reversed(20, |s| s.flipped = bits);
        assert_eq!(match_all(&frame, map.keyframe(KeyframeId(0)).unwrap()).len(), n, "{bits} bits");
    }
}

#[test]
fn only_features_with_points_take_part() {
    let (mut map, frame) = reversed(20, |_| {});
    map.remove_point(PointId(4)).unwrap();
    let keyframe = map.keyframe(KeyframeId(0)).unwrap();
    assert!(
        !match_all(&frame, keyframe).iter().any(|m| m.0 == 15) && match_all(&frame, keyframe).len() == 19
    );
    assert!(!with_point(keyframe)[4] && with_point(keyframe)[5]);
    assert_eq!(by_words(&map, &frame, None).len(), 19);
    let eligible: Vec<bool> = (0..20).map(|i| i < 3).collect();
    assert_eq!(by_words(&map, &frame, Some(&eligible)), vec![(0, 19), (1, 18), (2, 17)]);
}

#[test]
fn matches_turn_together() {
    let (map, frame) = reversed(20, |s| s.angle_deg = if s.landmark == 7 { 130.0 } else { 40.0 });
    let matches = match_all(&frame, map.keyframe(KeyframeId(0)).unwrap());
    assert!(matches.len() == 19 && !matches.iter().any(|m| m.1 == PointId(7)));
    assert_eq!(by_words(&map, &frame, None).len(), 19);
}

#[test]
fn of_two_alike_points_neither_is_matched() {
    let mut scene = Scene::wall(20);
    scene.looks[1] = crate::scene::flipped(scene.looks[0], 12);
    let map = scene.map(&[SE3::identity()]);
    let shots: Vec<Shot> = (0..20).map(|i| Shot { flipped: if i < 2 { 6 } else { 0 }, ..shot(i) }).collect();
    // Feature 0 is 6 bits from both looks; feature 1 is too.
    let matches = match_all(&scene.frame(1, &SE3::identity(), &shots), map.keyframe(KeyframeId(0)).unwrap());
    assert_eq!(matches.len(), 18);
}
