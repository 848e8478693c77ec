//! A field in which two places look alike: a wrong loop is forced through the gate, and what is seen later takes it back.

#[allow(dead_code, reason = "each test takes what it needs")]
mod common;

use std::sync::Arc;

use bow::Vocabulary;
use common::{Pair, World};
use dsslam_slam::{CameraParams, LoopCloser, LoopOutcome, NoProbe, Params, TrackState};
use geometry::{SE3, SO3, Vec3};
use map::Map;

const STEP_M: f64 = 0.8;
/// The second strip, which looks like the first.
const RIGHT_M: f64 = 24.0;
const LENGTH_M: f64 = 80.0;

fn params(gate: f64) -> Params {
    let mut params = Params::of(CameraParams::stereo(21.0, 10.0));
    params.loops.essential_weight = 60;
    params.camera.drift_sigma *= gate;
    params.camera.max_drift *= gate;
    params
}

/// Almost two rounds on an oval between the strips, always looking along z.
fn drive() -> Vec<SE3> {
    let (half_width, half_length) = (0.5 * RIGHT_M, 25.0);
    let mut poses = Vec::new();
    let mut angle: f64 = 0.0;
    while angle < 1.9 * std::f64::consts::TAU {
        let center = Vec3::new(half_width * (1.0 - angle.cos()), 0.0, half_length * (1.0 + angle.sin()));
        poses.push(SE3::new(SO3::identity(), center));
        angle += STEP_M / (half_width * angle.sin()).hypot(half_length * angle.cos());
    }
    poses
}

struct Driven {
    pair: Pair,
    /// Of each loop: frame, how far its two keyframes are from each other in truth, meters, loops taken back by it.
    closed: Vec<(u32, f64, usize)>,
    /// Root mean square error of all keyframes in the map after each frame, meters.
    errors_m: Vec<f64>,
    lost: usize,
}

/// Drives, with the gate opened for the first loop found.
fn run(gate: f64) -> Driven {
    let scene = World::alike_field([RIGHT_M + 16.0, LENGTH_M], RIGHT_M);
    let truth = drive();
    let vocabulary = Vocabulary::built_in().expect("it is part of the program");
    let empty = dsslam_slam::World::new(Some(Arc::new(vocabulary)));
    let mut driven = Driven {
        pair: Pair::with_world(&params(1.0), empty),
        closed: Vec::new(),
        errors_m: Vec::new(),
        lost: 0,
    };
    let mut closer = LoopCloser::new(params(gate));
    for (i, pose) in (0..).zip(&truth) {
        let tracked = driven.pair.step(&scene.frame(i, pose));
        driven.lost += usize::from(!matches!(tracked.state, TrackState::Started | TrackState::Tracked));
        let mapper = &mut driven.pair.mapper;
        if tracked.keyframe.is_some() {
            let id = mapper.world().map.newest_keyframe().expect("a keyframe was inserted");
            if let LoopOutcome::Closed(found) = closer.detect(id, mapper.world(), &mut NoProbe) {
                let frame_of =
                    |k| mapper.world().map.keyframe(k).expect("it is in the map").frame.index as usize;
                let [here, there] = [found.keyframe, found.matched].map(|k| truth[frame_of(k)].translation);
                driven.closed.push((i, (here - there).norm(), found.correction.taken_back.len()));
                mapper.close_loop(&found, &mut NoProbe).expect("the map takes the loop");
                assert_eq!(mapper.world().map.check(), Ok(()));
                if gate != 1.0 {
                    closer = LoopCloser::new(params(1.0));
                }
            }
        }
        let keyframes = mapper.world().map.keyframes();
        let errors = keyframes.map(|k| {
            // The world of the map begins at the first pose.
            let center = truth[0].translation + k.center();
            (center - truth[k.frame.index as usize].translation).norm_squared()
        });
        let errors: Vec<f64> = errors.collect();
        driven.errors_m.push((errors.iter().sum::<f64>() / errors.len() as f64).sqrt());
    }
    driven
}

/// Share of the observations that are 5 pixels or more from where their point is in the map.
fn torn_observations(map: &Map) -> f64 {
    let (mut torn, mut all) = (0.0, 0.0);
    for point in map.points() {
        for seen in point.observations() {
            let keyframe = map.keyframe(seen.keyframe).expect("an observer");
            let uvr = keyframe.frame.rig.stereo.project(&(keyframe.cam_from_world * point.position));
            let [x, y] = keyframe.frame.pixel(seen.feature as usize).into();
            torn += f64::from((uvr.x - x).hypot(uvr.y - y) > 5.0);
            all += 1.0;
        }
    }
    torn / all
}

#[test]
fn a_wrong_loop_is_taken_back_when_the_drive_comes_round() {
    let Driven { closed, errors_m, lost, pair } = run(60.0);
    let [(first, apart_m, 0), (second, beside_m, 1), ref others @ ..] = closed[..] else {
        panic!("{closed:?}")
    };
    let is_right = |loops: &[(u32, f64, usize)]| loops.iter().all(|l| l.1 < 8.0 && l.2 == 0);
    assert!(is_right(others), "{others:?}");
    assert!(apart_m > 20.0 && beside_m < 8.0, "{closed:?}");
    let error_m = |frame: u32| errors_m[frame as usize];
    let [before, bent, after, end] = [first - 1, second - 1, second, errors_m.len() as u32 - 1].map(error_m);
    assert!(before < 0.1 && bent > 5.0, "{before} m before the wrong loop, {bent} m with it");
    assert!(after < 0.2 && end < 0.2, "{after} m once it is taken back, {end} m at the end");
    assert_eq!(lost, 0);
    // No point of one strip is left that also stands for its likeness on the other.
    let torn = torn_observations(&pair.mapper.world().map);
    assert!(torn < 0.01, "{torn} of the observations are not where their point is");

    let right = run(1.0);
    assert!(!right.closed.is_empty() && is_right(&right.closed), "{:?}", right.closed);
}
