//! Stereo and depth association against known disparities.

mod common;

use common::{HEIGHT, WIDTH, config, median, render, rig, stereo_pair, texture, with_threads};
use dsslam_features::{DepthConfig, EDGE_REACH_PX, Frame, FrameBuilder, Rig, StereoConfig};
use geometry::{DepthImage, Distortion, GrayImage, Vec2};
use std::sync::Arc;

fn builder(rig: &Arc<Rig>) -> FrameBuilder {
    FrameBuilder::new(Arc::clone(rig), config(), StereoConfig::default(), DepthConfig::default())
}

fn frame(left: &GrayImage, right: &GrayImage) -> Frame {
    builder(&rig()).stereo(0, 0.0, left, right).expect("no selection can fail").0
}

/// Disparities that were found, with their features.
fn disparities(frame: &Frame) -> Vec<(usize, f64)> {
    let disparity = |i: usize| f64::from(frame.keypoints[i].x - frame.right_u[i]);
    (0..frame.len()).filter(|&i| frame.has_depth(i)).map(|i| (i, disparity(i))).collect()
}

/// Median and largest error in pixels of level 0, and the share of features with a disparity.
fn errors(frame: &Frame, truth: impl Fn(f64) -> f64) -> (f64, f64, f64) {
    let found = disparities(frame);
    let error = |&(i, d): &(usize, f64)| (d - truth(f64::from(frame.keypoints[i].y))).abs();
    let errors: Vec<f64> = found.iter().map(error).collect();
    let largest = errors.iter().copied().fold(0.0, f64::max);
    (median(errors), largest, found.len() as f64 / frame.len() as f64)
}

#[test]
fn sub_pixel_disparities_of_upright_planes_are_exact() {
    let mut fractions = [0; 5];
    for step in 0..10 {
        let truth = 21.0 + 0.1 * f64::from(step) + 0.03;
        let (left, right) = stereo_pair(|_| truth);
        let frame = frame(&left, &right);
        let (middle, largest, share) = errors(&frame, |_| truth);
        assert!(middle < 0.03, "median error {middle} px at {truth}");
        assert!(largest < 0.75, "largest error {largest} px at {truth}");
        assert!(share > 0.7, "only {share} of the features at {truth}");
        for (_, d) in disparities(&frame) {
            fractions[((d.fract() * 5.0) as usize).min(4)] += 1;
        }
    }
    // No preference of whole pixels: the true fractions are uniform.
    let total: usize = fractions.iter().sum();
    assert!(fractions.iter().all(|&n| n * 5 > total * 9 / 10 && n * 5 < total * 11 / 10), "{fractions:?}");
}

#[test]
fn the_slope_of_the_ground_does_not_harm() {
    // A third of a pixel per row, as of the ground seen from a car.
    let truth = |y: f64| 12.0 + 0.33 * (y - 20.0);
    let (left, right) = stereo_pair(truth);
    let (middle, largest, share) = errors(&frame(&left, &right), truth);
    assert!(middle < 0.06, "median error {middle} px");
    assert!(largest < 1.5, "largest error {largest} px");
    assert!(share > 0.4, "only {share} of the features");
}

#[test]
fn brightness_and_contrast_of_the_right_camera_may_differ() {
    let truth = 33.4;
    let (left, right) = stereo_pair(|_| truth);
    let dimmed = right.data.iter().map(|&v| (f64::from(v) * 0.9 + 20.0).round().min(255.0) as u8).collect();
    let right = GrayImage::from_vec(WIDTH, HEIGHT, dimmed).unwrap();
    let (middle, largest, share) = errors(&frame(&left, &right), |_| truth);
    assert!(middle < 0.06 && largest < 1.0 && share > 0.6, "{middle} px, {largest} px, {share}");
}

#[test]
fn shifting_the_right_image_shifts_the_disparities() {
    let (left, near) = stereo_pair(|_| 30.3);
    let (_, far) = stereo_pair(|_| 25.3);
    let (near, far) = (frame(&left, &near), frame(&left, &far));
    let both: Vec<f64> = (0..near.len())
        .filter(|&i| near.has_depth(i) && far.has_depth(i))
        .map(|i| f64::from(far.right_u[i] - near.right_u[i]))
        .collect();
    assert!(both.len() > 500);
    assert!(both.iter().all(|d| (d - 5.0).abs() < 0.5));
    assert!((median(both) - 5.0).abs() < 0.01);
}

#[test]
fn mirrored_and_swapped_the_disparities_stay() {
    let truth = |y: f64| 18.6 + 0.1 * (y - 100.0);
    let (left, right) = stereo_pair(truth);
    let mirror = |image: &GrayImage| GrayImage::from_fn(WIDTH, HEIGHT, |x, y| image.at(WIDTH - 1 - x, y));
    let (middle, largest, share) = errors(&frame(&mirror(&right), &mirror(&left)), truth);
    assert!(middle < 0.05 && largest < 1.0 && share > 0.6, "{middle} px, {largest} px, {share}");
}

#[test]
fn swapped_images_match_nothing() {
    let (left, right) = stereo_pair(|_| 40.0);
    let frame = frame(&right, &left);
    let n = disparities(&frame).len();
    assert!(n * 20 < frame.len(), "{n} of {} features have a disparity of the wrong sign", frame.len());
}

#[test]
fn disparities_lie_between_zero_and_the_nearest_depth() {
    let rig = rig();
    for truth in [0.0, 0.3, 95.0, 119.0, 121.0, 150.0] {
        let (left, right) = stereo_pair(|_| truth);
        let settings = StereoConfig { min_depth_m: Some(2.5), ..StereoConfig::default() };
        let mut builder = FrameBuilder::new(Arc::clone(&rig), config(), settings, DepthConfig::default());
        let frame = builder.stereo(0, 0.0, &left, &right).unwrap().0;
        let found = disparities(&frame);
        assert!(found.iter().all(|&(_, d)| d > 0.0 && d < 120.0), "{truth}");
        let n_right = found.iter().filter(|&&(_, d)| (d - truth).abs() < 0.5).count();
        let enough = if truth > 0.0 && truth < 119.0 { n_right * 2 > frame.len() } else { true };
        assert!(enough, "{n_right} of {} at {truth}", frame.len());
        // What is too near is not matched elsewhere instead.
        assert!(found.len() - n_right <= frame.len() / 25, "{} wrong at {truth}", found.len() - n_right);
    }
}

#[test]
fn repetitive_texture_is_refused() {
    // Period 24 px: any disparity fits as well as the next.
    let wave = |x: f64, y: f64| texture(x.rem_euclid(24.0), y);
    let render = |shift: f64| {
        GrayImage::from_fn(WIDTH, HEIGHT, |x, y| wave(x as f64 + shift, y as f64).clamp(0.0, 255.0) as u8)
    };
    let frame = frame(&render(0.0), &render(7.0));
    let n = disparities(&frame).len();
    assert!(frame.len() > 500 && n * 20 < frame.len(), "{n} of {}", frame.len());
}

#[test]
fn same_bits_for_any_number_of_threads_and_any_history() {
    let (left, right) = stereo_pair(|y| 14.0 + 0.1 * y);
    let bits = |frame: &Frame| -> Vec<u32> { frame.right_u.iter().map(|u| u.to_bits()).collect() };
    let reference = with_threads(1, || frame(&left, &right));
    let rig = rig();
    let mut used = builder(&rig);
    used.stereo(0, 0.0, &GrayImage::new(200, 100, 3), &GrayImage::new(200, 100, 4)).unwrap();
    for n in [2, 5] {
        let again = with_threads(n, || used.stereo(1, 0.1, &left, &right).unwrap().0);
        assert_eq!(bits(&again), bits(&reference));
        assert_eq!(again.keypoints, reference.keypoints);
    }
}

#[test]
fn empty_black_and_unequal_images_give_no_depth() {
    let (left, right) = stereo_pair(|_| 10.0);
    let black = GrayImage::new(WIDTH, HEIGHT, 0);
    let none = GrayImage::default();
    let small = GrayImage::new(100, 50, 7);
    for (a, b) in
        [(&none, &none), (&none, &right), (&left, &none), (&black, &black), (&left, &black), (&left, &small)]
    {
        let frame = frame(a, b);
        assert_eq!(frame.n_with_depth(), 0);
        assert_eq!(frame.right_u.len(), frame.len());
        assert!((0..frame.len()).all(|i| frame.unproject(i).is_none()));
    }
}

#[test]
fn depth_and_right_column_agree() {
    let (left, right) = stereo_pair(|_| 24.0);
    let frame = frame(&left, &right);
    for i in (0..frame.len()).filter(|&i| frame.has_depth(i)) {
        let point = frame.unproject(i).unwrap();
        let image = frame.rig.stereo.project(&point);
        let expected = [frame.keypoints[i].x, frame.keypoints[i].y, frame.right_u[i]].map(f64::from);
        assert!(image.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3));
    }
}

#[test]
fn depth_images_give_virtual_right_columns() {
    let mut camera = (*rig()).clone();
    camera.distortion = Distortion { k1: 0.1, k2: -0.05, p1: 0.001, p2: -0.002, k3: 0.0 };
    let camera = Arc::new(camera);
    let gray = render(|x, y| (x, y));
    // Unknown on the left, 2 m in the middle, beyond belief on the right.
    let third = WIDTH / 3;
    let depth = DepthImage::from_fn(WIDTH, HEIGHT, |x, _| [0, 10_000, 65_000][(x / third).min(2)]);
    let settings = DepthConfig { max_depth_m: 10.0, ..DepthConfig::default() };
    let mut builder = FrameBuilder::new(Arc::clone(&camera), config(), StereoConfig::default(), settings);
    let frame = builder.rgbd(3, 1.5, &gray, &depth).unwrap().0;
    let detected = dsslam_features::Extractor::new(config()).extract(&gray).keypoints;
    assert_eq!((frame.index, frame.timestamp_s, frame.len()), (3, 1.5, detected.len()));
    let mut n_known = 0;
    for (i, raw) in detected.iter().enumerate() {
        let ideal = camera.undistort(&Vec2::new(f64::from(raw.x), f64::from(raw.y)));
        assert!((frame.pixel(i) - ideal).norm() < 1e-3, "positions are undistorted");
        let x = raw.x.round() as usize;
        // Corners at an edge of the depth are refused.
        let edge =
            [third, 2 * third].iter().any(|&edge| x + EDGE_REACH_PX >= edge && x < edge + EDGE_REACH_PX);
        let known = x / third == 1 && !(edge && x + EDGE_REACH_PX >= 2 * third);
        assert_eq!(frame.has_depth(i), known, "depth is read where the corner was seen: {raw:?}");
        if known {
            n_known += 1;
            let expected = ideal.x - camera.stereo.bf() / 2.0;
            assert!((f64::from(frame.right_u[i]) - expected).abs() < 1e-2);
            assert!((frame.depth[i] - 2.0).abs() < 1e-4);
        } else {
            assert!(frame.right_u[i].is_nan() && !frame.has_depth(i));
        }
    }
    assert!(n_known > 100);
    // A depth image of another size is read where it exists.
    assert_eq!(builder.rgbd(4, 1.6, &gray, &DepthImage::default()).unwrap().0.n_with_depth(), 0);
}

#[test]
fn a_single_image_has_no_depth() {
    let frame = builder(&rig()).mono(7, 2.5, &render(|x, y| (x, y))).unwrap().0;
    assert!(frame.len() > 500);
    assert_eq!(frame.n_with_depth(), 0);
    assert!(frame.activation.iter().all(|&a| a == 1.0) && frame.activation.len() == frame.len());
}
