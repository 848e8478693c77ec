//! Laws of the three groups: exponential and logarithm, products, adjoints, Jacobians.

use crate::assert_close;
use crate::support::{any_motion, any_rotation_vector, any_vec3, join, numeric_jacobian};
use dsslam_geometry::{Mat3, Mat4, Mat6, Mat7, Quaternion, SE3, SO3, Sim3, Vec3, Vec6, Vec7};
use proptest::prelude::*;
use std::f64::consts::PI;

/// Logarithms of scales of every order of magnitude.
fn any_lambda() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 1e-12..1e-7, -1e-7..-1e-12, -1e-3..1e-3, -0.5..0.5, -3.0..3.0]
}

fn any_tangent7(gap: f64) -> impl Strategy<Value = Vec7> {
    (any_vec3(5.0), any_rotation_vector(gap), any_lambda())
        .prop_map(|(r, p, l)| Vec7::from_column_slice(&[r.x, r.y, r.z, p.x, p.y, p.z, l]))
}

fn any_tangent6(gap: f64) -> impl Strategy<Value = Vec6> {
    (any_vec3(5.0), any_rotation_vector(gap)).prop_map(|(rho, phi)| join(&rho, &phi))
}

fn any_similarity() -> impl Strategy<Value = Sim3> {
    (any_motion(), 0.1..10.0).prop_map(|(g, s)| Sim3::new(g.rotation, g.translation, s))
}

/// The matrix `[hat(phi) + lambda I, rho; 0, 0]`, whose matrix exponential is the group element.
fn generator_matrix(v: &Vec7) -> Mat4 {
    let mut generator = Mat4::zeros();
    let linear = SO3::hat(&v.fixed_rows::<3>(3).into_owned()) + Mat3::from_diagonal_element(v[6]);
    generator.fixed_view_mut::<3, 3>(0, 0).copy_from(&linear);
    generator.fixed_view_mut::<3, 1>(0, 3).copy_from(&v.fixed_rows::<3>(0));
    generator
}

proptest! {
    #[test]
    fn so3_log_inverts_exp(phi in any_rotation_vector(1e-7)) {
        assert_close!(SO3::exp(&phi).log(), phi, 1e-14 + 4e-15 * phi.norm());
    }

    #[test]
    fn so3_exp_inverts_log_up_to_and_at_pi(phi in any_rotation_vector(0.0)) {
        let rotation = SO3::exp(&phi);
        assert_close!(SO3::exp(&rotation.log()).matrix(), rotation.matrix(), 4e-15);
    }

    #[test]
    fn so3_is_a_group_of_rotations(a in any_rotation_vector(0.0), b in any_rotation_vector(0.0), c in any_rotation_vector(0.0)) {
        let (a, b, c) = (SO3::exp(&a), SO3::exp(&b), SO3::exp(&c));
        assert_close!(((a * b) * c).matrix(), (a * (b * c)).matrix(), 4e-15);
        assert_close!((a * a.inverse()).matrix(), Mat3::identity(), 4e-15);
        prop_assert!((a.matrix().determinant() - 1.0).abs() < 4e-15);
    }

    #[test]
    fn so3_agrees_with_quaternions(phi in any_rotation_vector(0.0)) {
        let rotation = SO3::exp(&phi);
        let q = rotation.to_quaternion();
        prop_assert!(q.w >= 0.0);
        assert_close!(SO3::from_quaternion(&q).matrix(), rotation.matrix(), 4e-15);
        assert_close!(SO3::from_quaternion(&Quaternion::from_scaled_axis(phi)).matrix(), rotation.matrix(), 4e-15);
        prop_assert!((rotation.angle() - phi.norm()).abs() < 1e-14);
    }

    #[test]
    fn so3_adjoint_law(phi in any_rotation_vector(0.0), v in any_rotation_vector(0.0)) {
        let g = SO3::exp(&phi);
        assert_close!((g * SO3::exp(&v) * g.inverse()).matrix(), SO3::exp(&(g.adjoint() * v)).matrix(), 1e-14);
    }

    #[test]
    fn so3_left_jacobian_is_the_derivative_of_exp(phi in any_rotation_vector(0.0)) {
        let inverse = SO3::exp(&phi).inverse();
        let numeric = numeric_jacobian(&phi, |x| (SO3::exp(x) * inverse).log());
        assert_close!(SO3::left_jacobian(&phi), numeric, 1e-9);
        assert_close!(SO3::left_jacobian(&phi) * SO3::left_jacobian_inverse(&phi), Mat3::identity(), 1e-14);
    }

    #[test]
    fn projection_on_the_rotations_is_nearest(phi in any_rotation_vector(0.0), noise in prop::array::uniform9(-0.2..0.2)) {
        let matrix = SO3::exp(&phi).matrix() + Mat3::from_row_slice(&noise);
        let nearest = SO3::from_matrix(&matrix);
        prop_assert!((nearest.matrix().determinant() - 1.0).abs() < 1e-14);
        let distance = (matrix - nearest.matrix()).norm();
        for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
            for step in [-1e-3, 1e-3] {
                prop_assert!((matrix - (SO3::exp(&(axis * step)) * nearest).matrix()).norm() >= distance);
            }
        }
    }

    #[test]
    fn se3_log_inverts_exp(v in any_tangent6(1e-6)) {
        assert_close!(SE3::exp(&v).log(), v, 1e-13);
    }

    #[test]
    fn se3_exp_inverts_log(g in any_motion()) {
        assert_close!(SE3::exp(&g.log()).matrix(), g.matrix(), 1e-13);
    }

    #[test]
    fn se3_exp_is_the_matrix_exponential(v in any_tangent6(0.0)) {
        let expected = generator_matrix(&v.push(0.0)).exp();
        assert_close!(SE3::exp(&v).matrix(), expected, 1e-13);
    }

    #[test]
    fn se3_is_a_group_acting_on_points(a in any_motion(), b in any_motion(), c in any_motion(), p in any_vec3(10.0)) {
        assert_close!(((a * b) * c).matrix(), (a * (b * c)).matrix(), 1e-13);
        assert_close!((a * b) * p, a * (b * p), 1e-13);
        assert_close!(a.inverse() * (a * p), p, 1e-13);
        assert_close!(a * a.center(), Vec3::zeros(), 1e-13);
        assert_close!((a * p).push(1.0), a.matrix() * p.push(1.0), 1e-13);
    }

    #[test]
    fn se3_adjoint_law(g in any_motion(), v in any_tangent6(0.0)) {
        let left = g * SE3::exp(&v) * g.inverse();
        assert_close!(left.matrix(), SE3::exp(&(g.adjoint() * v)).matrix(), 1e-12);
    }

    #[test]
    fn se3_left_jacobian_inverse_inverts_the_derivative_of_exp(v in any_tangent6(0.0)) {
        let inverse = SE3::exp(&v).inverse();
        let numeric = numeric_jacobian(&v, |x| (SE3::exp(x) * inverse).log());
        assert_close!(numeric * SE3::left_jacobian_inverse(&v), Mat6::identity(), 2e-8);
    }

    #[test]
    fn se3_rows_are_read_as_written(g in any_motion()) {
        assert_close!(SE3::from_rows_3x4(&g.rows_3x4()).matrix(), g.matrix(), 1e-14);
        prop_assert_eq!(g.rows_3x4()[3], g.translation.x);
        prop_assert_eq!(g.rows_3x4()[4], g.rotation.matrix()[(1, 0)]);
    }

    #[test]
    fn sim3_log_inverts_exp(v in any_tangent7(1e-6)) {
        assert_close!(Sim3::exp(&v).log(), v, 1e-12);
    }

    #[test]
    fn sim3_exp_inverts_log(g in any_similarity()) {
        assert_close!(Sim3::exp(&g.log()).matrix(), g.matrix(), 1e-12);
    }

    #[test]
    fn sim3_exp_is_the_matrix_exponential(v in any_tangent7(0.0)) {
        let expected = generator_matrix(&v).exp();
        assert_close!(Sim3::exp(&v).matrix(), expected, 1e-13 * (1.0 + expected.amax()));
    }

    #[test]
    fn sim3_is_a_group_acting_on_points(a in any_similarity(), b in any_similarity(), c in any_similarity(), p in any_vec3(10.0)) {
        assert_close!(((a * b) * c).matrix(), (a * (b * c)).matrix(), 1e-10);
        assert_close!((a * b) * p, a * (b * p), 1e-11);
        assert_close!(a.inverse() * (a * p), p, 1e-11);
        prop_assert!((((a * p) - (a * Vec3::zeros())).norm() - a.scale * p.norm()).abs() < 1e-11);
    }

    #[test]
    fn sim3_adjoint_law(g in any_similarity(), v in any_tangent7(0.0)) {
        let (left, right) = (g * Sim3::exp(&v) * g.inverse(), Sim3::exp(&(g.adjoint() * v)));
        assert_close!(left.matrix(), right.matrix(), 1e-12 * (1.0 + left.matrix().amax()));
        let (adjoint, series) = (Sim3::exp(&v).adjoint(), Sim3::small_adjoint(&v).exp());
        assert_close!(adjoint, series, 1e-12 * (1.0 + series.amax()));
    }

    #[test]
    fn sim3_left_jacobian_is_the_derivative_of_exp(v in any_tangent7(0.0)) {
        let inverse = Sim3::exp(&v).inverse();
        let analytic = Sim3::left_jacobian(&v);
        let numeric = numeric_jacobian(&v, |x| (Sim3::exp(x) * inverse).log());
        assert_close!(analytic, numeric, 1e-8 * (1.0 + analytic.amax()));
        let unit = analytic * Sim3::left_jacobian_inverse(&v).unwrap();
        assert_close!(unit, Mat7::identity(), 1e-11);
    }

    #[test]
    fn se3_is_embedded_in_sim3(a in any_motion(), b in any_motion(), v in any_tangent6(1e-6)) {
        prop_assert_eq!(Sim3::from(a) * Sim3::from(b), Sim3::from(a * b));
        assert_close!(Sim3::exp(&v.push(0.0)).matrix(), SE3::exp(&v).matrix(), 1e-14);
    }
}

#[test]
fn half_turns_have_a_logarithm_of_length_pi() {
    for axis in [
        Vec3::x(),
        Vec3::y(),
        Vec3::z(),
        Vec3::new(1.0, -2.0, 0.5).normalize(),
        Vec3::new(-1.0, -1.0, 0.0).normalize(),
    ] {
        // The exact matrix of a half turn, 2 a a^T - I.
        let turn = SO3::from_matrix_unchecked(2.0 * axis * axis.transpose() - Mat3::identity());
        let log = turn.log();
        assert!((log.norm() - PI).abs() < 1e-15);
        assert!((log.normalize().dot(&axis).abs() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn known_rotation_turns_x_into_y() {
    let quarter = SO3::exp(&Vec3::new(0.0, 0.0, PI / 2.0));
    assert_close!(quarter * Vec3::x(), Vec3::y(), 1e-15);
    assert_close!(SO3::hat(&Vec3::x()) * Vec3::y(), Vec3::z(), 0.0);
}

#[test]
fn a_thousand_products_stay_a_rotation_after_normalization() {
    let step = SE3::exp(&Vec6::new(0.1, 0.0, 0.3, 0.01, -0.02, 0.003));
    let long = (0..1000).fold(SE3::identity(), |g, _| g * step);
    let normalized = long.normalized();
    let rest = normalized.rotation.matrix().transpose() * normalized.rotation.matrix() - Mat3::identity();
    assert!(rest.amax() < 1e-15);
    assert_close!(normalized.log(), SE3::exp(&(step.log() * 1000.0)).log(), 1e-10);
}

#[test]
fn matrices_that_are_no_rotations_become_one() {
    let mirror = SO3::from_matrix(&Mat3::from_diagonal(&Vec3::new(1.0, 1.0, -1.0)));
    assert!((mirror.matrix().determinant() - 1.0).abs() < 1e-15);
    assert_eq!(SO3::from_matrix(&Mat3::from_element(f64::NAN)), SO3::identity());
    assert!(!SE3::new(SO3::identity(), Vec3::new(0.0, f64::NAN, 0.0)).is_finite());
    assert!(!Sim3::new(SO3::identity(), Vec3::zeros(), 0.0).is_valid());
}

#[test]
fn zero_tangents_give_exact_identities() {
    assert_eq!(SE3::exp(&Vec6::zeros()), SE3::identity());
    assert_eq!(SE3::identity().log(), Vec6::zeros());
    assert_eq!(Sim3::exp(&Vec7::zeros()), Sim3::identity());
    assert_eq!(Sim3::identity().log(), Vec7::zeros());
}
