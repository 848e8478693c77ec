//! The map without one of its loops: the drift of the path remains, and what later loops say.

use geometry::{SO3, Vec3};
use map::Map;

use super::*;
use crate::loops::LoopCorrection;
use crate::scene::{chain, on_circle, params};

const N: u32 = 24;

fn truth(k: u32) -> SE3 {
    on_circle(k, N, 8.0)
}

/// A round whose every step is a little wrong.
fn drifted() -> Vec<SE3> {
    let error = SE3::new(SO3::exp(&Vec3::new(0.0, 0.003, 0.0)), Vec3::new(0.005, 0.0, 0.01));
    let mut poses = vec![truth(0)];
    for k in 1..N {
        poses.push(error * truth(k) * truth(k - 1).inverse() * poses[k as usize - 1]);
    }
    poses
}

fn worst(map: &Map) -> f64 {
    let error = |k: &map::Keyframe| (k.center() - truth(k.id.0).center()).norm();
    map.keyframes().map(error).fold(0.0, f64::max)
}

/// Closes a loop whatever the gate says.
fn close(map: &mut Map, keyframe: u32, matched: u32, here_from_there: SE3) -> LoopCorrection {
    let mut open = params();
    open.camera.drift_sigma = 100.0;
    let verified = verified(map, matched, here_from_there);
    let found = correct(KeyframeId(keyframe), &verified, map, &open, None).unwrap();
    map.apply_correction(&found.correction).unwrap();
    found
}

fn verified(map: &Map, matched: u32, here_from_there: SE3) -> Verified {
    let there = map.keyframe(KeyframeId(matched)).unwrap().cam_from_world;
    let cam_from_world = here_from_there * there;
    let (matches, earlier_points) = (Vec::new(), Vec::new());
    Verified { matched: KeyframeId(matched), cam_from_world, scale: 1.0, matches, earlier_points }
}

fn motion(keyframe: u32, matched: u32) -> SE3 {
    truth(keyframe) * truth(matched).inverse()
}

#[test]
fn without_a_wrong_loop_a_later_right_one_still_holds() {
    let wrong = SE3::new(SO3::identity(), Vec3::new(4.0, 0.0, 0.0)) * motion(12, 1);
    let (mut map, mut right) = (chain(&drifted(), 16), chain(&drifted(), 16));
    close(&mut map, 12, 1, wrong);
    close(&mut map, 23, 0, motion(23, 0));
    close(&mut right, 23, 0, motion(23, 0));
    let world = World { map, ..World::default() };
    let without = Without::new(&world, &world.map.loops()[0], &params()).unwrap();
    assert_eq!(without.name, (KeyframeId(1), KeyframeId(12)));
    let [bent, now, best] = [&world.map, &without.world.map, &right].map(worst);
    assert!(bent > 4.0 * best, "{bent} m with the wrong loop, {now} m without it, {best} m");
    assert!(now < 1.5 * best, "{now} m without it, {best} m if it had not been closed");
    assert_eq!(without.world.map.loops().len(), 1);
    // What contradicts is found at once among both.
    let place = verified(&world.map, 3, motion(18, 3));
    let suspects = suspects(KeyframeId(18), &place, &world.map);
    assert_eq!((suspects.len(), suspects[0].keyframe), (2, KeyframeId(12)));
}

#[test]
fn a_correction_of_the_map_without_a_loop_is_told_in_terms_of_the_map_with_it() {
    let mut map = chain(&drifted(), 16);
    close(&mut map, 12, 1, SE3::new(SO3::identity(), Vec3::new(4.0, 0.0, 0.0)) * motion(12, 1));
    let world = World { map: map.clone(), ..World::default() };
    let without = Without::new(&world, &map.loops()[0], &params()).unwrap();
    let mut open = without.world.map.clone();
    let found = without.in_terms_of(&map, close(&mut open, 23, 0, motion(23, 0)));
    assert_eq!(found.correction.taken_back, [(KeyframeId(1), KeyframeId(12))]);
    map.apply_correction(&found.correction).unwrap();
    assert_eq!(map.check(), Ok(()));
    for (a, b) in map.keyframes().zip(open.keyframes()) {
        assert!((a.center() - b.center()).norm() < 1e-9, "{}", a.id);
    }
    assert_eq!(map.loops().iter().map(|l| l.keyframe).collect::<Vec<_>>(), [KeyframeId(23)]);
}
