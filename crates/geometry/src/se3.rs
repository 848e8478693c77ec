//! Rigid motions of space, with their exponential map and its Jacobians.
//!
//! Tangent vectors are `[rho; phi]` (translation part first). Formulas: Barfoot, "State Estimation for Robotics", chapter 7.

use crate::aliases::{Mat3, Mat4, Mat6, Vec3, Vec6};
use crate::product::impl_product;
use crate::series::{c3, c4, c5};
use crate::so3::SO3;
use serde::{Deserialize, Serialize};
use std::ops::Mul;

/// The motion `x -> R x + t`; named `a_from_b` when it maps coordinates of frame `b` into frame `a`, in meters.
///
/// Serialized as the twelve numbers of [`SE3::rows_3x4`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 12]", into = "[f64; 12]")]
pub struct SE3 {
    /// The rotation `R`.
    pub rotation: SO3,
    /// The translation `t` in meters: the origin of the source frame seen from the target frame.
    pub translation: Vec3,
}

impl SE3 {
    /// The motion with this rotation and translation.
    #[inline]
    pub fn new(rotation: SO3, translation: Vec3) -> Self {
        Self { rotation, translation }
    }

    /// The motion that leaves everything in place.
    #[inline]
    pub fn identity() -> Self {
        Self::default()
    }

    /// The motion of the tangent vector `[rho; phi]` (Barfoot 7.88).
    #[inline]
    pub fn exp(tangent: &Vec6) -> Self {
        let (rho, phi) = split(tangent);
        Self::new(SO3::exp(&phi), SO3::left_jacobian(&phi) * rho)
    }

    /// The tangent vector `[rho; phi]` with `|phi| <= pi`; the inverse of [`SE3::exp`].
    pub fn log(&self) -> Vec6 {
        let phi = self.rotation.log();
        let rho = SO3::left_jacobian_inverse(&phi) * self.translation;
        join(&rho, &phi)
    }

    /// The opposite motion: `b_from_a` of `a_from_b`.
    #[inline]
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        Self::new(rotation, -(rotation * self.translation))
    }

    /// The origin of the target frame seen from the source frame, `-R^T t`: the camera center of a `cam_from_world`.
    #[inline]
    pub fn center(&self) -> Vec3 {
        -self.rotation.matrix().tr_mul(&self.translation)
    }

    /// `A` with `g exp(v) g^-1 = exp(A v)` (Barfoot 7.45).
    pub fn adjoint(&self) -> Mat6 {
        let r = self.rotation.matrix();
        blocks(r, &(SO3::hat(&self.translation) * r))
    }

    /// The inverse of the `J` with `exp(v + d) = exp(J d) exp(v)` to first order in `d`, for angles below two pi (Barfoot 7.85, 7.95).
    pub fn left_jacobian_inverse(tangent: &Vec6) -> Mat6 {
        let (rho, phi) = split(tangent);
        let inverse = SO3::left_jacobian_inverse(&phi);
        blocks(&inverse, &(-inverse * q_matrix(&rho, &phi) * inverse))
    }

    /// The homogeneous matrix `[R t; 0 1]`.
    pub fn matrix(&self) -> Mat4 {
        let mut m = Mat4::identity();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(self.rotation.matrix());
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.translation);
        m
    }

    /// Reads `[R t]` row by row, as KITTI writes poses; the rotation is made exact (see [`SO3::from_matrix`]).
    pub fn from_rows_3x4(rows: &[f64; 12]) -> Self {
        let m = crate::aliases::Mat3x4::from_row_slice(rows);
        Self::new(SO3::from_matrix(&m.fixed_view::<3, 3>(0, 0).into_owned()), m.column(3).into_owned())
    }

    /// Writes `[R t]` row by row, as KITTI writes poses.
    pub fn rows_3x4(&self) -> [f64; 12] {
        std::array::from_fn(|i| match (i / 4, i % 4) {
            (row, 3) => self.translation[row],
            (row, column) => self.rotation.matrix()[(row, column)],
        })
    }

    /// The same motion with an exact rotation; takes away the rounding errors of long products.
    #[must_use]
    pub fn normalized(&self) -> Self {
        Self::new(self.rotation.orthonormalized(), self.translation)
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.rotation.matrix().iter().chain(self.translation.iter()).all(|v| v.is_finite())
    }
}

impl_product!(SE3, SE3, SE3, |a, b| SE3::new(
    a.rotation * b.rotation,
    a.rotation.matrix() * b.translation + a.translation
));
impl_product!(SE3, Vec3, Vec3, |a, p| a.rotation.matrix() * p + a.translation);

impl From<[f64; 12]> for SE3 {
    fn from(rows: [f64; 12]) -> Self {
        Self::from_rows_3x4(&rows)
    }
}

impl From<SE3> for [f64; 12] {
    fn from(motion: SE3) -> Self {
        motion.rows_3x4()
    }
}

#[inline]
fn split(tangent: &Vec6) -> (Vec3, Vec3) {
    (tangent.fixed_rows::<3>(0).into_owned(), tangent.fixed_rows::<3>(3).into_owned())
}

#[inline]
fn join(rho: &Vec3, phi: &Vec3) -> Vec6 {
    Vec6::new(rho.x, rho.y, rho.z, phi.x, phi.y, phi.z)
}

/// The matrix `[diagonal corner; 0 diagonal]`.
fn blocks(diagonal: &Mat3, corner: &Mat3) -> Mat6 {
    let mut m = Mat6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(diagonal);
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(diagonal);
    m.fixed_view_mut::<3, 3>(0, 3).copy_from(corner);
    m
}

/// The upper right block of the left Jacobian of SE(3) (Barfoot 7.86b), its coefficients as Stumpff functions.
fn q_matrix(rho: &Vec3, phi: &Vec3) -> Mat3 {
    let x = phi.norm_squared();
    let (r, p) = (SO3::hat(rho), SO3::hat(phi));
    let (pr, rp) = (p * r, r * p);
    let prp = pr * p;
    0.5 * r
        + c3(x) * (pr + rp + prp)
        + c4(x) * (p * pr + rp * p - 3.0 * prp)
        + 0.5 * (c4(x) - 3.0 * c5(x)) * (prp * p + p * prp)
}
