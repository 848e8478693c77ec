//! Similarities of space: rotation, translation and scale, with their exponential map.
//!
//! Tangent vectors are `[rho; phi; lambda]` with `lambda = ln(scale)`.
//! Formulas: Strasdat, "Local Accuracy and Global Consistency for Efficient Visual SLAM" (2012), section 2.4.

use crate::aliases::{Mat3, Mat4, Mat7, Vec3, Vec7};
use crate::product::impl_product;
use crate::se3::SE3;
use crate::so3::SO3;
use std::ops::Mul;

/// The similarity `x -> s R x + t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sim3 {
    /// The rotation `R`.
    pub rotation: SO3,
    /// The translation `t`, in units of the target frame.
    pub translation: Vec3,
    /// The scale `s > 0`: length in the target frame over length in the source frame.
    pub scale: f64,
}

impl From<SE3> for Sim3 {
    fn from(motion: SE3) -> Self {
        Self::new(motion.rotation, motion.translation, 1.0)
    }
}

impl Sim3 {
    /// The similarity with these parts; `scale` must be positive.
    #[inline]
    pub fn new(rotation: SO3, translation: Vec3, scale: f64) -> Self {
        Self { rotation, translation, scale }
    }

    /// The similarity that leaves everything in place.
    #[inline]
    pub fn identity() -> Self {
        Self::new(SO3::identity(), Vec3::zeros(), 1.0)
    }

    /// The similarity of the tangent vector `[rho; phi; lambda]`.
    pub fn exp(tangent: &Vec7) -> Self {
        let (rho, phi, lambda) = split(tangent);
        let w = Coefficients::new(phi.norm(), lambda).matrix(&phi);
        Self::new(SO3::exp(&phi), w * rho, lambda.exp())
    }

    /// The tangent vector `[rho; phi; lambda]` with `|phi| <= pi`; the inverse of [`Sim3::exp`].
    pub fn log(&self) -> Vec7 {
        let phi = self.rotation.log();
        let lambda = self.scale.ln();
        let rho =
            Coefficients::new(phi.norm(), lambda).inverse(phi.norm_squared()).matrix(&phi) * self.translation;
        Vec7::from_column_slice(&[rho.x, rho.y, rho.z, phi.x, phi.y, phi.z, lambda])
    }

    /// The opposite similarity.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        let scale = 1.0 / self.scale;
        Self::new(rotation, -scale * (rotation * self.translation), scale)
    }

    /// `A` with `g exp(v) g^-1 = exp(A v)`: `[sR, hat(t) R, -t; 0, R, 0; 0, 0, 1]`.
    pub fn adjoint(&self) -> Mat7 {
        let r = self.rotation.matrix();
        let mut a = Mat7::identity();
        a.fixed_view_mut::<3, 3>(0, 0).copy_from(&(self.scale * r));
        a.fixed_view_mut::<3, 3>(0, 3).copy_from(&(SO3::hat(&self.translation) * r));
        a.fixed_view_mut::<3, 1>(0, 6).copy_from(&-self.translation);
        a.fixed_view_mut::<3, 3>(3, 3).copy_from(r);
        a
    }

    /// `a` with `exp(v) g exp(-v) = g + a(v) g` to first order: the adjoint of the algebra, `adjoint(exp(v)) = e^(a(v))`.
    pub fn small_adjoint(tangent: &Vec7) -> Mat7 {
        let (rho, phi, lambda) = split(tangent);
        let hat = SO3::hat(&phi);
        let mut a = Mat7::zeros();
        a.fixed_view_mut::<3, 3>(0, 0).copy_from(&(hat + Mat3::from_diagonal_element(lambda)));
        a.fixed_view_mut::<3, 3>(0, 3).copy_from(&SO3::hat(&rho));
        a.fixed_view_mut::<3, 1>(0, 6).copy_from(&-rho);
        a.fixed_view_mut::<3, 3>(3, 3).copy_from(&hat);
        a
    }

    /// `J` with `exp(v + d) = exp(J d) exp(v)` to first order in `d`: the series `sum_k a^k / (k + 1)!` of the small adjoint.
    pub fn left_jacobian(tangent: &Vec7) -> Mat7 {
        const TERMS: usize = 32;
        let a = Self::small_adjoint(tangent);
        // Horner's scheme from the last term on.
        (2..TERMS).rev().fold(Mat7::identity(), |sum, k| Mat7::identity() + a * sum / k as f64)
    }

    /// The inverse of [`Sim3::left_jacobian`]; `None` where that is singular (angles of two pi).
    pub fn left_jacobian_inverse(tangent: &Vec7) -> Option<Mat7> {
        Self::left_jacobian(tangent).try_inverse()
    }

    /// The homogeneous matrix `[sR t; 0 1]`.
    pub fn matrix(&self) -> Mat4 {
        let mut m = SE3::new(self.rotation, self.translation).matrix();
        m.fixed_view_mut::<3, 3>(0, 0).scale_mut(self.scale);
        m
    }

    /// Whether all numbers are finite and the scale is positive.
    pub fn is_valid(&self) -> bool {
        SE3::new(self.rotation, self.translation).is_finite() && self.scale.is_finite() && self.scale > 0.0
    }
}

impl_product!(Sim3, Sim3, Sim3, |a, b| Sim3::new(
    a.rotation * b.rotation,
    a.scale * (a.rotation.matrix() * b.translation) + a.translation,
    a.scale * b.scale
));
impl_product!(Sim3, Vec3, Vec3, |a, p| a.scale * (a.rotation.matrix() * p) + a.translation);

fn split(tangent: &Vec7) -> (Vec3, Vec3, f64) {
    (tangent.fixed_rows::<3>(0).into_owned(), tangent.fixed_rows::<3>(3).into_owned(), tangent[6])
}

/// The matrix `a I + b hat(phi) + c hat(phi)^2`.
struct Coefficients {
    a: f64,
    b: f64,
    c: f64,
}

impl Coefficients {
    /// Coefficients of `W = integral of exp(u (hat(phi) + lambda I)) du` over `0 <= u <= 1`, so that `t = W rho`.
    ///
    /// `a`, `b`, `c` are the integrals of `e^(u lambda)` times `1`, `sin(u angle)/angle`, `(1 - cos(u angle))/angle^2`.
    fn new(angle: f64, lambda: f64) -> Self {
        let a = if lambda.abs() < 1e-8 { 1.0 + 0.5 * lambda } else { lambda.exp_m1() / lambda };
        if angle < 0.5 {
            return Self::small_angle(angle, lambda, a);
        }
        let (sin, cos) = angle.sin_cos();
        let (scale, z_sq) = (lambda.exp(), lambda * lambda + angle * angle);
        let sine_integral = (scale * (lambda * sin - angle * cos) + angle) / z_sq;
        let cosine_integral = (scale * (lambda * cos + angle * sin) - lambda) / z_sq;
        Self { a, b: sine_integral / angle, c: (a - cosine_integral) / (angle * angle) }
    }

    /// The same by the power series in the angle (exact to rounding for `|lambda| < 16`), whose terms are the moments `m_k = integral of u^k e^(u lambda)`.
    fn small_angle(angle: f64, lambda: f64, a: f64) -> Self {
        const TERMS: usize = 7;
        const START: usize = 64;
        // Backward recurrence m_{k-1} = (e^lambda - lambda m_k) / k: an error at the start shrinks by lambda / k a step.
        let scale = lambda.exp();
        let mut moments = [0.0; 2 * TERMS + 2];
        let mut moment = scale / (START as f64 + 1.0 + lambda);
        for k in (1..=START).rev() {
            moment = (scale - lambda * moment) / k as f64;
            if let Some(slot) = moments.get_mut(k - 1) {
                *slot = moment;
            }
        }
        let (mut b, mut c, mut power) = (0.0, 0.0, 1.0);
        for j in 0..TERMS {
            // power = (-angle^2)^j / (2j + 1)!
            b += power * moments[2 * j + 1];
            c += power * moments[2 * j + 2] / (2 * j + 2) as f64;
            power *= -angle * angle / ((2 * j + 2) * (2 * j + 3)) as f64;
        }
        Self { a, b, c }
    }

    /// Coefficients of the inverse matrix for the squared angle `x`, free of cancellation at zero angle.
    fn inverse(&self, x: f64) -> Self {
        let &Self { a, b, c } = self;
        // On the plane across the axis the matrix acts as the complex number p + i q.
        let p = a - c * x;
        let modulus_sq = p * p + b * b * x;
        Self { a: 1.0 / a, b: -b / modulus_sq, c: (b * b - p * c) / (a * modulus_sq) }
    }

    fn matrix(&self, phi: &Vec3) -> Mat3 {
        let hat = SO3::hat(phi);
        Mat3::from_diagonal_element(self.a) + self.b * hat + self.c * hat * hat
    }
}
