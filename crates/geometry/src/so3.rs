//! Rotations of space, with their exponential map and its Jacobians.
//!
//! Formulas: Barfoot, "State Estimation for Robotics", chapter 7 (left perturbations throughout).

use crate::aliases::{Mat3, Quaternion, Vec3};
use crate::product::impl_product;
use crate::series::{c1, c2, c3, half_cotangent};
use crate::svd::RotationSvd;
use std::ops::Mul;

/// A rotation matrix; the private field keeps it orthonormal with determinant one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SO3(Mat3);

impl Default for SO3 {
    fn default() -> Self {
        Self::identity()
    }
}

impl SO3 {
    /// The rotation by nothing.
    #[inline]
    pub fn identity() -> Self {
        Self(Mat3::identity())
    }

    /// The rotation about the axis `phi` by the angle `|phi|` in radians (Rodrigues).
    #[inline]
    pub fn exp(phi: &Vec3) -> Self {
        let x = phi.norm_squared();
        let hat = Self::hat(phi);
        Self(
            Mat3::identity() + c1(x) * hat + c2(x) * (phi * phi.transpose() - Mat3::from_diagonal_element(x)),
        )
    }

    /// The rotation vector (axis times angle in radians), of length at most pi; the inverse of [`SO3::exp`].
    ///
    /// Goes through the quaternion, and so keeps full precision near zero and near pi.
    pub fn log(&self) -> Vec3 {
        let q = self.to_quaternion();
        let (w, v) = if q.w < 0.0 { (-q.w, -q.imag()) } else { (q.w, q.imag()) };
        let sine = v.norm();
        if sine < 1e-9 { v * (2.0 / w) } else { v * (2.0 * sine.atan2(w) / sine) }
    }

    /// The opposite rotation.
    #[inline]
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self(self.0.transpose())
    }

    /// The matrix, whose columns are the axes of the source frame seen from the target frame.
    #[inline]
    pub fn matrix(&self) -> &Mat3 {
        &self.0
    }

    /// Takes a matrix that the caller knows to be a rotation, without looking at it.
    #[inline]
    pub fn from_matrix_unchecked(matrix: Mat3) -> Self {
        Self(matrix)
    }

    /// The rotation nearest to `matrix` in the Frobenius norm, by singular values (Horn, Hilden, Negahdaripour 1988).
    ///
    /// A matrix with numbers that are not finite gives the identity.
    pub fn from_matrix(matrix: &Mat3) -> Self {
        RotationSvd::new(matrix).map_or_else(Self::identity, |svd| Self(svd.u * svd.v.transpose()))
    }

    /// The rotation of a unit quaternion.
    pub fn from_quaternion(quaternion: &Quaternion) -> Self {
        Self(quaternion.to_rotation_matrix().into_inner())
    }

    /// The unit quaternion of this rotation, with a real part that is not negative (Shepperd 1978).
    pub fn to_quaternion(&self) -> Quaternion {
        let r = &self.0;
        let trace = r.trace();
        // The largest of the four squared components decides the branch, so that no division is by a small number.
        let candidates = [trace, r[(0, 0)], r[(1, 1)], r[(2, 2)]];
        let mut largest = 0;
        for i in 1..4 {
            if candidates[i] > candidates[largest] {
                largest = i;
            }
        }
        let (w, v) = if largest == 0 {
            let d = Vec3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
            (1.0 + trace, d)
        } else {
            let i = largest - 1;
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let mut v = Vec3::zeros();
            v[i] = 1.0 + r[(i, i)] - r[(j, j)] - r[(k, k)];
            v[j] = r[(i, j)] + r[(j, i)];
            v[k] = r[(i, k)] + r[(k, i)];
            (r[(k, j)] - r[(j, k)], v)
        };
        let sign = if w < 0.0 { -1.0 } else { 1.0 };
        Quaternion::new_normalize(nalgebra::Quaternion::new(sign * w, sign * v.x, sign * v.y, sign * v.z))
    }

    /// The angle of the rotation in radians, from 0 to pi.
    pub fn angle(&self) -> f64 {
        let q = self.to_quaternion();
        2.0 * q.imag().norm().atan2(q.w.abs())
    }

    /// The cross-product matrix: `hat(a) * b = a x b`.
    #[inline]
    pub fn hat(v: &Vec3) -> Mat3 {
        Mat3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
    }

    /// `J` with `exp(phi + d) = exp(J d) exp(phi)` to first order in `d` (Barfoot 7.77).
    pub fn left_jacobian(phi: &Vec3) -> Mat3 {
        let x = phi.norm_squared();
        let hat = Self::hat(phi);
        Mat3::identity() + c2(x) * hat + c3(x) * hat * hat
    }

    /// The inverse of [`SO3::left_jacobian`], for angles below two pi (Barfoot 7.76).
    pub fn left_jacobian_inverse(phi: &Vec3) -> Mat3 {
        let hat = Self::hat(phi);
        Mat3::identity() - 0.5 * hat + half_cotangent(phi.norm_squared()) * hat * hat
    }

    /// `A` with `g exp(v) g^-1 = exp(A v)`: the rotation matrix itself.
    #[inline]
    pub fn adjoint(&self) -> Mat3 {
        self.0
    }

    /// The nearest exact rotation; takes away the rounding errors of long products.
    #[must_use]
    pub fn orthonormalized(&self) -> Self {
        Self::from_matrix(&self.0)
    }
}

impl_product!(SO3, SO3, SO3, |a, b| SO3(a.0 * b.0));
impl_product!(SO3, Vec3, Vec3, |a, p| a.0 * p);
