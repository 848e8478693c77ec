//! Redundant keyframes go: nearly all their close points are seen by three others as finely.

use geometry::Vec3;

use super::*;
use crate::CameraParams;
use crate::scene::{Scene, Shot, add, at, mapper, params, shot};

/// Keyframes 0 and 1 show all landmarks; 2, 3 and 4 the first `n_shared` only. All but 1 see them at `octave`.
fn world(landmarks: Vec<Vec3>, n_shared: usize, octave: u8) -> Mapper {
    let scene = Scene::at(landmarks);
    let mut map = Map::new();
    let all: Vec<(u32, Vec3)> = (0..).zip(scene.landmarks.iter().copied()).collect();
    for k in 0..5 {
        let pose = at(0.1 * f64::from(k), 0.0, 0.0);
        let n = if k < 2 { scene.len() } else { n_shared };
        let seen_at = if k == 1 { crate::scene::OCTAVE } else { octave };
        let shots: Vec<Shot> = (0..n).map(|i| Shot { octave: seen_at, ..shot(i) }).collect();
        let matches: Vec<(u32, u32)> = (0..n as u32).map(|i| (i, i)).collect();
        let (matches, new) = if k == 0 { (&[][..], &all[..]) } else { (&matches[..], &[][..]) };
        add(&mut map, scene.frame(k, &pose, &shots), &pose, matches, new);
    }
    mapper(map, &params())
}

fn near(n: usize) -> Vec<Vec3> {
    Scene::wall(n).landmarks
}

fn living(mapper: &Mapper) -> Vec<u32> {
    mapper.world.map.keyframes().map(|kf| kf.id.0).collect()
}

#[test]
fn a_keyframe_is_redundant_from_nine_tenths_on() {
    // 18 of 20 points are exactly nine tenths, 19 of 20 are more.
    assert!(!is_redundant(&world(near(20), 18, 2).world.map, KeyframeId(1), &params()));
    assert!(is_redundant(&world(near(20), 19, 2).world.map, KeyframeId(1), &params()));
}

#[test]
fn only_close_points_count() {
    // Half of the points are 25 m away, beyond the 20 m that count as close, and shown by one other keyframe only.
    let mut landmarks = near(20);
    landmarks.extend(near(20).iter().map(|p| Vec3::new(p.x, p.y, 25.0)));
    let world = world(landmarks, 20, 2);
    assert!(is_redundant(&world.world.map, KeyframeId(1), &params()));
    let far = crate::Params::of(CameraParams::stereo(30.0, 10.0));
    assert!(!is_redundant(&world.world.map, KeyframeId(1), &far));
    let mono = crate::Params::of(CameraParams::mono(10.0));
    assert!(!is_redundant(&world.world.map, KeyframeId(1), &mono), "one camera counts all points");
}

#[test]
fn observers_at_a_coarser_scale_do_not_count() {
    assert!(is_redundant(&world(near(20), 20, 3).world.map, KeyframeId(1), &params()), "one octave coarser");
    assert!(!is_redundant(&world(near(20), 20, 4).world.map, KeyframeId(1), &params()), "two octaves");
    assert!(is_redundant(&world(near(20), 20, 0).world.map, KeyframeId(1), &params()), "finer");
}

#[test]
fn three_others_are_needed() {
    let mut mapper = world(near(20), 20, 2);
    mapper.world.map.remove_keyframe(KeyframeId(3)).unwrap();
    assert!(is_redundant(&mapper.world.map, KeyframeId(1), &params()), "0, 2 and 4 see it all");
    mapper.world.map.remove_keyframe(KeyframeId(2)).unwrap();
    assert!(!is_redundant(&mapper.world.map, KeyframeId(1), &params()));
}

#[test]
fn the_root_and_the_newest_stay() {
    let mut mapper = world(near(20), 20, 2);
    // One after the other goes until three others are left to see each point.
    assert_eq!(mapper.cull_keyframes(KeyframeId(4)), 2);
    assert_eq!(mapper.world.map.check(), Ok(()));
    assert_eq!(living(&mapper), vec![0, 3, 4]);
}

#[test]
fn keyframes_that_share_little_are_not_looked_at() {
    // 14 shared points are one less than covisibility asks for.
    let mut mapper = world(near(14), 14, 2);
    assert!(is_redundant(&mapper.world.map, KeyframeId(1), &params()));
    assert_eq!(mapper.cull_keyframes(KeyframeId(4)), 0);
}
