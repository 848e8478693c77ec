//! What a pose graph needs to know of its poses: a Lie group with its logarithm and Jacobians.

use std::fmt::Debug;
use std::ops::Mul;

use geometry::{Mat3, Mat6, Mat7, SE3, SO3, Sim3, Vec3, Vec6, Vec7};

use crate::robust::{CHI2_SE3, CHI2_SIM3, CHI2_STEREO};

/// A Lie group of poses. Tangent vectors are in the group's own order; perturbations stand on the left, `exp(v) * pose`.
pub trait PoseGroup: Copy + Debug + PartialEq + Mul<Output = Self> {
    /// Tangent vector: an `SVector` of as many numbers as the group has degrees of freedom.
    type Tangent: Copy + Debug + PartialEq;
    /// Square matrix over tangent vectors.
    type Matrix: Copy + Debug + PartialEq;
    /// Chi-square, 95 %, for the group's degrees of freedom.
    const CHI_SQ_LIMIT: f64;

    /// The element of a tangent vector.
    fn exp(tangent: &Self::Tangent) -> Self;
    /// The inverse of [`PoseGroup::exp`], for rotations by up to pi.
    fn log(&self) -> Self::Tangent;
    /// The inverse element.
    fn inverse(&self) -> Self;
    /// `A` with `g exp(v) g^-1 = exp(A v)`.
    fn adjoint(&self) -> Self::Matrix;
    /// `J` with `log(exp(v) * g) = log(g) + J v` to first order in `v`, where `log(g)` is `tangent`.
    fn left_jacobian_inverse(tangent: &Self::Tangent) -> Self::Matrix;
    /// The same element with an exact rotation.
    fn normalized(&self) -> Self;
    /// Whether all numbers are finite (and a scale is positive).
    fn is_valid(&self) -> bool;
}

impl PoseGroup for SO3 {
    type Tangent = Vec3;
    type Matrix = Mat3;
    const CHI_SQ_LIMIT: f64 = CHI2_STEREO;

    fn exp(tangent: &Vec3) -> Self {
        SO3::exp(tangent)
    }
    fn log(&self) -> Vec3 {
        self.log()
    }
    fn inverse(&self) -> Self {
        self.inverse()
    }
    fn adjoint(&self) -> Mat3 {
        self.adjoint()
    }
    fn left_jacobian_inverse(tangent: &Vec3) -> Mat3 {
        SO3::left_jacobian_inverse(tangent)
    }
    fn normalized(&self) -> Self {
        self.orthonormalized()
    }
    fn is_valid(&self) -> bool {
        self.matrix().iter().all(|v| v.is_finite())
    }
}

impl PoseGroup for SE3 {
    type Tangent = Vec6;
    type Matrix = Mat6;
    const CHI_SQ_LIMIT: f64 = CHI2_SE3;

    fn exp(tangent: &Vec6) -> Self {
        SE3::exp(tangent)
    }
    fn log(&self) -> Vec6 {
        self.log()
    }
    fn inverse(&self) -> Self {
        self.inverse()
    }
    fn adjoint(&self) -> Mat6 {
        self.adjoint()
    }
    fn left_jacobian_inverse(tangent: &Vec6) -> Mat6 {
        SE3::left_jacobian_inverse(tangent)
    }
    fn normalized(&self) -> Self {
        self.normalized()
    }
    fn is_valid(&self) -> bool {
        self.is_finite()
    }
}

impl PoseGroup for Sim3 {
    type Tangent = Vec7;
    type Matrix = Mat7;
    const CHI_SQ_LIMIT: f64 = CHI2_SIM3;

    fn exp(tangent: &Vec7) -> Self {
        Sim3::exp(tangent)
    }
    fn log(&self) -> Vec7 {
        self.log()
    }
    fn inverse(&self) -> Self {
        self.inverse()
    }
    fn adjoint(&self) -> Mat7 {
        self.adjoint()
    }
    fn left_jacobian_inverse(tangent: &Vec7) -> Mat7 {
        sim3_left_jacobian_inverse(tangent)
    }
    fn normalized(&self) -> Self {
        Sim3::new(self.rotation.orthonormalized(), self.translation, self.scale)
    }
    fn is_valid(&self) -> bool {
        self.is_valid()
    }
}

/// Bernoulli's numbers `B_2k / (2k)!` for k = 1 to 7.
const BERNOULLI: [f64; 7] = [
    1.0 / 12.0,
    -1.0 / 720.0,
    1.0 / 30_240.0,
    -1.0 / 1_209_600.0,
    1.0 / 47_900_160.0,
    -691.0 / 1_307_674_368_000.0,
    1.0 / 74_724_249_600.0,
];

/// For small rotations and scales the series `1 - a/2 + sum B_2k/(2k)! a^2k` of the small adjoint `a`; otherwise by inversion.
///
/// The series converges below two pi like `(|a| / 2 pi)^n`; the translation part is nilpotent and does not count. Where even
/// the inversion fails (a rotation by two pi, which a logarithm never is) the identity.
fn sim3_left_jacobian_inverse(tangent: &Vec7) -> Mat7 {
    const SMALL: f64 = 0.4;
    if !(tangent.fixed_rows::<3>(3).norm() < SMALL && tangent[6].abs() < SMALL) {
        return Sim3::left_jacobian_inverse(tangent).unwrap_or_else(Mat7::identity);
    }
    let a = Sim3::small_adjoint(tangent);
    let square = a * a;
    let even = BERNOULLI.iter().rev().fold(Mat7::zeros(), |sum, &b| square * (Mat7::identity() * b + sum));
    Mat7::identity() - 0.5 * a + even
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_of_sim3_equals_the_inverse_matrix() {
        let small = Vec7::from_column_slice(&[3.0, -20.0, 7.0, 0.2, -0.3, 0.1, 0.35]);
        for scale in [1.0, 0.5, 1e-3, 0.0] {
            let tangent = small * scale;
            let exact = Sim3::left_jacobian_inverse(&tangent).unwrap();
            let error = (sim3_left_jacobian_inverse(&tangent) - exact).amax();
            assert!(error < 1e-13 * exact.amax(), "{scale}: {error}");
        }
    }
}
