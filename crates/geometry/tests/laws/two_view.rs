//! Two views to motion and points: known answers, refusals with their reasons, outliers, weights, equal bits.

use crate::scene::{CAMERA, RECONSTRUCTION, Scene, pixel, sideways};
use crate::support::{generator, motion_error, random_motion, random_vec3};
use dsslam_geometry::{
    Pinhole, SE3, SO3, TwoView, TwoViewFailure, TwoViewMatches, TwoViewModel, TwoViewOptions,
    TwoViewReconstruction, Vec2, Vec3, angle_between,
};
use rand::Rng;

#[test]
fn a_scene_with_depth_is_reconstructed() {
    for seed in 0..12 {
        let scene = Scene::general(seed, 300);
        let found = scene.reconstruct().unwrap_or_else(|failure| panic!("seed {seed}: {failure}"));
        assert_eq!(found.model, TwoViewModel::Fundamental);
        assert!(found.homography_share < 0.4 && found.n_inliers > 270, "{found:?}");
        let (turn, direction) = scene.errors_deg(&found);
        assert!(turn < 0.15 && direction < 1.0, "seed {seed}: {turn} {direction}");
        assert!((found.second_from_first.translation.norm() - 1.0).abs() < 1e-12);
        assert!(found.n_points > 280 && found.second_share < 0.7, "seed {seed}: {found:?}");
        assert!(scene.median_point_error(&found, 0) < 0.02, "seed {seed}");
        assert!(found.parallax_deg > 5.0 && found.points.len() == 300);
        let baseline = scene.second_from_first.translation.norm();
        assert!((found.median_depth * baseline - 7.5).abs() < 1.0, "seed {seed}: {}", found.median_depth);
    }
}

#[test]
fn a_wall_is_reconstructed() {
    for seed in 0..12 {
        let scene = Scene::planar(seed, 300);
        let found = scene.reconstruct().unwrap_or_else(|failure| panic!("seed {seed}: {failure}"));
        assert!(found.homography_share > 0.45, "seed {seed}: {}", found.homography_share);
        let (turn, direction) = scene.errors_deg(&found);
        assert!(turn < 0.5 && direction < 3.0, "seed {seed}: {turn} {direction}");
        assert!(found.n_points > 270 && scene.median_point_error(&found, 0) < 0.04, "seed {seed}");
    }
}

#[test]
fn four_wrong_matches_in_ten_are_survived() {
    for seed in 0..6 {
        for scene in [Scene::general(seed, 400), Scene::planar(seed, 400)] {
            let scene = scene.with_outliers(seed, 160);
            let found = scene.reconstruct().unwrap_or_else(|failure| panic!("seed {seed}: {failure}"));
            let (turn, direction) = scene.errors_deg(&found);
            assert!(turn < 0.6 && direction < 4.0, "seed {seed}: {turn} {direction}");
            let points = |range: std::ops::Range<usize>| found.points[range].iter().flatten().count();
            // A wrong match along its epipolar line cannot be told from a right one.
            assert!(points(160..400) > 215 && points(0..160) < 12, "seed {seed}");
        }
    }
}

#[test]
fn a_turn_without_a_move_is_refused() {
    for seed in 0..8 {
        let turn = SE3::new(SO3::exp(&random_vec3(&mut generator(seed), 0.12)), Vec3::zeros());
        let scene = Scene::new(seed, 300, turn, |_, share| 3.0 + 9.0 * share);
        match scene.reconstruct() {
            Err(TwoViewFailure::TooLittleParallax { model, found_deg, needed_deg }) => {
                assert!(found_deg < 0.5 && needed_deg == 1.0, "{found_deg} ({model})");
            }
            other => panic!("seed {seed}: {other:?}"),
        }
    }
}

#[test]
fn a_move_that_is_too_short_is_refused_with_its_parallax() {
    for seed in 0..8 {
        // At 8 to 20 units a move of 0.1 makes 0.3 to 0.7 degrees.
        let motion = SE3::new(SO3::exp(&Vec3::new(0.01, 0.02, 0.0)), Vec3::new(-0.1, 0.0, 0.0));
        let scene = Scene::new(seed, 300, motion, |_, share| 8.0 + 12.0 * share);
        match scene.reconstruct() {
            Err(TwoViewFailure::TooLittleParallax { found_deg, needed_deg: 1.0, .. }) => {
                assert!(found_deg < 1.0, "{found_deg}");
            }
            other => panic!("seed {seed}: {other:?}"),
        }
    }
}

/// Half of the matches move in one way, half in another; who has the weight decides.
#[test]
fn weights_decide_between_two_motions() {
    for seed in 0..4 {
        let (mut scene, other) = (Scene::general(seed, 150), Scene::general(seed + 500, 150));
        scene.first.extend(other.first);
        scene.second.extend(other.second);
        let options = TwoViewOptions { min_share: 0.8, ..RECONSTRUCTION.options };
        let lenient = TwoViewReconstruction { options, ..RECONSTRUCTION };
        let mut winner = |light: std::ops::Range<usize>| {
            let mut weights = vec![1.0; 300];
            weights[light].fill(0.05);
            scene.weights = Some(weights);
            scene.reconstruct_with(&lenient, seed).unwrap_or_else(|failure| panic!("seed {seed}: {failure}"))
        };
        let (first, second) = (winner(150..300), winner(0..150));
        let truths = [scene.second_from_first, other.second_from_first];
        for (found, truth) in [(&first, &truths[0]), (&second, &truths[1])] {
            let direction = angle_between(&found.second_from_first.translation, &truth.translation);
            assert!(direction.to_degrees() < 2.5, "seed {seed}: {}", direction.to_degrees());
        }
        let n_points =
            |found: &TwoView, range: std::ops::Range<usize>| found.points[range].iter().flatten().count();
        assert!(n_points(&first, 0..150) > 2 * n_points(&first, 150..300));
        assert!(n_points(&second, 150..300) > 2 * n_points(&second, 0..150));
    }
}

#[test]
fn matches_without_weight_have_no_say_but_get_points() {
    let mut scene = Scene::general(3, 300);
    let whole = scene.reconstruct().expect("a map");
    scene.weights = Some((0..300).map(|i| if i < 250 { 1.0 } else { 0.0 }).collect());
    let found = scene.reconstruct().expect("a map");
    assert!(found.n_points <= 250 && found.n_points > 230);
    assert!(found.points[250..].iter().flatten().count() > 40);
    assert!(whole.n_points > 280);
    scene.weights = Some((0..300).map(|i| if i < 80 { 1.0 } else { 0.0 }).collect());
    assert_eq!(scene.reconstruct(), Err(TwoViewFailure::TooFewMatches { found: 80, needed: 100 }));
}

#[test]
fn equal_seeds_give_equal_bits_on_any_number_of_threads() {
    let scene = Scene::general(4, 300).with_outliers(4, 90);
    let found = scene.reconstruct_with(&RECONSTRUCTION, 11);
    for n_threads in [1, 2, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().expect("threads");
        assert_eq!(pool.install(|| scene.reconstruct_with(&RECONSTRUCTION, 11)), found);
    }
    let other = scene.reconstruct_with(&RECONSTRUCTION, 12).expect("a map");
    let (turn, direction) = scene.errors_deg(&other);
    assert!(turn < 0.3 && direction < 1.5, "another seed, the same answer");
}

#[test]
fn swapping_the_views_inverts_the_motion() {
    let scene = Scene::general(5, 300);
    let there = scene.reconstruct().expect("there");
    let swapped = Scene { first: scene.second.clone(), second: scene.first.clone(), ..scene };
    let back = swapped.reconstruct().expect("back");
    let (turn, distance) = motion_error(&back.second_from_first.inverse(), &there.second_from_first);
    assert!(turn.to_degrees() < 0.05 && distance < 0.01, "{turn} {distance}");
}

/// The stated uncertainty is that of many runs with other noise, and a limit on it is kept.
#[test]
fn the_uncertainty_of_the_direction_is_true() {
    let motion = sideways(20);
    let exact = TwoViewOptions { sigma_px: 0.5, ..RECONSTRUCTION.options };
    let by = TwoViewReconstruction { options: exact, ..RECONSTRUCTION };
    let (mut squares, mut sigmas) = (Vec::new(), Vec::new());
    for seed in 0..40 {
        let scene = Scene::new(seed, 200, motion, |_, share| 3.0 + 9.0 * share);
        let found = scene.reconstruct_with(&by, seed).expect("a map");
        squares.push(scene.errors_deg(&found).1.powi(2));
        sigmas.push(found.direction_sigma_deg);
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    // The error has two axes, of which the stated one is the longer.
    let ratio = mean(&squares).sqrt() / mean(&sigmas);
    assert!((0.75..1.6).contains(&ratio), "{ratio}");
    let strict = TwoViewOptions { max_direction_sigma_deg: 0.9 * sigmas[0], ..exact };
    let by = TwoViewReconstruction { options: strict, ..RECONSTRUCTION };
    let scene = Scene::new(0, 200, motion, |_, share| 3.0 + 9.0 * share);
    match scene.reconstruct_with(&by, 0) {
        Err(TwoViewFailure::Uncertain { found_deg, .. }) => assert_eq!(found_deg, sigmas[0]),
        other => panic!("{other:?}"),
    }
}

#[test]
fn two_solutions_of_a_wall_are_told() {
    // A narrow view and a way between along and across: the other plane is in front of both cameras, too.
    let narrow = Pinhole { fx: 2500.0, fy: 2500.0, ..CAMERA };
    let motion = SE3::new(SO3::identity(), Vec3::new(0.9, 0.0, 1.2));
    let mut rng = generator(6);
    let pair = |_| {
        let place = pixel(&mut rng);
        let point = narrow.unproject(&place) * 5.0;
        (place, narrow.project(&(motion * point)))
    };
    let (first, second): (Vec<Vec2>, Vec<Vec2>) = (0..300).map(pair).unzip();
    let by = TwoViewReconstruction { first: narrow, second: narrow, ..RECONSTRUCTION };
    let outcome = by.reconstruct(&TwoViewMatches { first: &first, second: &second, weights: None }, 1);
    match outcome {
        Err(TwoViewFailure::Ambiguous { share, max_share: 0.8, .. }) => assert!(share > 0.85, "{share}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn matches_that_nothing_explains_are_refused() {
    let mut rng = generator(8);
    let (first, second): (Vec<Vec2>, Vec<Vec2>) =
        (0..200).map(|_| (pixel(&mut rng), pixel(&mut rng))).unzip();
    let matches = TwoViewMatches { first: &first, second: &second, weights: None };
    match RECONSTRUCTION.reconstruct(&matches, 1) {
        Err(TwoViewFailure::TooFewPoints { found, needed, .. }) => assert!(found < needed),
        other => panic!("{other:?}"),
    }
    let same = TwoViewMatches { first: &first, second: &first, weights: None };
    let still = RECONSTRUCTION.reconstruct(&same, 1);
    assert!(
        matches!(still, Err(TwoViewFailure::TooLittleParallax { found_deg, .. }) if found_deg < 1e-3),
        "{still:?}"
    );
    let broken = vec![Vec2::new(f64::NAN, 0.0); 200];
    let broken = TwoViewMatches { first: &broken, second: &broken, weights: None };
    assert_eq!(RECONSTRUCTION.reconstruct(&broken, 1), Err(TwoViewFailure::NoModel { n_matches: 200 }));
    let none = TwoViewMatches { first: &[], second: &[], weights: None };
    assert_eq!(
        RECONSTRUCTION.reconstruct(&none, 1),
        Err(TwoViewFailure::TooFewMatches { found: 0, needed: 100 })
    );
}

#[test]
fn failures_are_sentences_with_numbers() {
    let (model, plane) = (TwoViewModel::Fundamental, TwoViewModel::Homography);
    for (failure, text) in [
        (
            TwoViewFailure::TooFewMatches { found: 80, needed: 100 },
            "too few matches between the two views: 80 of 100",
        ),
        (
            TwoViewFailure::NoModel { n_matches: 120 },
            "neither a homography nor a fundamental matrix explains the 120 matches",
        ),
        (
            TwoViewFailure::TooFewPoints { model, found: 40, needed: 90, n_inliers: 100 },
            "too few matches agree with the motion: 40 of 90 (fundamental matrix, 100 inliers)",
        ),
        (
            TwoViewFailure::TooLittleParallax { model: plane, found_deg: 0.254, needed_deg: 1.0 },
            "too little parallax: 0.25 of 1.00 degrees (homography)",
        ),
        (
            TwoViewFailure::Ambiguous { model: plane, share: 0.874, max_share: 0.8 },
            "two motions explain the views: the second 87 % as well as the first, at most 80 % allowed (homography)",
        ),
        (
            TwoViewFailure::Uncertain { model, found_deg: 4.26, max_deg: 2.0 },
            "the direction of the move is uncertain: by 4.3 degrees, at most 2.0 allowed (fundamental matrix)",
        ),
    ] {
        assert_eq!(failure.to_string(), text);
    }
}

#[test]
fn the_defaults_are_the_ones_tested() {
    assert_eq!(TwoViewOptions::default(), RECONSTRUCTION.options);
}

#[test]
fn scaling_changes_lengths_only() {
    let found = Scene::general(9, 200).reconstruct().expect("a map");
    let scaled = found.scaled(3.0);
    assert_eq!(scaled.median_depth, 3.0 * found.median_depth);
    assert_eq!(scaled.second_from_first.rotation, found.second_from_first.rotation);
    assert!((scaled.second_from_first.translation.norm() - 3.0).abs() < 1e-12);
    for (a, b) in scaled.points.iter().zip(&found.points) {
        assert_eq!(*a, b.map(|point| point * 3.0));
    }
}

/// Whatever the motion, what is accepted is right; and what has much parallax is accepted, but for one pair in a
/// hundred: now and then two motions explain it.
#[test]
fn accepted_maps_are_right() {
    let mut inputs = generator(99);
    let (mut n_wide, mut n_refused) = (0, 0);
    for _ in 0..400 {
        let seed = inputs.random_range(0..100_000);
        let (length, n_outliers) = (inputs.random_range(0.05..2.0), inputs.random_range(0..100));
        let case = format!("seed {seed}, length {length}, {n_outliers} outliers");
        let turn = random_motion(&mut generator(seed), 1.0, 0.15);
        let motion = SE3::new(turn.rotation, turn.translation.normalize() * length);
        let scene =
            Scene::new(seed, 300, motion, |_, share| 4.0 + 10.0 * share).with_outliers(seed, n_outliers);
        n_wide += usize::from(length > 0.6);
        match scene.reconstruct() {
            Ok(found) => {
                let (turn, direction) = scene.errors_deg(&found);
                // Half a pixel is 0.055 degrees: an error of the direction grows as the parallax falls.
                let limit_deg = 30.0 / found.parallax_deg.min(10.0);
                assert!(turn < 1.0 && direction < limit_deg, "{case}: {turn} {direction} {limit_deg}");
                assert!(found.n_points >= 50 && found.parallax_deg >= 1.0, "{case}: {found:?}");
                let positive = |p: &Vec3| p.z > 0.0 && (found.second_from_first * *p).z > 0.0;
                assert!(found.points.iter().flatten().all(positive), "{case}");
            }
            Err(TwoViewFailure::TooLittleParallax { .. }) => {}
            Err(TwoViewFailure::Ambiguous { .. }) if length > 0.6 => n_refused += 1,
            Err(failure) => assert!(length < 0.6, "{case}: {failure}"),
        }
    }
    assert!(n_wide > 200 && n_refused * 100 <= n_wide, "{n_refused} of {n_wide} refused");
}
