//! Robust estimation with outliers and weights.

use crate::alignment::AlignmentEstimator;
use crate::assert_close;
use crate::support::{
    CAMERA, generator, motion_error, noise, random_motion, random_pixel, random_vec3, random_visible_point,
};
use dsslam_geometry::{
    Estimator, FundamentalEstimator, PnpEstimator, RansacOptions, SE3, SightedPoints, Sim3,
    SimilarityEstimator, Vec2, Vec3, ransac, sampson_error_sq,
};

/// Matches of one camera; every match whose index is below `n_outliers` is wrong.
struct PnpScene {
    cam_from_world: SE3,
    pixels: Vec<Vec2>,
    points_world: Vec<Vec3>,
    thresholds_sq: Vec<f64>,
}

impl PnpScene {
    fn new(seed: u64, n: usize, n_outliers: usize) -> Self {
        let mut rng = generator(seed);
        let cam_from_world = random_motion(&mut rng, 10.0, 3.0);
        let points_cam: Vec<_> = (0..n).map(|_| random_visible_point(&mut rng)).collect();
        let pixels = points_cam.iter().enumerate().map(|(i, p)| {
            let exact = CAMERA.project(p);
            if i < n_outliers {
                random_pixel(&mut rng)
            } else {
                exact + Vec2::from_fn(|_, _| noise(&mut rng, 0.7))
            }
        });
        let pixels = pixels.collect();
        let points_world = points_cam.iter().map(|p| cam_from_world.inverse() * p).collect();
        Self { cam_from_world, pixels, points_world, thresholds_sq: vec![9.0; n] }
    }

    fn estimator(&self) -> PnpEstimator<'_> {
        PnpEstimator::new(CAMERA, &self.pixels, &self.points_world, &self.thresholds_sq)
    }
}

fn options(seed: u64, sample_size: usize) -> RansacOptions {
    RansacOptions { sample_size, max_iterations: 20_000, confidence: 0.999, seed }
}

#[test]
fn pose_survives_one_half_outliers() {
    for seed in 0..20 {
        let scene = PnpScene::new(seed, 200, 100);
        let found = ransac(&scene.estimator(), None, &options(seed, 3)).unwrap();
        let (angle, distance) = motion_error(&found.model, &scene.cam_from_world);
        // 100 matches of 0.7 px at a focal length of 718 px and depths of 2 to 30 m.
        assert!(angle < 2e-3 && distance < 2e-2, "seed {seed}: {angle} {distance}");
        let n_true = found.inliers.iter().filter(|&&i| i >= 100).count();
        assert!(n_true >= 98 && found.inliers.len() - n_true <= 3, "seed {seed}: {:?}", found.inliers);
        assert!(found.inliers.is_sorted());
        assert!(found.iterations < 1000);
    }
}

#[test]
fn fundamental_matrix_survives_one_half_outliers() {
    let mut rng = generator(3);
    let b_from_a = random_motion(&mut rng, 1.0, 0.1);
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for i in 0..300 {
        let point = random_visible_point(&mut rng);
        a.push(CAMERA.project(&point));
        b.push(if i % 2 == 0 { random_pixel(&mut rng) } else { CAMERA.project(&(b_from_a * point)) });
    }
    let estimator = FundamentalEstimator::new(&a, &b, 1.0);
    let found = ransac(&estimator, None, &options(0, FundamentalEstimator::SAMPLE_SIZE)).unwrap();
    let missed = (1..300).step_by(2).filter(|i| !found.inliers.contains(i)).count();
    assert_eq!(missed, 0);
    assert!(sampson_error_sq(&found.model, &a[1], &b[1]) < 0.1);
}

#[test]
fn point_sets_survive_one_half_outliers() {
    let mut rng = generator(4);
    let motion = random_motion(&mut rng, 20.0, 3.0);
    for scale in [1.0, 2.5] {
        let truth = Sim3::new(motion.rotation, motion.translation, scale);
        let src: Vec<_> = (0..100).map(|_| random_vec3(&mut rng, 10.0)).collect();
        let wrong = |i: usize| if i < 50 { 20.0 } else { 0.01 };
        let dst: Vec<_> = (0..100).map(|i| truth * src[i] + random_vec3(&mut rng, wrong(i))).collect();
        let estimator = AlignmentEstimator::new(&src, &dst, scale != 1.0, 0.05);
        let found = ransac(&estimator, None, &options(1, AlignmentEstimator::SAMPLE_SIZE)).unwrap();
        assert_close!(found.model.matrix(), truth.matrix(), 0.02);
        assert!((50..100).all(|i| found.inliers.contains(&i)));
    }
}

#[test]
fn similarity_of_two_cameras_survives_one_half_outliers() {
    let mut rng = generator(5);
    let motion = random_motion(&mut rng, 1.0, 0.2);
    let truth = Sim3::new(motion.rotation, motion.translation, 1.7);
    let in_b: Vec<_> = (0..100).map(|_| random_visible_point(&mut rng)).collect();
    let mut in_a: Vec<_> = in_b.iter().map(|p| truth * p).collect();
    let see = |points: &[Vec3]| -> Vec<Vec2> { points.iter().map(|p| CAMERA.project(p)).collect() };
    in_a[..50].reverse();
    let (pixels_a, pixels_b, thresholds) = (see(&in_a), see(&in_b), vec![9.21; 100]);
    let sighted =
        |points_cam, pixels| SightedPoints { camera: CAMERA, points_cam, pixels, thresholds_sq: &thresholds };
    let estimator = SimilarityEstimator::new(sighted(&in_a, &pixels_a), sighted(&in_b, &pixels_b), true);
    let found = ransac(&estimator, None, &options(1, SimilarityEstimator::SAMPLE_SIZE)).unwrap();
    assert_close!(found.model.matrix(), truth.matrix(), 1e-6);
    assert!(found.inliers.len() >= 50 && found.inliers.len() < 60);
}

#[test]
fn informative_weights_save_samples() {
    let (mut plain, mut weighted, mut misled) = (0, 0, 0);
    for seed in 0..20 {
        let scene = PnpScene::new(seed, 200, 140);
        let weights = |outlier: f64, inlier: f64| -> Vec<f64> {
            (0..200).map(|i| if i < 140 { outlier } else { inlier }).collect()
        };
        let run = |weights: Option<&[f64]>| ransac(&scene.estimator(), weights, &options(seed, 3)).unwrap();
        let found = run(Some(&weights(0.2, 0.9)));
        let (angle, distance) = motion_error(&found.model, &scene.cam_from_world);
        assert!(angle < 3e-3 && distance < 3e-2, "seed {seed}: {angle} {distance}");
        plain += run(None).iterations;
        weighted += found.iterations;
        misled += run(Some(&weights(0.5, 0.4))).iterations;
    }
    // Inlier shares by weight: 0.3, 0.66, 0.26; the needed samples go with the third power.
    assert!(weighted * 4 < plain, "{weighted} {plain}");
    assert!(misled > plain, "{misled} {plain}");
}

#[test]
fn weights_decide_between_two_consistent_groups() {
    let mut rng = generator(6);
    let src: Vec<_> = (0..60).map(|_| random_vec3(&mut rng, 10.0)).collect();
    let (one, other) = (random_motion(&mut rng, 5.0, 2.0), random_motion(&mut rng, 5.0, 2.0));
    // 40 points follow one motion and 20 the other.
    let dst: Vec<_> = src.iter().enumerate().map(|(i, p)| if i < 40 { one * p } else { other * p }).collect();
    let estimator = AlignmentEstimator::new(&src, &dst, false, 0.01);
    let run = |weights: Option<&[f64]>| {
        let model = ransac(&estimator, weights, &options(2, 3)).unwrap().model;
        SE3::new(model.rotation, model.translation)
    };
    let trust: Vec<f64> = (0..60).map(|i| if i < 40 { 0.1 } else { 1.0 }).collect();
    assert!(motion_error(&run(None), &one).0 < 1e-6);
    assert!(motion_error(&run(Some(&trust)), &other).0 < 1e-6);
}

#[test]
fn equal_seeds_give_equal_bits_and_equal_weights_change_nothing() {
    let scene = PnpScene::new(8, 100, 50);
    let run = |seed, weights: Option<&[f64]>| ransac(&scene.estimator(), weights, &options(seed, 3)).unwrap();
    assert_eq!(run(5, None), run(5, None));
    assert_eq!(run(5, None), run(5, Some(&[1.0; 100])));
    assert_ne!(run(5, None).model, run(6, None).model);
}

#[test]
fn moving_the_world_moves_the_pose() {
    let scene = PnpScene::new(9, 100, 50);
    let world_from_moved = random_motion(&mut generator(10), 30.0, 3.0);
    let moved = PnpScene {
        cam_from_world: scene.cam_from_world * world_from_moved,
        pixels: scene.pixels.clone(),
        points_world: scene.points_world.iter().map(|p| world_from_moved.inverse() * p).collect(),
        thresholds_sq: scene.thresholds_sq.clone(),
    };
    let here = ransac(&scene.estimator(), None, &options(3, 3)).unwrap();
    let there = ransac(&moved.estimator(), None, &options(3, 3)).unwrap();
    assert_eq!(here.inliers, there.inliers);
    let (angle, distance) = motion_error(&there.model, &(here.model * world_from_moved));
    assert!(angle < 1e-7 && distance < 1e-6, "{angle:e} {distance:e}");
}

#[test]
fn exact_data_need_one_sample_and_score_their_whole_weight() {
    let mut rng = generator(11);
    let src: Vec<_> = (0..10).map(|_| random_vec3(&mut rng, 10.0)).collect();
    let estimator = AlignmentEstimator::new(&src, &src, true, 1.0);
    let found = ransac(&estimator, Some(&[0.5; 10]), &options(0, 3)).unwrap();
    assert_eq!((found.iterations, found.inliers.len()), (1, 10));
    assert!((found.score - 5.0).abs() < 1e-12);
}

#[test]
fn the_limit_of_samples_holds_without_consensus() {
    let mut rng = generator(12);
    let (src, dst): (Vec<_>, Vec<_>) =
        (0..30).map(|_| (random_vec3(&mut rng, 10.0), random_vec3(&mut rng, 10.0))).unzip();
    let estimator = AlignmentEstimator::new(&src, &dst, false, 1e-6);
    let limit = RansacOptions { max_iterations: 50, ..RansacOptions::default() };
    assert!(ransac(&estimator, None, &limit).is_none());
}

#[test]
fn refitting_never_lowers_the_number_of_true_matches() {
    let scene = PnpScene::new(13, 80, 20);
    let estimator = scene.estimator();
    let inliers: Vec<usize> = (20..80).collect();
    let displaced =
        SE3::exp(&dsslam_geometry::Vec6::new(0.02, -0.01, 0.02, 0.003, 0.002, -0.003)) * scene.cam_from_world;
    let cost = |g: &SE3| -> f64 { inliers.iter().map(|&i| estimator.error_sq(g, i)).sum() };
    let refined = estimator.refit(&displaced, &inliers, &[1.0; 80]).unwrap();
    assert!(cost(&displaced) > 3.0 * cost(&refined));
    assert!(cost(&refined) <= cost(&scene.cam_from_world));
}

#[test]
fn unusable_input_gives_nothing() {
    let scene = PnpScene::new(14, 10, 0);
    let estimator = scene.estimator();
    let run = |weights: Option<&[f64]>, sample_size| ransac(&estimator, weights, &options(0, sample_size));
    assert!(run(None, 11).is_none(), "fewer matches than a sample");
    assert!(run(None, 0).is_none(), "empty sample");
    assert!(run(None, 2).is_none(), "too small for the solver");
    assert!(run(Some(&[1.0; 9]), 3).is_none(), "one weight is missing");
    assert!(run(Some(&[0.0; 10]), 3).is_none(), "no weight");
    assert!(run(Some(&[f64::NAN; 10]), 3).is_none(), "weights that are not numbers");
    assert!(ransac(&PnpEstimator::new(CAMERA, &[], &[], &[]), None, &options(0, 3)).is_none(), "no matches");
}
