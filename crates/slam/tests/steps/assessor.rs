//! What tracking says of its frames.

use std::sync::Arc;

use super::super::{TrackState, Tracked, Tracker};
use super::*;
use crate::assess::QualityReason;
use crate::probe::NoProbe;
use crate::scene::{Scene, Shot, at, described, params, shot};
use crate::world::World;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A described map of a wall of `n` landmarks, seen by three keyframes.
fn world(n: usize) -> (Scene, World) {
    let scene = Scene::wall(n);
    let map = scene.map(&[at(0.0, 0.0, 0.0), at(0.3, 0.0, 0.0), at(0.6, 0.0, 0.0)]);
    (scene, described(map))
}

/// A frame of the first `n` landmarks with noise of `sigma_px` in every coordinate.
fn noisy(scene: &Scene, index: u32, x: f64, n: usize, sigma_px: f64) -> Arc<Frame> {
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(index));
    let mut normal = || {
        let u: f64 = 1.0 - random.random::<f64>();
        sigma_px * (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * random.random::<f64>()).cos()
    };
    let mut shots: Vec<Shot> = (0..n).map(shot).collect();
    for shot in &mut shots {
        shot.shift_px = [normal(), normal()];
        shot.right_px = 0.3 * normal();
    }
    scene.frame(index, &at(x, 0.0, 0.0), &shots)
}

fn track(tracker: &mut Tracker, frame: &Arc<Frame>, world: &World) -> Tracked {
    tracker.track(frame, world, false, &mut NoProbe)
}

/// Frames 3 to `last`, 5 cm apart, each of `n` landmarks.
fn drive(n: usize, last: u32, sigma_px: f64) -> Vec<Tracked> {
    let (scene, world) = world(n.max(120));
    let mut tracker = Tracker::new(params());
    let frame = |k: u32| noisy(&scene, k, 0.05 * f64::from(k), n, sigma_px);
    (3..=last).map(|k| track(&mut tracker, &frame(k), &world)).collect()
}

fn covariance(tracked: &Tracked) -> geometry::Mat6 {
    tracked.assessment.covariance.unwrap().in_camera()
}

#[test]
fn every_tracked_frame_has_a_covariance_that_grows_with_the_noise() {
    let (calm, rough) = (drive(120, 20, 0.2), drive(120, 20, 0.6));
    assert!(calm.iter().chain(&rough).all(|tracked| tracked.state == TrackState::Tracked));
    for (calm, rough) in calm.iter().zip(&rough) {
        for i in 0..6 {
            assert!(covariance(rough)[(i, i)] > 2.0 * covariance(calm)[(i, i)]);
        }
    }
    let last = rough.last().unwrap();
    // As octave 2 scales it.
    assert!((last.assessment.residual_px.unwrap() - 0.6 / 1.44).abs() < 0.06, "{:?}", last.assessment);
    assert!(last.assessment.quality > 0.99, "{:?}", last.assessment);
}

/// The motion over ten frames scatters as its covariance says; the map, which is exact here, adds what it could be off by.
#[test]
fn errors_of_motions_are_within_their_covariance() {
    let (scene, world) = world(120);
    let (mut sum, mut n) = (0.0, 0);
    for seed in 0..12 {
        let mut tracker = Tracker::new(params());
        let mut poses = Vec::new();
        for k in 0..30 {
            let x = 0.05 * f64::from(k);
            let tracked = track(&mut tracker, &noisy(&scene, 3 + k + 100 * seed, x, 120, 0.5), &world);
            let pose = tracked.pose.unwrap().cam_from_world(&world.map).unwrap();
            poses.push((pose, at(x, 0.0, 0.0)));
            if k >= 10 {
                let (past, past_truth) = poses[k as usize - 10];
                let (estimate, truth) = (pose * past.inverse(), poses[k as usize].1 * past_truth.inverse());
                let error = (truth * estimate.inverse()).log();
                sum += error.dot(&covariance(&tracked).cholesky().unwrap().solve(&error));
                n += 1;
            }
        }
    }
    let mean = sum / f64::from(n);
    assert!((2.0..8.0).contains(&mean), "a mean of 6 is exact: {mean}");
}

#[test]
fn reasons_are_those_of_the_frame() {
    let first = &drive(120, 3, 0.2)[0].assessment;
    assert_eq!(first.reasons, [QualityReason::JustRelocalized, QualityReason::WithoutMotionModel]);
    assert!((first.quality - 0.5 * 0.7).abs() < 1e-12, "{first:?}");
    let (scene, world) = world(120);
    let mut tracker = Tracker::new(params());
    let frame = |k: u32| noisy(&scene, k, 0.05 * f64::from(k), if k < 14 { 120 } else { 36 }, 0.2);
    let last = (3..18).map(|k| track(&mut tracker, &frame(k), &world)).last().unwrap();
    assert_eq!(last.state, TrackState::Tracked);
    assert_eq!(last.assessment.reasons.first(), Some(&QualityReason::FewInliers), "{last:?}");
    assert!((last.assessment.quality - last.stats.inliers as f64 / 60.0).abs() < 0.05, "{last:?}");
}

#[test]
fn a_lost_frame_has_none_and_a_loss_is_not_looked_back_over() {
    let (scene, world) = world(120);
    let mut tracker = Tracker::new(params());
    for k in 3..20 {
        track(&mut tracker, &noisy(&scene, k, 0.02 * f64::from(k), 120, 0.3), &world);
    }
    assert_eq!(tracker.assessor.past.len(), COVARIANCE_FRAMES);
    let lost = track(&mut tracker, &noisy(&scene, 20, 0.4, 5, 0.3), &world);
    assert!(matches!(lost.state, TrackState::Lost(_)));
    assert_eq!(lost.assessment, Assessment::default());
    let found = track(&mut tracker, &noisy(&scene, 21, 0.4, 120, 0.3), &world);
    assert_eq!((found.state, tracker.assessor.past.len()), (TrackState::Tracked, 1));
    assert!(found.assessment.covariance.is_some());
}

#[test]
fn points_of_both_frames_are_counted_once() {
    let p = PointId;
    let all = in_either(&[(4, p(7)), (9, p(2))], &[(1, p(2)), (3, p(5))]);
    assert_eq!(all, [(p(7), Some(4), None), (p(2), Some(9), Some(1)), (p(5), None, Some(3))]);
}
