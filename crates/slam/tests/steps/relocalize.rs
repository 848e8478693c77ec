//! A pose from the keyframes that look alike, wherever the camera was before.

use geometry::SE3;

use super::*;
use crate::scene::{Scene, Shot, at, described, gap, params, shot};

fn truth() -> SE3 {
    at(0.6, -0.2, 0.4)
}

/// The answer for a frame that shows these shots of a wall of 80 landmarks.
fn relocalized(shots: &[Shot]) -> Result<RefinedPose, Lost> {
    let scene = Scene::wall(80);
    let world = described(scene.map(&[SE3::identity(), at(0.3, 0.0, 0.0)]));
    relocalize(&scene.frame(2, &truth(), shots), &world, &params())
}

fn first(n: usize) -> Vec<Shot> {
    (0..n).map(shot).collect()
}

#[test]
fn a_known_place_is_recognized() {
    let found = relocalized(&first(80)).unwrap();
    assert!(gap(&found.cam_from_world, &truth()) < 1e-3);
    assert_eq!(found.inliers.len(), 80);
}

#[test]
fn fifty_inliers_make_it_certain() {
    assert_eq!(relocalized(&first(50)).unwrap().inliers.len(), 50);
    assert_eq!(relocalized(&first(49)).unwrap_err(), Lost::TooFewPredictedInliers { found: 49, needed: 50 });
}

#[test]
fn fifteen_descriptors_must_match() {
    assert_eq!(relocalized(&first(14)).unwrap_err(), Lost::TooFewMatches { found: 14, needed: 15 });
    let lost = relocalized(&first(15)).unwrap_err();
    assert!(matches!(lost, Lost::TooFewPredictedInliers { found: 15, needed: 50 }), "{lost:?}");
}

#[test]
fn guided_search_adds_what_looks_less_alike() {
    // 50 of the 80 are 90 bits off: no match by words, but found where the pose puts them.
    let mut shots = first(80);
    shots[..50].iter_mut().for_each(|s| s.flipped = 90);
    assert_eq!(relocalized(&shots).unwrap().inliers.len(), 80);
    shots[..50].iter_mut().for_each(|s| s.flipped = 101);
    assert_eq!(relocalized(&shots).unwrap_err(), Lost::TooFewPredictedInliers { found: 30, needed: 50 });
}

#[test]
fn without_words_nothing_is_recognized() {
    let scene = Scene::wall(80);
    let world = World { map: scene.map(&[SE3::identity()]), ..World::default() };
    let lost = relocalize(&scene.whole(1, &truth()), &world, &params()).unwrap_err();
    assert_eq!(lost, Lost::TooFewMatches { found: 0, needed: 15 });
}
