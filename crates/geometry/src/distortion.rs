//! Radial and tangential lens distortion as OpenCV defines it (Brown 1966).

use crate::aliases::{Mat2, Vec2};
use crate::polynomial::first_sign_change;
use serde::{Deserialize, Serialize};

/// Coefficients of the distortion of normalized image points `(x, y) = (X / Z, Y / Z)`; all zero means none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distortion {
    /// Radial, second order.
    pub k1: f64,
    /// Radial, fourth order.
    pub k2: f64,
    /// Tangential, along y.
    pub p1: f64,
    /// Tangential, along x.
    pub p2: f64,
    /// Radial, sixth order.
    pub k3: f64,
}

impl Distortion {
    /// Whether the lens does not distort.
    pub fn is_zero(&self) -> bool {
        *self == Self::default()
    }

    /// The distorted place of an ideal normalized point.
    pub fn distort(&self, ideal: &Vec2) -> Vec2 {
        self.bend(ideal, self.factor(ideal.norm_squared()).0)
    }

    /// The derivative of [`Distortion::distort`] by the ideal point (a symmetric 2 by 2 matrix).
    pub fn distort_jacobian(&self, ideal: &Vec2) -> Mat2 {
        self.bend_jacobian(ideal, self.factor(ideal.norm_squared()))
    }

    /// The radial factor and its derivative by the squared radius.
    fn factor(&self, r_sq: f64) -> (f64, f64) {
        let Self { k1, k2, k3, .. } = self;
        (1.0 + r_sq * (k1 + r_sq * (k2 + r_sq * k3)), k1 + r_sq * (2.0 * k2 + r_sq * 3.0 * k3))
    }

    /// The distorted place of a point with this radial factor.
    pub(crate) fn bend(&self, ideal: &Vec2, radial: f64) -> Vec2 {
        let Self { p1, p2, .. } = self;
        let (x, y) = (ideal.x, ideal.y);
        let r_sq = x * x + y * y;
        Vec2::new(
            x * radial + 2.0 * p1 * x * y + p2 * (r_sq + 2.0 * x * x),
            y * radial + p1 * (r_sq + 2.0 * y * y) + 2.0 * p2 * x * y,
        )
    }

    /// The derivative of [`Distortion::bend`] for a radial factor with this derivative by the squared radius.
    pub(crate) fn bend_jacobian(&self, ideal: &Vec2, (radial, slope): (f64, f64)) -> Mat2 {
        let Self { p1, p2, .. } = self;
        let (x, y) = (ideal.x, ideal.y);
        let mixed = 2.0 * slope * x * y + 2.0 * (p1 * x + p2 * y);
        Mat2::new(
            radial + 2.0 * slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x,
            mixed,
            mixed,
            radial + 2.0 * slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x,
        )
    }

    /// The radius of ideal normalized points up to which the radial part grows, so that it can be inverted.
    ///
    /// Beyond it, the image of a point turns back towards the center. At most 1000, where every image has ended.
    pub fn max_radius(&self) -> f64 {
        const END: f64 = 1000.0;
        let derivative = [1.0, 3.0 * self.k1, 5.0 * self.k2, 7.0 * self.k3];
        first_sign_change(&derivative, END * END).map_or(END, f64::sqrt)
    }

    /// The ideal normalized point of a distorted one, by Newton's method with step halving, to rounding precision.
    ///
    /// Beyond the radius where the model folds back there is no inverse; then the closest point reached is returned.
    pub fn undistort(&self, distorted: &Vec2) -> Vec2 {
        if self.is_zero() {
            return *distorted;
        }
        invert(distorted, |ideal| self.distort(ideal), |ideal| self.distort_jacobian(ideal))
    }
}

/// The point that `distort`, with this derivative, moves to `distorted`: Newton's method with step halving; where there is none, the
/// closest point reached.
pub(crate) fn invert(
    distorted: &Vec2,
    distort: impl Fn(&Vec2) -> Vec2,
    jacobian: impl Fn(&Vec2) -> Mat2,
) -> Vec2 {
    const MAX_ITERATIONS: usize = 30;
    const MAX_HALVINGS: usize = 12;
    let mut ideal = *distorted;
    let mut residual = distort(&ideal) - distorted;
    for _ in 0..MAX_ITERATIONS {
        let Some(inverse) = jacobian(&ideal).try_inverse() else {
            break;
        };
        let mut step = inverse * residual;
        let mut improved = false;
        for _ in 0..MAX_HALVINGS {
            let candidate = ideal - step;
            let candidate_residual = distort(&candidate) - distorted;
            if candidate_residual.norm_squared() < residual.norm_squared() {
                (ideal, residual, improved) = (candidate, candidate_residual, true);
                break;
            }
            step *= 0.5;
        }
        if !improved {
            break;
        }
    }
    ideal
}
