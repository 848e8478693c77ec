//! A ring road of points, driven round: loops, relocalization, sub-maps that are joined, localization in a finished map.

#[allow(dead_code, reason = "each test takes what it needs")]
mod common;

use std::sync::Arc;

use bow::Vocabulary;
use common::{Pair, World};
use dsslam_slam::{
    CameraParams, LoopCloser, LoopOutcome, NoProbe, Params, TrackState, Tracked, adjust_globally,
};
use geometry::{SE3, SO3, Vec3};

const RADIUS_M: f64 = 22.0;
const STEP_M: f64 = 0.8;

fn params() -> Params {
    let mut params = Params::of(CameraParams::stereo(21.0, 10.0));
    params.loops.essential_weight = 60;
    params
}

/// Frames in one round.
fn round() -> u32 {
    (2.0 * std::f64::consts::PI * RADIUS_M / STEP_M).round() as u32
}

/// The `i`-th pose on the ring: the camera looks along the road and turns with it.
fn on_ring(i: u32) -> SE3 {
    let angle = 2.0 * std::f64::consts::PI * f64::from(i) / f64::from(round());
    let center = Vec3::new(RADIUS_M * (1.0 - angle.cos()), 0.0, RADIUS_M * angle.sin());
    SE3::new(SO3::exp(&Vec3::new(0.0, angle, 0.0)), center)
}

/// Tracker, mapper and loop closer taking turns.
struct Trio {
    pair: Pair,
    closer: LoopCloser,
    params: Params,
    closed: Vec<(u32, Box<dsslam_slam::LoopCorrection>)>,
}

impl Trio {
    fn new(params: &Params, world: dsslam_slam::World) -> Self {
        let closer = LoopCloser::new(params.clone());
        Trio { pair: Pair::with_world(params, world), closer, params: params.clone(), closed: Vec::new() }
    }

    fn step(&mut self, frame: &Arc<features::Frame>) -> Tracked {
        let tracked = self.pair.step(frame);
        if tracked.keyframe.is_some() {
            let mapper = &mut self.pair.mapper;
            let id = mapper.world().map.newest_keyframe().expect("a keyframe was inserted");
            if let LoopOutcome::Closed(found) = self.closer.detect(id, mapper.world(), &mut NoProbe) {
                mapper.close_loop(&found, &mut NoProbe).expect("the map takes the loop");
                if let Some(solution) = adjust_globally(mapper.world(), &self.params, &mut NoProbe) {
                    mapper.adopt(&solution).expect("the map takes the solution");
                }
                assert_eq!(mapper.world().map.check(), Ok(()));
                self.closed.push((frame.index, found));
            }
        }
        tracked
    }

    /// Error of the pose of a frame that was just tracked, meters.
    fn error_m(&self, tracked: &Tracked, truth: &SE3) -> f64 {
        (self.pair.world_from_cam(tracked).expect("the frame has a pose").translation - truth.translation)
            .norm()
    }
}

fn empty() -> dsslam_slam::World {
    let vocabulary = Vocabulary::built_in().expect("it is part of the program");
    dsslam_slam::World::new(Some(Arc::new(vocabulary)))
}

fn has_pose(tracked: &Tracked) -> bool {
    matches!(tracked.state, TrackState::Started | TrackState::Tracked)
}

#[test]
fn a_round_trip_closes_and_loses_its_drift() {
    let scene = World::ring(RADIUS_M, 1.2, 40.0);
    // The gap between the two visits of one place, after a round.
    let drive = |params: &Params| {
        let mut trio = Trio::new(params, empty());
        let visits = [25, round() + 25];
        let mut seen = Vec::new();
        for i in 0..=visits[1] {
            let tracked = trio.step(&scene.frame(i, &on_ring(i)));
            assert!(has_pose(&tracked), "frame {i}: {:?}", tracked.state);
            if visits.contains(&i) {
                seen.push(tracked);
            }
        }
        let poses: Vec<SE3> = seen.iter().map(|t| trio.pair.world_from_cam(t).unwrap()).collect();
        (trio, (poses[0].translation - poses[1].translation).norm())
    };
    let (trio, with_loops_m) = drive(&params());
    let mut without = params();
    without.loops.enabled = false;
    let (open, without_loops_m) = drive(&without);
    assert!(open.closed.is_empty());
    assert!(!trio.closed.is_empty(), "no loop in {} frames", round() + 25);
    assert!(with_loops_m < 0.6 * without_loops_m, "{with_loops_m} m with loops, {without_loops_m} m without");

    let world = trio.pair.mapper.world();
    let adjusted = adjust_globally(world, &trio.params, &mut NoProbe).unwrap();
    assert!(adjusted.cost[1] < adjusted.cost[0]);
    let mut mapper = trio.pair.mapper.clone();
    mapper.adopt(&adjusted).unwrap();
    assert_eq!(mapper.world().map.check(), Ok(()));
}

#[test]
fn a_kidnapped_camera_finds_back_by_the_place_index() {
    let scene = World::ring(RADIUS_M, 0.4, 30.0);
    let mut trio = Trio::new(&params(), empty());
    for i in 0..70 {
        assert!(has_pose(&trio.step(&scene.frame(i, &on_ring(i)))));
    }
    for i in 70..75 {
        assert!(matches!(trio.step(&scene.black(i)).state, TrackState::Lost(_)));
    }
    // Back at frame 20's place, far from the last keyframe.
    let tracked = trio.step(&scene.frame(75, &on_ring(20)));
    assert!(tracked.stats.relocalized, "{:?}", tracked.state);
    let error_m = trio.error_m(&tracked, &on_ring(20));
    assert!(error_m < 0.1, "{error_m} m");
    assert_eq!(trio.pair.mapper.world().map.roots().len(), 1);
}

#[test]
fn a_lasting_loss_starts_a_sub_map_that_a_loop_joins() {
    let scene = World::ring(RADIUS_M, 0.4, 30.0);
    let mut trio = Trio::new(&params(), empty());
    let mut index = 0;
    for i in 0..50 {
        assert!(has_pose(&trio.step(&scene.frame(index, &on_ring(i)))));
        index += 1;
    }
    // Carried to the other side: nothing there is known.
    let from = round() / 2;
    let mut lost = 0;
    let mut i = from;
    while !has_pose(&trio.step(&scene.frame(index, &on_ring(i)))) {
        (lost, i, index) = (lost + 1, i + 1, index + 1);
        assert!(lost <= params().camera.max_lost_frames, "still lost");
    }
    assert_eq!(lost, params().camera.max_lost_frames);
    while trio.closed.is_empty() {
        (i, index) = (i + 1, index + 1);
        assert!(has_pose(&trio.step(&scene.frame(index, &on_ring(i)))), "frame {i}");
        assert!(i < round() + 60, "no loop");
        assert_eq!(trio.pair.mapper.world().map.roots().len(), if trio.closed.is_empty() { 2 } else { 1 });
    }
    assert!(trio.closed[0].1.joins_submaps);
    let tracked = trio.step(&scene.frame(index + 1, &on_ring(i + 1)));
    let error_m = trio.error_m(&tracked, &on_ring(i + 1));
    assert!(has_pose(&tracked) && error_m < 0.3, "{error_m} m after the join");
}

#[test]
fn a_finished_map_localizes_and_stays_as_it_is() {
    let scene = World::ring(RADIUS_M, 0.4, 30.0);
    let mut first = Trio::new(&params(), empty());
    for i in 0..60 {
        first.step(&scene.frame(i, &on_ring(i)));
    }
    let map = first.pair.mapper.world().map.clone();
    let world = dsslam_slam::World::from_map(map, Some(Arc::new(Vocabulary::built_in().unwrap())));
    let mut only = params();
    only.tracking.localize_only = true;
    let mut second = Trio::new(&only, world.clone());
    let aside = SE3::new(SO3::identity(), Vec3::new(0.3, 0.0, 0.0));
    for i in 10..50 {
        let truth = on_ring(i) * aside;
        let tracked = second.step(&scene.frame(1000 + i, &truth));
        assert_eq!(tracked.state, TrackState::Tracked, "frame {i}");
        assert_eq!(tracked.stats.relocalized, i == 10);
        let error_m = second.error_m(&tracked, &truth);
        assert!(error_m < 0.15, "frame {i}: {error_m} m");
    }
    assert!(second.pair.mapper.world().map.keyframes().count() == world.map.n_keyframes());
}

#[test]
fn one_camera_starts_from_two_views_and_closes_the_ring_with_its_scale() {
    let mut scene = World::ring(RADIUS_M, 0.5, 40.0);
    scene.stereo = false;
    let mut mono = Params::of(CameraParams::mono(10.0));
    mono.loops.essential_weight = 60;
    let mut trio = Trio::new(&mono, empty());
    let n = round() + 25;
    let mut tracked = Vec::new();
    for i in 0..n {
        tracked.push(trio.step(&scene.frame(i, &on_ring(i))));
    }
    let first = tracked.iter().position(has_pose).expect("the map starts");
    assert!(first <= 10, "started at frame {first}");
    let lost = (first..n as usize).find(|&i| !has_pose(&tracked[i]));
    assert_eq!(lost, None, "{:?}", tracked[lost.unwrap_or(0)].state);
    assert!(!trio.closed.is_empty(), "no loop");
    let centers = |range: std::ops::Range<usize>| -> (Vec<Vec3>, Vec<Vec3>) {
        let estimate = |i: usize| trio.pair.world_from_cam(&tracked[i]).unwrap().translation;
        (range.clone().map(estimate).collect(), range.map(|i| on_ring(i as u32).translation).collect())
    };
    let (estimate, truth) = centers(first + 1..n as usize);
    let aligned = geometry::align_umeyama(&estimate, &truth, None, true).unwrap();
    let worst = estimate.iter().zip(&truth).map(|(e, t)| (aligned * *e - t).norm()).fold(0.0, f64::max);
    println!("worst error {worst:.3} m, loop scale {:.4}", trio.closed[0].1.scale);
    assert!(worst < 0.5, "{worst} m");
}

#[test]
fn a_street_that_repeats_itself_is_no_loop() {
    let scene = World::repeated_corridor(60.0, 3);
    let mut trio = Trio::new(&params(), empty());
    for i in 0..150 {
        let truth = SE3::new(SO3::identity(), Vec3::new(0.0, 0.0, STEP_M * f64::from(i)));
        let tracked = trio.step(&scene.frame(i, &truth));
        assert!(has_pose(&tracked), "frame {i}: {:?}", tracked.state);
    }
    assert!(trio.closed.is_empty(), "{:?}", trio.closed[0].1);
}
