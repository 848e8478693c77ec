//! Projection, distortion and stereo.

use crate::assert_close;
use crate::support::{CAMERA, RIG, numeric_jacobian};
use dsslam_geometry::{Distortion, Vec2, Vec3};
use proptest::prelude::*;

/// EuRoC's left camera, a TUM Kinect and a fisheye-like one with strong tangential terms.
const LENSES: [Distortion; 3] = [
    Distortion { k1: -0.283_408_11, k2: 0.073_959_07, p1: 0.000_193_59, p2: 1.761_871_14e-5, k3: 0.0 },
    Distortion { k1: 0.262_383, k2: -0.953_104, p1: -0.005_358, p2: 0.002_628, k3: 1.163_314 },
    Distortion { k1: -0.2, k2: 0.05, p1: 0.01, p2: -0.02, k3: -0.003 },
];

fn any_point() -> impl Strategy<Value = Vec3> {
    (-1.0..1.0, -0.5..0.5, 0.1..80.0).prop_map(|(x, y, z)| Vec3::new(x * z, y * z, z))
}

fn any_normalized() -> impl Strategy<Value = Vec2> {
    (-0.6..0.6, -0.45..0.45).prop_map(|(x, y)| Vec2::new(x, y))
}

proptest! {
    #[test]
    fn unprojection_is_parallel_to_the_point(p in any_point()) {
        let ray = CAMERA.unproject(&CAMERA.project(&p));
        assert_close!(ray * p.z, p, 1e-12);
        let homogeneous = CAMERA.matrix() * p;
        assert_close!(CAMERA.project(&p), homogeneous.xy() / homogeneous.z, 1e-10);
    }

    #[test]
    fn the_projection_jacobian_is_the_derivative(p in any_point()) {
        // Steps are 1e-5 m: relative to the depth, so is the error of the differences.
        let tolerance = 1e-6 * (1.0 + p.z.powi(-4));
        assert_close!(CAMERA.project_jacobian(&p), numeric_jacobian(&p, |x| CAMERA.project(x)), tolerance);
    }

    #[test]
    fn stereo_sees_depth(p in any_point()) {
        let seen = RIG.project(&p);
        let depth = RIG.depth_from_disparity(seen.x - seen.z);
        prop_assert!((depth - p.z).abs() < 1e-10 * p.z * p.z.max(1.0));
        assert_close!(RIG.unproject(seen.x, seen.y, p.z), p, 1e-11);
        prop_assert!((RIG.bf() / p.z - (seen.x - seen.z)).abs() < 1e-9);
        // The right camera is the left one, moved.
        let right = CAMERA.project(&(p - Vec3::new(RIG.baseline_m, 0.0, 0.0)));
        assert_close!(right, Vec2::new(seen.z, seen.y), 1e-9);
    }

    #[test]
    fn undistortion_inverts_distortion(ideal in any_normalized()) {
        for lens in LENSES {
            assert_close!(lens.undistort(&lens.distort(&ideal)), ideal, 1e-13);
            assert_close!(lens.distort(&lens.undistort(&ideal)), ideal, 1e-13);
        }
    }

    #[test]
    fn distortion_jacobian_is_the_derivative(ideal in any_normalized()) {
        for lens in LENSES {
            assert_close!(lens.distort_jacobian(&ideal), numeric_jacobian(&ideal, |x| lens.distort(x)), 1e-9);
        }
    }

    #[test]
    fn halving_the_image_halves_pixel_distances(p in any_point()) {
        let (full, half) = (CAMERA.project(&p), CAMERA.resized([0.5; 2]).project(&p));
        assert_close!(half.add_scalar(0.5) * 2.0, full.add_scalar(0.5), 1e-9);
    }
}

#[test]
fn distortion_has_the_values_of_the_formula() {
    let lens = Distortion { k1: 0.1, k2: 0.01, p1: 0.001, p2: 0.002, k3: 0.0001 };
    // r^2 = 0.25: radial = 1 + 0.025 + 0.000625 + 0.0000015625.
    let radial = 1.025_626_562_5;
    let expected = Vec2::new(
        0.3 * radial + 2.0 * 0.001 * 0.12 + 0.002 * (0.25 + 0.18),
        0.4 * radial + 0.001 * (0.25 + 0.32) + 2.0 * 0.002 * 0.12,
    );
    assert_close!(lens.distort(&Vec2::new(0.3, 0.4)), expected, 1e-16);
}

#[test]
fn no_distortion_is_the_identity() {
    let p = Vec2::new(0.3, -0.7);
    assert!(Distortion::default().is_zero() && !LENSES[0].is_zero());
    assert_eq!(Distortion::default().undistort(&p), p);
    assert_eq!(Distortion::default().distort(&p), p);
}

#[test]
fn points_beyond_the_fold_give_a_finite_answer() {
    // x (1 - 0.5 x^2) never exceeds 0.5443: 0.9 has no source.
    let lens = Distortion { k1: -0.5, ..Distortion::default() };
    let nearest = lens.undistort(&Vec2::new(0.9, 0.0));
    assert!(nearest.iter().all(|v| v.is_finite()));
    assert!((lens.distort(&nearest).x - 0.5443).abs() < 1e-3);
}
