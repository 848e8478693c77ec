//! Search by projection: windows, octaves, what is free, and what most features agree on.

use super::*;
use crate::scene::{OCTAVE, Scene, Shot, at, shot};

const WINDOW: Window = Window { radius_px: 4.0, max_distance: 50 };

/// Matches of ten points with a frame of these shots at the origin.
fn found(shots: &[Shot], given: &[(u32, PointId)], window: Window) -> Found {
    let scene = Scene::wall(10);
    let map = scene.map(&[SE3::identity(), at(0.3, 0.0, 0.0)]);
    let frame = scene.frame(2, &SE3::identity(), shots);
    let points: Vec<PointId> = (0..10).map(PointId).collect();
    search_points(&frame, &map, &SE3::identity(), &points, given, window)
}

fn all() -> Vec<Shot> {
    (0..10).map(shot).collect()
}

#[test]
fn every_point_finds_its_feature() {
    let reversed: Vec<Shot> = (0..10).rev().map(shot).collect();
    let found = found(&reversed, &[], WINDOW);
    assert_eq!(found.matches, (0..10).map(|i| (i, PointId(9 - i))).collect::<Vec<_>>());
    assert_eq!(found.visible.len(), 10);
}

#[test]
fn the_window_grows_with_the_octave() {
    // The octave is predicted from the distance and may come out one coarser than the feature's.
    let radius = f64::from(WINDOW.radius_px) * 1.2_f64.powi(i32::from(OCTAVE));
    let shifted = |pixels: f64| {
        let mut shots = all();
        shots[3].shift_px = [0.0, pixels];
        found(&shots, &[], WINDOW).matches.len()
    };
    assert_eq!(shifted(radius - 0.1), 10);
    assert_eq!(shifted(1.2 * radius + 0.1), 9);
}

#[test]
fn the_right_column_must_fit_where_it_is_known() {
    let with = |right_px: f64, stereo: bool| {
        let mut shots = all();
        (shots[3].right_px, shots[3].stereo) = (right_px, stereo);
        found(&shots, &[], WINDOW).matches.len()
    };
    assert_eq!([with(5.0, true), with(-8.0, true), with(-8.0, false)], [10, 9, 10]);
}

#[test]
fn a_feature_of_another_octave_or_look_is_not_taken() {
    let with = |change: &dyn Fn(&mut Shot)| {
        let mut shots = all();
        change(&mut shots[3]);
        found(&shots, &[], WINDOW).matches.iter().any(|&(feature, _)| feature == 3)
    };
    assert!(with(&|s| s.octave = OCTAVE));
    assert!(!with(&|s| s.octave = OCTAVE + 2) && !with(&|s| s.octave = OCTAVE - 2));
    assert!(with(&|s| s.flipped = 50) && !with(&|s| s.flipped = 51));
}

#[test]
fn given_matches_stay_and_their_features_and_points_are_not_searched() {
    // Feature 2 shows landmark 2 but was given to point 5.
    let found = found(&all(), &[(2, PointId(5))], WINDOW);
    assert!(found.matches.contains(&(2, PointId(5))));
    assert!(!found.matches.iter().any(|&(_, point)| point == PointId(2)), "its feature is taken");
    assert!(!found.matches.iter().any(|&(feature, _)| feature == 5), "its point is taken");
    assert_eq!(found.matches.len(), 9);
    assert!(found.matches.is_sorted() && found.visible.len() == 9 && !found.visible.contains(&PointId(5)));
}

#[test]
fn the_judgment_may_depend_on_the_key() {
    let scene = Scene::wall(4);
    let frame = scene.whole(0, &SE3::identity());
    let asked = (0..4).map(|i| {
        let (keypoint, octave) = (&frame.keypoints[i], OCTAVE);
        let query = ProjectionQuery {
            x: keypoint.x,
            y: keypoint.y,
            right_u: f32::NAN,
            radius_px: 2.0,
            min_octave: octave,
            max_octave: octave,
            descriptor: scene.looks[i],
        };
        (10 * i, query)
    });
    let matches = search(&frame, asked, &[true, true, false, true], |key, _| key != 10);
    assert_eq!(matches, vec![(0, 0), (3, 30)]);
}

#[test]
fn matches_that_turn_otherwise_are_dropped() {
    let scene = Scene::wall(12);
    let shots: Vec<Shot> = (0..12)
        .map(|i| Shot { angle_deg: if i == 7 { 200.0 } else { 25.0 * i as f32 }, ..shot(i) })
        .collect();
    let frame = scene.frame(0, &SE3::identity(), &shots);
    // All the others have turned by 40 degrees.
    let matches: Vec<(u32, u32)> = (0..12).map(|i| (i, 25 * i + 40)).collect();
    let kept = consistent_in_rotation(&frame, matches, |&angle| angle as f32);
    assert_eq!(kept.len(), 11);
    assert!(kept.iter().all(|&(feature, _)| feature != 7));
}

#[test]
fn points_of_keyframes_come_sorted_and_once() {
    let scene = Scene::wall(6);
    let mut map = scene.map(&[SE3::identity()]);
    // The second keyframe shows points 3 and 1, the third only 5.
    for (points, x) in [(&[3_u32, 1][..], 0.3), (&[5][..], 0.6)] {
        let shots: Vec<Shot> = points.iter().map(|&p| shot(p as usize)).collect();
        let matches: Vec<(u32, u32)> = (0..).zip(points.iter().copied()).collect();
        let pose = at(x, 0.0, 0.0);
        crate::scene::add(&mut map, scene.frame(1, &pose, &shots), &pose, &matches, &[]);
    }
    let ids = |points: Vec<PointId>| points.iter().map(|p| p.0).collect::<Vec<u32>>();
    assert_eq!(ids(points_of(&map, [KeyframeId(1), KeyframeId(2), KeyframeId(1)])), vec![1, 3, 5]);
    assert_eq!(ids(points_around(&map, KeyframeId(1), 0)), vec![1, 3]);
    assert_eq!(ids(points_around(&map, KeyframeId(1), 1)), vec![0, 1, 2, 3, 4, 5]);
    assert_eq!(ids(points_around(&map, KeyframeId(9), 5)), Vec::<u32>::new());
}
