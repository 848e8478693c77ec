//! Two motions in one image: whose is the camera's?

use super::*;
use crate::scene::{Scene, at, params, shot};

const SECONDS: f64 = 0.1;
/// A camera that would go on by this much, and by how much the vehicle's motion deceives it.
const STEP_M: f64 = 1.0;
const DECEIT_M: f64 = 0.25;

/// A frame in which the first `n_scene` points stand and the `n_vehicle` others moved along with `deceit_m` of the camera's step,
/// and the matches of all.
fn view(n_scene: usize, n_vehicle: usize, deceit_m: f64) -> (std::sync::Arc<Frame>, Vec<(u32, Vec3)>) {
    let n = n_scene + n_vehicle;
    let stands = Scene::wall(n);
    let moved = |(i, p): (usize, &Vec3)| if i < n_scene { *p } else { p + Vec3::x() * deceit_m };
    let seen = Scene::at(stands.landmarks.iter().enumerate().map(moved).collect());
    let shots: Vec<_> = (0..n).map(shot).collect();
    let frame = seen.frame(1, &at(STEP_M, 0.0, 0.0), &shots);
    let matches = (0..n).map(|i| (i as u32, stands.landmarks[i])).collect();
    (frame, matches)
}

/// Where inertia puts the camera along x beyond the point predicted, and how many of the first `n_scene` and of the other matches
/// agree.
fn decided(n_scene: usize, n_vehicle: usize, predicted_m: f64, deceit_m: f64) -> (f64, usize, usize) {
    let (frame, matches) = view(n_scene, n_vehicle, deceit_m);
    let noise = params().noise();
    let predicted = at(predicted_m, 0.0, 0.0);
    let first = refine_with_positions(&frame, predicted, &matches, noise);
    let (pose, agree) = Inertia { predicted, seconds: SECONDS }.likelier(&frame, &matches, first, noise);
    let count = |part: &[bool]| part.iter().filter(|agrees| **agrees).count();
    (pose.center().x - STEP_M, count(&agree[..n_scene]), count(&agree[n_scene..]))
}

#[test]
fn a_vehicle_that_fills_the_view_does_not_carry_the_camera_away() {
    let (off, scene, vehicle) = decided(40, 80, STEP_M, DECEIT_M);
    assert!(off.abs() < 0.01, "{off}");
    assert_eq!((scene, vehicle), (40, 0));
}

#[test]
fn the_larger_group_wins_where_inertia_does_not_speak_against_it() {
    // The camera is where the larger group puts it: it was predicted there.
    let (off, scene, vehicle) = decided(40, 80, STEP_M - DECEIT_M, DECEIT_M);
    assert!((off + DECEIT_M).abs() < 0.01, "{off}");
    assert_eq!((scene, vehicle), (0, 80));
    // A shift that braking could be.
    let (off, ..) = decided(40, 80, STEP_M, 0.07);
    assert!((off + 0.07).abs() < 0.01, "{off}");
}

#[test]
fn a_few_matches_are_no_second_motion() {
    // 14 of 114 stand still: too few to be believed against all others.
    let (off, scene, vehicle) = decided(14, 100, STEP_M, DECEIT_M);
    assert!((off + DECEIT_M).abs() < 0.01, "{off}");
    assert_eq!((scene, vehicle), (0, 100));
}

#[test]
fn a_camera_cannot_jump() {
    let inertia = Inertia { predicted: at(STEP_M, 0.0, 0.0), seconds: SECONDS };
    assert_eq!(inertia.check(&at(STEP_M, 0.5, 0.0)), Ok(()));
    let Err(Lost::TooFar { off_m, most_m }) = inertia.check(&at(STEP_M, 0.0, -0.6)) else {
        panic!("a jump of 0.6 m is too far")
    };
    assert!((off_m - 0.6).abs() < 1e-9 && (most_m - 0.53).abs() < 1e-9, "{off_m} {most_m}");
    // After three frames without one it may be nine times as far.
    let later = Inertia { seconds: 3.0 * SECONDS, ..inertia };
    assert_eq!(later.check(&at(STEP_M, 0.0, 4.0)), Ok(()));
}
