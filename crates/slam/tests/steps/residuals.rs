//! Noise is measured as it was made.

use super::*;
use crate::scene::{Scene, Shot, at, params, shot};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::TrackStats;
use geometry::SE3;
use map::{KeyframeId, PointId};

/// Residuals of a frame of 240 landmarks whose features were shifted.
fn of(shift: impl Fn(usize, &mut dyn FnMut() -> f64, &mut Shot)) -> Residuals {
    let scene = Scene::wall(240);
    let mut random = ChaCha8Rng::seed_from_u64(10);
    let mut normal = || {
        let u: f64 = 1.0 - random.random::<f64>();
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * random.random::<f64>()).cos()
    };
    let mut shots: Vec<Shot> = (0..240).map(shot).collect();
    shots.iter_mut().enumerate().for_each(|(i, shot)| shift(i, &mut normal, shot));
    let pose = at(0.1, 0.0, 0.0);
    let local = LocallyTracked {
        cam_from_world: pose,
        reference: KeyframeId(0),
        cam_from_reference: pose,
        matches: (0..240).map(|i| (i, PointId(i))).collect(),
        matched: Vec::new(),
        counts: Vec::new(),
        stats: TrackStats::default(),
    };
    let map = scene.map(&[SE3::identity()]);
    Residuals::of(&scene.frame(1, &pose, &shots), &map, &local, params().noise(), 10.0).unwrap()
}

/// Standard deviation that is expected of a feature of the scene, pixels.
fn expected_px() -> f64 {
    1.2_f64.powi(i32::from(crate::scene::OCTAVE)) * params().camera.feature_sigma_px
}

#[test]
fn pixels_and_disparities_have_noise_of_their_own() {
    let (pixel, disparity) = (0.5 * expected_px(), 0.1 * expected_px());
    let found = of(|_, normal, shot| {
        shot.shift_px = [pixel * normal(), pixel * normal()];
        shot.right_px = disparity * normal();
    });
    // Medians of 480 and 240 values have standard deviations of 5 and 8 %.
    assert!((found.pixel_sq.sqrt() - 0.5).abs() < 0.1, "{found:?}");
    assert!((found.disparity_sq.sqrt() - 0.1).abs() < 0.04, "{found:?}");
    assert!(found.in_common < 1.6, "{found:?}");
    // The wall fills the middle of the image, 8 to 12 m away.
    assert!((6..=12).contains(&found.cells) && (100..140).contains(&found.near), "{found:?}");
    assert!((found.median_depth_m - 10.0).abs() < 0.5, "{found:?}");
}

#[test]
fn one_camera_has_the_noise_of_pixels_alone() {
    let found = of(|_, normal, shot| {
        shot.shift_px = [0.5 * normal(), 0.5 * normal()];
        shot.stereo = false;
    });
    assert_eq!(found.disparity_sq, found.pixel_sq);
}

#[test]
fn errors_that_neighbors_have_in_common_are_found() {
    // The upper landmarks are off to the left, as a rolling shutter does it.
    let landmarks = Scene::wall(240).landmarks;
    let skewed = of(|i, normal, shot| {
        let lean = if landmarks[i].y < 0.0 { -0.5 } else { 0.5 };
        shot.shift_px = [lean + 0.3 * normal(), 0.3 * normal()];
    });
    assert!(skewed.in_common > 3.0, "{skewed:?}");
}

#[test]
fn exact_features_have_the_least_noise_and_few_points_nothing_in_common() {
    let exact = of(|_, _, _| {});
    assert!((exact.pixel_sq.sqrt() - LEAST).abs() < 1e-6 && exact.in_common < 1.6, "{exact:?}");
    assert_eq!(in_common(&[Cell::default(); 12]), 1.0);
    assert_eq!(variance(&mut []), None);
}
