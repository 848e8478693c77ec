//! One camera drives along a ring road, turns on the spot and drives on: the map is kept.

#[allow(dead_code, reason = "each test takes what it needs")]
mod common;

use common::{Pair, World};
use dsslam_slam::{CameraParams, Params, QualityReason, TrackState};
use geometry::{SE3, SO3, Vec3};

const RADIUS_M: f64 = 60.0;
const STEP_M: f64 = 0.5;
/// Frame in which the camera comes to a stop.
const STOP: u32 = 40;
/// Frames of the turn.
const TURN: u32 = 120;

/// Pose `meters` along the ring, the camera turned aside by `aside` radians.
fn on_ring(meters: f64, aside: f64) -> SE3 {
    let angle = meters / RADIUS_M;
    let center = Vec3::new(RADIUS_M * (1.0 - angle.cos()), 0.0, RADIUS_M * angle.sin());
    SE3::new(SO3::exp(&Vec3::new(0.0, angle + aside, 0.0)), center)
}

/// The pose of a frame: a stop of ten frames, then a turn by `deg` in all.
fn pose(i: u32, deg: f64) -> SE3 {
    let driven = STEP_M * f64::from(i.min(STOP) + i.saturating_sub(STOP + 10 + TURN));
    let part = f64::from(i.saturating_sub(STOP + 10).min(TURN)) / f64::from(TURN);
    on_ring(driven, deg.to_radians() * part)
}

/// Turns around by 360 degrees; without features in the `black` frames.
fn turn_around(black: &[u32]) {
    let mut world = World::ring(RADIUS_M, 0.3, 30.0);
    world.stereo = false;
    let mut pair = Pair::new(&Params::of(CameraParams::mono(10.0)));
    let (mut held, mut poses) = (0, Vec::new());
    for i in 0..STOP + TURN + 40 {
        if black.contains(&i) {
            let tracked = pair.step(&world.black(i));
            assert!(matches!(tracked.state, TrackState::Lost(_)), "frame {i}: {:?}", tracked.state);
            continue;
        }
        let tracked = pair.step(&world.frame(i, &pose(i, 360.0)));
        if i < 10 {
            continue;
        }
        assert_eq!(tracked.state, TrackState::Tracked, "frame {i}");
        let is_held = tracked.assessment.reasons.contains(&QualityReason::TurningOnTheSpot);
        assert!(!is_held || tracked.keyframe.is_none(), "frame {i}: nothing new has a depth");
        held += u32::from(is_held);
        poses.push((i, pair.world_from_cam(&tracked).expect("a pose")));
    }
    let map = &pair.mapper.world().map;
    assert_eq!((map.roots().len(), map.check()), (1, Ok(())));
    assert!(held > 30, "{held} frames with the rotation alone");
    // The way after the turn is as long, in units of the map, as the same way before it.
    let way = |from: u32, to: u32| {
        let at = |i: u32| poses.iter().find(|p| p.0 == i).expect("tracked").1.translation;
        (at(to) - at(from)).norm()
    };
    let (before, after) = (way(20, 35), way(STOP + TURN + 15, STOP + TURN + 30));
    assert!((after / before - 1.0).abs() < 0.05, "{before} before, {after} after");
    // Turned right to the pixel, while nothing but directions was seen.
    let (first, middle) =
        (poses[0].1, poses.iter().find(|p| p.0 == STOP + 10 + TURN / 2).expect("tracked").1);
    let seen = first.rotation.inverse() * middle.rotation;
    let expected = pose(10, 360.0).rotation.inverse() * pose(STOP + 10 + TURN / 2, 360.0).rotation;
    let error = (seen * expected.inverse()).angle();
    assert!(error < 0.01, "{error} rad");
}

#[test]
fn a_camera_that_turns_around_keeps_its_map() {
    turn_around(&[]);
}

#[test]
fn a_turn_is_followed_across_frames_that_show_nothing() {
    turn_around(&[STOP + 50, STOP + 51, STOP + 75]);
}
