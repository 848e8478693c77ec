//! Fundamental and essential matrices.

use crate::assert_close;
use crate::support::{CAMERA, generator, motion_error, noise, random_motion, random_visible_point};
use dsslam_geometry::{
    Mat3, SE3, SO3, Vec2, decompose_essential, essential_from_fundamental, estimate_fundamental,
    sampson_error_sq,
};

struct Pair {
    b_from_a: SE3,
    pixels_a: Vec<Vec2>,
    pixels_b: Vec<Vec2>,
}

fn pair(seed: u64, n: usize, sigma_px: f64) -> Pair {
    let mut rng = generator(seed);
    let b_from_a = random_motion(&mut rng, 1.0, 0.2);
    let mut pair = Pair { b_from_a, pixels_a: Vec::new(), pixels_b: Vec::new() };
    while pair.pixels_a.len() < n {
        let point = random_visible_point(&mut rng);
        if (b_from_a * point).z > 0.5 {
            let mut blurred = |p: Vec2| p + Vec2::from_fn(|_, _| noise(&mut rng, sigma_px));
            pair.pixels_a.push(blurred(CAMERA.project(&point)));
            pair.pixels_b.push(blurred(CAMERA.project(&(b_from_a * point))));
        }
    }
    pair
}

/// The fundamental matrix of two views of the same camera, not normalized.
fn fundamental_of(b_from_a: &SE3) -> Mat3 {
    let essential = SO3::hat(&b_from_a.translation) * b_from_a.rotation.matrix();
    let inverse = CAMERA.matrix().try_inverse().expect("an invertible matrix");
    inverse.transpose() * essential * inverse
}

/// Scaled to norm one, with a definite sign.
fn canonical(f: &Mat3) -> Mat3 {
    let largest = f[f.iamax_full()];
    f * (largest.signum() / f.norm())
}

#[test]
fn exact_pairs_give_the_matrix_of_the_poses() {
    for seed in 0..100 {
        let p = pair(seed, 8 + seed as usize % 30, 0.0);
        let found = estimate_fundamental(&p.pixels_a, &p.pixels_b, None).unwrap();
        let truth = fundamental_of(&p.b_from_a);
        let worst = p
            .pixels_a
            .iter()
            .zip(&p.pixels_b)
            .map(|(a, b)| sampson_error_sq(&found, a, b))
            .fold(0.0, f64::max);
        assert!(worst < 1e-16, "seed {seed}: {worst:e}");
        assert!((canonical(&found) - canonical(&truth)).amax() < 1e-6, "seed {seed}");
        assert!(found.determinant().abs() < 1e-15 && (found.norm() - 1.0).abs() < 1e-14);
    }
}

#[test]
fn swapping_the_images_transposes_the_matrix() {
    let p = pair(1, 40, 0.5);
    let forth = estimate_fundamental(&p.pixels_a, &p.pixels_b, None).unwrap();
    let back = estimate_fundamental(&p.pixels_b, &p.pixels_a, None).unwrap();
    assert_close!(canonical(&back.transpose()), canonical(&forth), 1e-10);
    let (a, b) = (&p.pixels_a[0], &p.pixels_b[0]);
    let (there, here) = (sampson_error_sq(&forth, a, b), sampson_error_sq(&forth.transpose(), b, a));
    assert!((there - here).abs() <= 1e-12 * here);
}

#[test]
fn zero_weights_leave_pairs_out() {
    let mut p = pair(2, 30, 0.0);
    let mut weights = vec![1.0; 30];
    p.pixels_b[3] = Vec2::new(0.0, 0.0);
    weights[3] = 0.0;
    let found = estimate_fundamental(&p.pixels_a, &p.pixels_b, Some(&weights)).unwrap();
    assert!(sampson_error_sq(&found, &p.pixels_a[0], &p.pixels_b[0]) < 1e-12);
    assert!(sampson_error_sq(&found, &p.pixels_a[3], &p.pixels_b[3]) > 1.0);
}

#[test]
fn sampson_distance_is_the_shift_of_a_pair_across_its_lines() {
    let p = pair(3, 20, 0.0);
    let f = fundamental_of(&p.b_from_a);
    for (a, b) in p.pixels_a.iter().zip(&p.pixels_b) {
        // Moving both pixels along the gradient by a total of 0.1 px.
        let line_b = (f * a.push(1.0)).xy();
        let line_a = f.tr_mul(&b.push(1.0)).xy();
        let norm = f64::hypot(line_a.norm(), line_b.norm());
        let shifted = (a + line_a * (0.1 / norm), b + line_b * (0.1 / norm));
        let distance = sampson_error_sq(&f, &shifted.0, &shifted.1).sqrt();
        assert!((distance - 0.1).abs() < 1e-3, "{distance}");
    }
}

#[test]
fn the_pose_is_among_the_four_behind_the_essential_matrix() {
    for seed in 0..50 {
        let p = pair(seed, 40, 0.0);
        let f = estimate_fundamental(&p.pixels_a, &p.pixels_b, None).unwrap();
        let motions = decompose_essential(&essential_from_fundamental(&f, &CAMERA, &CAMERA)).unwrap();
        let truth = SE3::new(p.b_from_a.rotation, p.b_from_a.translation.normalize());
        let errors = motions.map(|motion| motion_error(&motion, &truth));
        assert!(
            errors.iter().any(|(angle, distance)| *angle < 1e-6 && *distance < 1e-5),
            "seed {seed}: {errors:?}"
        );
    }
}

#[test]
fn all_four_motions_have_the_essential_matrix() {
    let b_from_a = random_motion(&mut generator(5), 1.0, 0.5);
    let essential_of = |g: &SE3| SO3::hat(&g.translation) * g.rotation.matrix();
    let essential = essential_of(&b_from_a);
    for motion in decompose_essential(&essential).unwrap() {
        assert!((motion.rotation.matrix().determinant() - 1.0).abs() < 1e-13);
        assert_close!(canonical(&essential_of(&motion)), canonical(&essential), 1e-12);
    }
    assert!(decompose_essential(&Mat3::zeros()).is_none());
    assert!(decompose_essential(&Mat3::from_element(f64::NAN)).is_none());
}

#[test]
fn pairs_that_determine_nothing_are_refused() {
    let p = pair(6, 20, 0.0);
    assert!(estimate_fundamental(&p.pixels_a[..7], &p.pixels_b[..7], None).is_none(), "seven pairs");
    assert!(estimate_fundamental(&p.pixels_a, &p.pixels_b[..19], None).is_none(), "lengths");
    assert!(estimate_fundamental(&p.pixels_a, &p.pixels_a, None).is_none(), "no motion");
    assert!(estimate_fundamental(&[Vec2::zeros(); 9], &p.pixels_b[..9], None).is_none(), "one place");
    let mut broken = p.pixels_a.clone();
    broken[0].x = f64::NAN;
    assert!(estimate_fundamental(&broken, &p.pixels_b, None).is_none(), "not a number");
}
