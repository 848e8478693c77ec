//! Tracking and mapping over a corridor of points: accuracy, repeatability, loss and recovery.

#[allow(dead_code, reason = "each test takes what it needs")]
mod common;

use common::{Pair, World, slalom};
use dsslam_slam::{CameraParams, Lost, NotReady, Params, TrackState};
use features::Frame;
use geometry::SE3;
use std::sync::Arc;

fn params() -> Params {
    Params::of(CameraParams::stereo(21.0, 10.0))
}

/// Distance between the estimated and the true camera centers, in the frame of the first camera.
fn error_m(estimate: &SE3, i: u32) -> f64 {
    let truth = slalom(0).inverse() * slalom(i);
    (estimate.translation - truth.translation).norm()
}

#[test]
fn a_drive_down_the_corridor_stays_on_course() {
    let world = World::corridor(80.0, 0.3);
    let mut pair = Pair::new(&params());
    for i in 0..60 {
        let tracked = pair.step(&world.frame(i, &slalom(i)));
        assert!(
            matches!(tracked.state, TrackState::Started | TrackState::Tracked),
            "frame {i}: {:?}",
            tracked.state
        );
        let error = error_m(&pair.world_from_cam(&tracked).unwrap(), i);
        assert!(error < 0.06, "frame {i} is {error} m off");
        assert_eq!(pair.mapper.world().map.check(), Ok(()));
    }
    let map = &pair.mapper.world().map;
    assert!((4..30).contains(&map.n_keyframes()), "{} keyframes", map.n_keyframes());
    assert!(map.n_points() > 300, "{} points", map.n_points());
}

#[test]
fn the_same_frames_give_the_same_bits() {
    let world = World::corridor(40.0, 0.4);
    let run = || {
        let mut pair = Pair::new(&params());
        let poses: Vec<SE3> = (0..25)
            .map(|i| {
                let tracked = pair.step(&world.frame(i, &slalom(i)));
                pair.world_from_cam(&tracked).unwrap()
            })
            .collect();
        (poses, pair.mapper.world().map.digest())
    };
    let (poses_a, map_a) = run();
    let (poses_b, map_b) = run();
    assert_eq!(poses_a, poses_b);
    assert_eq!(map_a, map_b);
}

#[test]
fn black_frames_are_lost_with_a_reason_and_tracking_recovers() {
    let world = World::corridor(60.0, 0.3);
    let mut pair = Pair::new(&params());
    for i in 0..20 {
        pair.step(&world.frame(i, &slalom(i)));
    }
    for i in 20..23 {
        let tracked = pair.step(&world.black(i));
        let lost = matches!(tracked.state, TrackState::Lost(Lost::TooFewMatches { found: 0, .. }));
        assert!(lost, "{:?}", tracked.state);
        assert!(tracked.keyframe.is_none());
    }
    let tracked = pair.step(&world.frame(23, &slalom(23)));
    assert_eq!(tracked.state, TrackState::Tracked);
    let error = error_m(&pair.world_from_cam(&tracked).unwrap(), 23);
    assert!(error < 0.1, "{error} m off after recovery");
    for i in 24..30 {
        assert_eq!(pair.step(&world.frame(i, &slalom(i))).state, TrackState::Tracked);
    }
}

#[test]
fn dropped_frames_do_not_break_the_motion_model() {
    let world = World::corridor(60.0, 0.3);
    let mut pair = Pair::new(&params());
    for i in (0..16).chain(20..30) {
        let tracked = pair.step(&world.frame(i, &slalom(i)));
        assert!(
            matches!(tracked.state, TrackState::Started | TrackState::Tracked),
            "frame {i}: {:?}",
            tracked.state
        );
        assert!(!tracked.stats.without_motion_model || i < 2, "frame {i} needed recovery");
    }
}

#[test]
fn a_frame_without_depth_starts_no_map() {
    let world = World::corridor(40.0, 0.3);
    let mut pair = Pair::new(&params());
    let black = pair.step(&world.black(0));
    assert_eq!(
        black.state,
        TrackState::NotReady(NotReady::TooFewDepths { found: 0, needed: 100, features: 0 })
    );
    let seen: Arc<Frame> = world.frame(1, &slalom(1));
    assert_eq!(pair.step(&seen).state, TrackState::Started);
    assert_eq!(pair.mapper.world().map.n_keyframes(), 1);
    assert_eq!(pair.step(&world.frame(2, &slalom(2))).state, TrackState::Tracked);
}

/// The estimate refers to the first camera only: moving the whole world leaves every relative pose as it was.
#[test]
fn the_world_may_be_moved() {
    let world = World::corridor(30.0, 0.0);
    let drive = |offset: u32| {
        let mut pair = Pair::new(&params());
        (0..10)
            .map(|i| {
                let tracked = pair.step(&world.frame(i, &slalom(i + offset)));
                pair.world_from_cam(&tracked).unwrap()
            })
            .collect::<Vec<_>>()
    };
    for offset in [0, 3] {
        for (i, estimate) in drive(offset).iter().enumerate() {
            let truth = slalom(offset).inverse() * slalom(i as u32 + offset);
            let error = (estimate.inverse() * truth).log().norm();
            assert!(error < 1e-3, "frame {i} from {offset}: {error}");
        }
    }
}
