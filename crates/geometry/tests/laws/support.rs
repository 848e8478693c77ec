//! Inputs and comparisons shared by the tests.

use dsslam_geometry::{Pinhole, SE3, SO3, StereoRig, Vec2, Vec3, Vec6};
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::PI;

pub(crate) const CAMERA: Pinhole = Pinhole { fx: 718.0, fy: 715.0, cx: 607.0, cy: 185.0 };
pub(crate) const RIG: StereoRig = StereoRig { camera: CAMERA, baseline_m: 0.54 };

/// Asserts that two vectors or matrices agree to `tolerance` in every component.
#[macro_export]
macro_rules! assert_close {
    ($left:expr, $right:expr, $tolerance:expr) => {{
        let (left, right) = (($left).clone_owned(), ($right).clone_owned());
        // `amax` passes over what is not a number.
        assert!(left.iter().chain(right.iter()).all(|v| v.is_finite()), "not finite: {left} {right}");
        let difference = (left - right).amax();
        assert!(difference <= $tolerance, "difference {difference:e} of {left} and {right}");
    }};
}

/// The matrix of central differences of `f` at `x`.
pub(crate) fn numeric_jacobian<const M: usize, const N: usize>(
    x: &SVector<f64, N>,
    f: impl Fn(&SVector<f64, N>) -> SVector<f64, M>,
) -> SMatrix<f64, M, N> {
    const STEP: f64 = 1e-5;
    let column = |i: usize| {
        let mut d = SVector::<f64, N>::zeros();
        d[i] = STEP;
        (f(&(x + d)) - f(&(x - d))) / (2.0 * STEP)
    };
    let columns: [SVector<f64, M>; N] = std::array::from_fn(column);
    SMatrix::from_columns(&columns)
}

pub(crate) fn any_vec3(range: f64) -> impl Strategy<Value = Vec3> {
    [-range..range, -range..range, -range..range].prop_map(Vec3::from)
}

fn any_direction() -> impl Strategy<Value = Vec3> {
    any_vec3(1.0).prop_filter_map("too short", |v| v.try_normalize(0.05))
}

/// Rotation vectors with angles of every order of magnitude, up to `pi - gap`.
pub(crate) fn any_rotation_vector(gap: f64) -> impl Strategy<Value = Vec3> {
    let angle = prop_oneof![Just(0.0), 1e-12..1e-7, 1e-7..1e-3, 1e-3..0.6, 0.6..3.0, (PI - 1e-3)..(PI - gap)];
    (any_direction(), angle).prop_map(|(direction, angle)| direction * angle)
}

pub(crate) fn join(rho: &Vec3, phi: &Vec3) -> Vec6 {
    Vec6::new(rho.x, rho.y, rho.z, phi.x, phi.y, phi.z)
}

pub(crate) fn any_motion() -> impl Strategy<Value = SE3> {
    (any_vec3(20.0), any_rotation_vector(0.0)).prop_map(|(t, phi)| SE3::new(SO3::exp(&phi), t))
}

pub(crate) fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

pub(crate) fn random_vec3(rng: &mut impl Rng, range: f64) -> Vec3 {
    Vec3::from_fn(|_, _| rng.random_range(-range..range))
}

pub(crate) fn random_motion(rng: &mut impl Rng, max_translation: f64, max_angle: f64) -> SE3 {
    let axis = random_vec3(rng, 1.0).normalize();
    SE3::new(SO3::exp(&(axis * rng.random_range(0.0..max_angle))), random_vec3(rng, max_translation))
}

/// Roughly Gaussian with deviation `sigma` (sum of uniform numbers), bounded by `3.5 sigma`.
pub(crate) fn noise(rng: &mut impl Rng, sigma: f64) -> f64 {
    (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>().clamp(-3.5, 3.5) * sigma
}

/// A point that the camera at the origin sees, `z` from 2 to 30 m.
pub(crate) fn random_visible_point(rng: &mut impl Rng) -> Vec3 {
    let pixel = random_pixel(rng);
    CAMERA.unproject(&pixel) * rng.random_range(2.0..30.0)
}

pub(crate) fn random_pixel(rng: &mut impl Rng) -> Vec2 {
    Vec2::new(rng.random_range(0.0..1241.0), rng.random_range(0.0..376.0))
}

/// Angle of the rotation and length of the translation between two motions.
pub(crate) fn motion_error(a: &SE3, b: &SE3) -> (f64, f64) {
    let difference = a * b.inverse();
    (difference.rotation.angle(), (a.center() - b.center()).norm())
}
