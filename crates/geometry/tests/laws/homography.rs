//! Homographies: estimation, transfer, the motions behind them.

use crate::assert_close;
use crate::support::{
    CAMERA, any_rotation_vector, any_vec3, generator, motion_error, noise, random_motion, random_pixel,
    random_vec3,
};
use dsslam_geometry::{
    Homography, HomographyEstimator, Mat3, Pinhole, PlanarMotion, RansacOptions, SE3, SO3, Vec2, Vec3,
    decompose_homography, estimate_homography, homography_of_four, ransac,
};
use proptest::prelude::*;

const OTHER: Pinhole = Pinhole { fx: 500.0, fy: 520.0, cx: 320.0, cy: 240.0 };

/// A plane before the camera, somewhat inclined, and a motion that keeps it in front.
struct Plane {
    b_from_a: SE3,
    normal_a: Vec3,
    distance: f64,
}

impl Plane {
    fn random(seed: u64) -> Self {
        let mut rng = generator(seed);
        let normal_a = (Vec3::z() + random_vec3(&mut rng, 0.4)).normalize();
        Self { b_from_a: random_motion(&mut rng, 0.6, 0.2), normal_a, distance: 4.0 + seed as f64 % 3.0 }
    }

    fn homography(&self) -> Homography {
        of_plane(&CAMERA, &OTHER, &self.b_from_a, &self.normal_a, self.distance).expect("a plane")
    }

    /// Pixels of random points of the plane in both images.
    fn pixels(&self, seed: u64, n: usize) -> (Vec<Vec2>, Vec<Vec2>) {
        let mut rng = generator(seed);
        let pair = |_| {
            let pixel = random_pixel(&mut rng);
            let ray = CAMERA.unproject(&pixel);
            let point = ray * (self.distance / self.normal_a.dot(&ray));
            (pixel, OTHER.project(&(self.b_from_a * point)))
        };
        (0..n).map(pair).unzip()
    }
}

/// The homography that the plane `normal_a . x = distance` induces (Hartley and Zisserman, equation 13.2).
fn of_plane(a: &Pinhole, b: &Pinhole, b_from_a: &SE3, normal_a: &Vec3, distance: f64) -> Option<Homography> {
    let calibrated = b_from_a.rotation.matrix() + b_from_a.translation * normal_a.transpose() / distance;
    Homography::new(&(b.matrix() * calibrated * a.matrix().try_inverse()?))
}

/// Largest difference between two homographies in what they do with an image, pixels.
fn difference_px(a: &Homography, b: &Homography) -> f64 {
    let corners = [(0.0, 0.0), (1240.0, 0.0), (0.0, 375.0), (1240.0, 375.0)].map(|(x, y)| Vec2::new(x, y));
    let place = |h: &Homography, corner: &Vec2| {
        let place = h.matrix() * corner.push(1.0);
        place.xy() / place.z
    };
    corners.iter().map(|corner| (place(a, corner) - place(b, corner)).norm()).fold(0.0, f64::max)
}

#[test]
fn exact_pairs_give_the_homography_of_the_plane() {
    for seed in 0..100 {
        let plane = Plane::random(seed);
        let (a, b) = plane.pixels(seed, 4 + seed as usize % 30);
        let found = estimate_homography(&a, &b, None).expect("a homography");
        let difference = difference_px(&found, &plane.homography());
        // Four pairs may lie close together, which magnifies rounding.
        assert!(difference < 1e-5, "seed {seed}: {difference:e}");
        assert!((found.matrix().norm() - 1.0).abs() < 1e-12 && found.matrix().determinant() > 0.0);
    }
}

#[test]
fn four_pairs_give_what_the_linear_transform_gives() {
    let mut n_found = 0;
    for seed in 0..200 {
        let (a, b) = Plane::random(seed).pixels(seed, 4);
        let four = |pixels: &[Vec2]| [0, 1, 2, 3].map(|i| pixels[i]);
        let Some(found) = homography_of_four(&four(&a), &four(&b)) else { continue };
        let other = estimate_homography(&a, &b, None).expect("a homography");
        assert!(difference_px(&found, &other) < 1e-4, "seed {seed}: {}", difference_px(&found, &other));
        n_found += 1;
    }
    assert!(n_found > 195, "{n_found}");
}

#[test]
fn four_pairs_that_no_camera_sees_are_refused() {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec2::new(x, y));
    assert!(homography_of_four(&square, &square).is_some());
    let [a, b, c, d] = square;
    assert!(homography_of_four(&square, &[a, c, b, d]).is_none(), "a corner turned over");
    assert!(homography_of_four(&square, &[a, b, (a + b) / 2.0, d]).is_none(), "three on a line");
    assert!(homography_of_four(&[a, a, c, d], &square).is_none(), "two in one place");
    assert!(homography_of_four(&square, &[a, b, c, Vec2::new(f64::NAN, 0.0)]).is_none(), "not a number");
    // A mirror image is an orientation that a camera cannot see from the same side; it is a homography all the same.
    let mirrored = homography_of_four(&square, &[b, a, d, c]).expect("a map of the plane");
    let [error_sq, _] = mirrored.transfer_errors_sq(&a, &b);
    assert!(error_sq.is_infinite() || error_sq < 1e-24);
}

#[test]
fn swapping_the_images_inverts() {
    let plane = Plane::random(1);
    let (a, b) = plane.pixels(1, 30);
    let there = estimate_homography(&a, &b, None).expect("there");
    let back = estimate_homography(&b, &a, None).expect("back");
    let forth = Homography::new(&back.matrix().try_inverse().expect("an inverse")).expect("a homography");
    assert!(difference_px(&there, &forth) < 1e-7);
    for (a, b) in a.iter().zip(&b) {
        let [in_b, in_a] = there.transfer_errors_sq(a, &(b + Vec2::new(3.0, -4.0)));
        let [back_in_a, back_in_b] = forth.transfer_errors_sq(a, &(b + Vec2::new(3.0, -4.0)));
        assert!(
            (in_b - 25.0).abs() < 1e-4 && (in_b - back_in_a).abs() < 1e-4 && (in_a - back_in_b).abs() < 1e-4
        );
    }
}

#[test]
fn zero_weights_leave_pairs_out() {
    let plane = Plane::random(2);
    let (a, mut b) = plane.pixels(2, 20);
    let mut weights = vec![1.0; 20];
    b[4] += Vec2::new(80.0, -30.0);
    weights[4] = 0.0;
    let found = estimate_homography(&a, &b, Some(&weights)).expect("a homography");
    assert!(difference_px(&found, &plane.homography()) < 1e-6);
    assert!(difference_px(&estimate_homography(&a, &b, None).expect("another"), &found) > 1.0);
}

#[test]
fn a_third_of_outliers_is_survived() {
    for seed in 0..10 {
        let plane = Plane::random(seed);
        let (mut a, mut b) = plane.pixels(seed, 150);
        let mut rng = generator(seed + 50);
        for i in 0..150 {
            if i < 50 {
                b[i] = random_pixel(&mut rng);
            }
            a[i] += Vec2::from_fn(|_, _| noise(&mut rng, 0.5));
        }
        let estimator = HomographyEstimator::new(&a, &b, 6.0);
        let options =
            RansacOptions { sample_size: HomographyEstimator::SAMPLE_SIZE, seed, ..RansacOptions::default() };
        let found = ransac(&estimator, None, &options).expect("a consensus");
        assert!(difference_px(&found.model, &plane.homography()) < 2.0, "seed {seed}");
        let n_true = found.inliers.iter().filter(|&&i| i >= 50).count();
        assert!(n_true >= 95 && found.inliers.len() - n_true <= 3, "seed {seed}: {:?}", found.inliers);
    }
}

#[test]
fn pairs_that_determine_nothing_are_refused() {
    let (a, b) = Plane::random(3).pixels(3, 8);
    assert!(estimate_homography(&a[..3], &b[..3], None).is_none(), "three pairs");
    assert!(estimate_homography(&a, &b[..7], None).is_none(), "lengths");
    assert!(estimate_homography(&a, &b, Some(&[1.0; 7])).is_none(), "weights");
    assert!(estimate_homography(&[a[0]; 5], &b[..5], None).is_none(), "one place");
    let line: Vec<Vec2> = (0..8).map(|i| Vec2::new(f64::from(i), 2.0 * f64::from(i))).collect();
    assert!(estimate_homography(&line, &line, None).is_none(), "a line");
    assert!(estimate_homography(&a, &line, None).is_none(), "flattened");
    let mut broken = a.clone();
    broken[2].y = f64::NAN;
    assert!(estimate_homography(&broken, &b, None).is_none(), "not a number");
    assert!(Homography::new(&Mat3::zeros()).is_none() && Homography::new(&Mat3::from_element(1.0)).is_none());
    assert!(of_plane(&CAMERA, &CAMERA, &SE3::new(SO3::identity(), -Vec3::z()), &Vec3::z(), 1.0).is_none());
}

#[test]
fn what_comes_to_lie_behind_the_camera_is_not_transferred() {
    // Half a turn about y: the image shows what is behind.
    let behind = SE3::new(SO3::exp(&Vec3::new(0.0, 3.0, 0.0)), Vec3::zeros());
    let turned = of_plane(&CAMERA, &CAMERA, &behind, &Vec3::z(), 1.0).expect("a turn");
    let pixel = Vec2::new(600.0, 180.0);
    assert_eq!(turned.transfer_errors_sq(&pixel, &pixel), [f64::INFINITY; 2]);
}

/// The nearest of the four to the truth: turn, distance of the centers, angle between the normals.
fn nearest(found: &[PlanarMotion; 4], truth: &SE3, normal_a: &Vec3) -> f64 {
    let error = |motion: &PlanarMotion| {
        let (angle, distance) = motion_error(&motion.b_from_a, truth);
        angle.max(distance).max((motion.normal_a - normal_a).norm())
    };
    found.iter().map(error).fold(f64::INFINITY, f64::min)
}

proptest! {
    #[test]
    fn the_motion_is_among_the_four(
        shift in any_vec3(0.8),
        turn in any_rotation_vector(0.0),
        tilt in any_vec3(0.5),
        distance in 0.5..50.0,
    ) {
        let normal_a = (Vec3::z() + tilt).normalize();
        let unit = SE3::new(SO3::exp(&turn), shift);
        // Both cameras on the same side, the second not on the plane; a motion at all.
        prop_assume!(1.0 + normal_a.dot(&(unit.rotation.inverse() * shift)) > 0.1 && shift.norm() > 0.01);
        let b_from_a = SE3::new(unit.rotation, shift * distance);
        let homography = of_plane(&CAMERA, &OTHER, &b_from_a, &normal_a, distance).expect("a plane");
        let found = decompose_homography(&homography, &CAMERA, &OTHER).expect("four motions");
        // The angle between double solutions grows with the root of the rounding.
        prop_assert!(nearest(&found, &unit, &normal_a) < 1e-4);
        for motion in found {
            prop_assert!((motion.normal_a.norm() - 1.0).abs() < 1e-12);
            let again = of_plane(&CAMERA, &OTHER, &motion.b_from_a, &motion.normal_a, 1.0);
            assert_close!(again.expect("a plane").matrix(), homography.matrix(), 1e-9);
        }
    }
}

#[test]
fn moving_straight_at_the_plane_has_one_solution_twice() {
    let b_from_a = SE3::new(SO3::identity(), Vec3::new(0.0, 0.0, -0.25));
    let homography = of_plane(&CAMERA, &CAMERA, &b_from_a, &Vec3::z(), 1.0).expect("a plane");
    let found = decompose_homography(&homography, &CAMERA, &CAMERA).expect("four motions");
    assert!(nearest(&found, &b_from_a, &Vec3::z()) < 1e-7);
    let (angle, distance) = motion_error(&found[0].b_from_a, &found[2].b_from_a);
    assert!(angle.min(distance) < 1e-6, "{found:?}");
}

#[test]
fn a_mere_turn_has_no_plane() {
    for turn in [Vec3::zeros(), Vec3::new(0.1, -0.2, 0.3)] {
        let b_from_a = SE3::new(SO3::exp(&turn), Vec3::zeros());
        let homography = of_plane(&CAMERA, &OTHER, &b_from_a, &Vec3::z(), 1.0).expect("a turn");
        assert_eq!(decompose_homography(&homography, &CAMERA, &OTHER), None);
    }
}
