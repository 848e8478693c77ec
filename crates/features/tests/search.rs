//! Grid searches against plain loops over all features.

mod common;

use common::rig;
use dsslam_features::{
    Descriptor, EpipolarRange, Features, Frame, Keypoint, ProjectionQuery, ScaleLevels, search_epipolar,
    search_epipolar_all, search_window, search_windows,
};
use geometry::{SE3, SO3, Vec3};
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// A frame of `n` random features, a few outside of the image, half of them with a right column; few distinct descriptors,
/// so that ties occur.
fn random_frame(n: usize, seed: u64) -> Frame {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut features = Features::default();
    let mut right_u = Vec::new();
    for _ in 0..n {
        let (x, y) = (rng.random_range(-3.0..645.0f32), rng.random_range(-3.0..243.0f32));
        let octave = rng.random_range(0..8);
        features.keypoints.push(Keypoint { x, y, octave, angle_deg: 0.0, response: 10.0 });
        let word = rng.random::<u64>() & 0xf;
        features.descriptors.push(Descriptor([word, 0, word << 40, 0]));
        right_u.push(if rng.random() { x - rng.random_range(1.0..50.0) } else { f32::NAN });
    }
    Frame::new(0, 0.0, rig(), Arc::new(ScaleLevels::new(8, 1.2)), features, right_u)
}

/// Distance and index of a candidate.
type Ranked = (u32, u32);

/// Best and second of the candidates by distance, then index.
fn two_best(mut candidates: Vec<Ranked>) -> [Option<Ranked>; 2] {
    candidates.sort_unstable();
    [candidates.first().copied(), candidates.get(1).copied()]
}

fn as_pairs(found: Option<dsslam_features::WindowMatch>) -> [Option<Ranked>; 2] {
    let pair = |c: dsslam_features::Candidate| (c.distance, c.feature);
    [found.map(|m| pair(m.best)), found.and_then(|m| m.second).map(pair)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn window_search_is_that_of_a_plain_loop(
        seed: u64, x in -50.0f32..700.0, y in -50.0f32..300.0, radius_px in 0.0f32..80.0,
        min_octave in 0u8..8, span in 0u8..3, right in proptest::option::of(0.0f32..640.0),
    ) {
        let frame = random_frame(400, seed);
        let descriptor = Descriptor([5, 0, 3 << 40, 0]);
        let right_u = right.unwrap_or(f32::NAN);
        let max_octave = min_octave + span;
        let query = ProjectionQuery { x, y, right_u, radius_px, min_octave, max_octave, descriptor };
        let free: Vec<bool> = (0..frame.len()).map(|i| i % 7 != 0).collect();
        let near = |i: usize| {
            let k = frame.keypoints[i];
            (k.x - x).abs() <= radius_px && (k.y - y).abs() <= radius_px && (min_octave..=max_octave).contains(&k.octave)
        };
        let right_fits = |i: usize| {
            let u = frame.right_u[i];
            u.is_nan() || right_u.is_nan() || (u - right_u).abs() <= radius_px
        };
        let candidates = (0..frame.len())
            .filter(|&i| near(i) && right_fits(i) && free[i])
            .map(|i| (frame.descriptors[i].distance(&descriptor), i as u32));
        let found = search_window(&frame, &query, |i| free[i]);
        prop_assert_eq!(as_pairs(found), two_best(candidates.collect()));
        prop_assert!(found.is_none_or(|m| m.best.octave == frame.keypoints[m.best.feature as usize].octave));
        prop_assert_eq!(search_windows(&frame, &[query, query], &free), [found, found]);
    }

    #[test]
    fn epipolar_search_is_that_of_a_plain_loop(
        seed: u64,
        turn in prop::array::uniform3(-0.2f64..0.2),
        shift in prop::array::uniform3(-2.0f64..2.0),
        min_depth_m in 0.5f64..5.0,
        far in proptest::option::of(5.0f64..100.0),
    ) {
        let (a, b) = (random_frame(60, seed), random_frame(500, seed ^ 7));
        let b_from_a = SE3::new(SO3::exp(&Vec3::from(turn)), Vec3::from(shift));
        let range = EpipolarRange { min_depth_m, max_depth_m: far.unwrap_or(f64::INFINITY), max_distance: 3 };
        let free: Vec<bool> = (0..b.len()).map(|i| i % 5 != 0).collect();
        let all: Vec<u32> = (0..a.len() as u32).collect();
        let found = search_epipolar_all(&a, &all, &b, &b_from_a, &range, &free);
        for (i, found) in found.iter().enumerate() {
            prop_assert_eq!(*found, search_epipolar(&a, i, &b, &b_from_a, &range, |j| free[j]));
            // The segment by many depths: a candidate is near one of its points, or not.
            let Some(segment) = dense_segment(&a, i, &b, &b_from_a, &range) else { continue };
            let mut sure = Vec::new();
            let mut possible = Vec::new();
            for j in (0..b.len()).filter(|&j| free[j] && b.keypoints[j].octave.abs_diff(a.keypoints[i].octave) <= 1) {
                let limit = (3.84 / b.inv_sigma_sq(j)).sqrt();
                let place = b.pixel(j);
                let distance = point_to_polyline(&segment, [place.x, place.y]);
                let candidate = (b.descriptors[j].distance(&a.descriptors[i]), j as u32);
                if distance < limit + 0.05 {
                    possible.push(candidate);
                }
                if distance < limit - 0.05 {
                    sure.push(candidate);
                }
            }
            let [best, _] = as_pairs(*found);
            let [best_sure, _] = two_best(sure);
            if best_sure.is_some_and(|(distance, _)| distance <= 3) {
                prop_assert!(best.is_some() && best <= best_sure, "{best:?} instead of {best_sure:?}");
            }
            prop_assert!(best.is_none_or(|b| possible.contains(&b) && b.0 <= 3));
        }
    }
}

/// The images in `b` of the points of the viewing ray at the ends of the range, clipped in front of `b`.
fn dense_segment(
    a: &Frame,
    i: usize,
    b: &Frame,
    b_from_a: &SE3,
    range: &EpipolarRange,
) -> Option<[[f64; 2]; 2]> {
    let ray = a.rig.stereo.camera.unproject(&a.pixel(i));
    let at = |depth: f64| *b_from_a * (ray * depth);
    let far = range.max_depth_m.min(1e7);
    let steps = 200_000;
    let depth = |k: usize| range.min_depth_m * (far / range.min_depth_m).powf(k as f64 / steps as f64);
    let visible = |k: usize| at(depth(k)).z >= 0.02;
    let first = (0..=steps).find(|&k| visible(k))?;
    let last = (0..=steps).rev().find(|&k| visible(k))?;
    let clipped = first > 0 || last < steps;
    let image = |k: usize| {
        let pixel = b.rig.stereo.camera.project(&at(depth(k)));
        [pixel.x, pixel.y]
    };
    // Where the clipping plane cuts the ray the sampled end is not exact: leave those to the other cases.
    (!clipped).then(|| [image(first), image(last)])
}

fn point_to_polyline(&[start, end]: &[[f64; 2]; 2], point: [f64; 2]) -> f64 {
    let along = [end[0] - start[0], end[1] - start[1]];
    let to = [point[0] - start[0], point[1] - start[1]];
    let length_sq = along[0] * along[0] + along[1] * along[1];
    let t = if length_sq > 0.0 {
        ((along[0] * to[0] + along[1] * to[1]) / length_sq).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (to[0] - t * along[0]).hypot(to[1] - t * along[1])
}

#[test]
fn the_true_match_is_found_along_the_line() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let b_from_a = SE3::new(SO3::exp(&Vec3::new(0.01, -0.05, 0.02)), Vec3::new(-0.4, 0.05, -0.8));
    let camera = rig();
    let (mut in_a, mut in_b) = (Features::default(), Features::default());
    while in_a.keypoints.len() < 300 {
        let point =
            Vec3::new(rng.random_range(-4.0..4.0), rng.random_range(-1.5..1.5), rng.random_range(3.0..30.0));
        let (p, q) =
            (camera.stereo.camera.project(&point), camera.stereo.camera.project(&(b_from_a * point)));
        let seen = |p: geometry::Vec2| p.x > 0.0 && p.x < 640.0 && p.y > 0.0 && p.y < 240.0;
        if seen(p) && seen(q) {
            let descriptor = Descriptor(rng.random());
            for (features, pixel) in [(&mut in_a, p), (&mut in_b, q)] {
                let (x, y) = (pixel.x as f32, pixel.y as f32);
                features.keypoints.push(Keypoint { x, y, octave: 2, angle_deg: 0.0, response: 10.0 });
                features.descriptors.push(descriptor);
            }
        }
    }
    let scales = Arc::new(ScaleLevels::new(8, 1.2));
    let frame = |f: Features| {
        let n = f.keypoints.len();
        Frame::new(0, 0.0, Arc::clone(&camera), Arc::clone(&scales), f, vec![f32::NAN; n])
    };
    let (a, b) = (frame(in_a), frame(in_b));
    let all: Vec<u32> = (0..300).collect();
    let range = EpipolarRange { min_depth_m: 1.0, max_depth_m: f64::INFINITY, max_distance: 50 };
    let found = search_epipolar_all(&a, &all, &b, &b_from_a, &range, &vec![true; 300]);
    for (i, found) in found.iter().enumerate() {
        let found = found.unwrap_or_else(|| panic!("feature {i}"));
        assert_eq!((found.best.feature, found.best.distance), (i as u32, 0));
    }
    // Too near, too far: not on the segment. Behind the camera: nothing.
    let wrong = EpipolarRange { min_depth_m: 0.9, max_depth_m: 1.0, ..range };
    let n = search_epipolar_all(&a, &all, &b, &b_from_a, &wrong, &vec![true; 300]).iter().flatten().count();
    assert!(n < 20, "{n}");
    let behind = SE3::new(SO3::identity(), Vec3::new(0.0, 0.0, -100.0));
    let range = EpipolarRange { max_depth_m: 50.0, ..range };
    assert!(search_epipolar_all(&a, &all, &b, &behind, &range, &vec![true; 300]).iter().all(Option::is_none));
}

#[test]
fn a_frame_without_features_is_searched_in_vain() {
    let frame = random_frame(0, 1);
    assert!(frame.is_empty());
    let descriptor = Descriptor::default();
    let query = ProjectionQuery {
        x: 5.0,
        y: 5.0,
        right_u: f32::NAN,
        radius_px: 1e9,
        min_octave: 0,
        max_octave: 7,
        descriptor,
    };
    assert!(search_window(&frame, &query, |_| true).is_none());
    let nan = ProjectionQuery { x: f32::NAN, ..query };
    assert!(search_window(&random_frame(50, 2), &nan, |_| true).is_none());
}
