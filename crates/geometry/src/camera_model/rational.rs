//! The rational lens of OpenCV with eight coefficients (`CALIB_RATIONAL_MODEL`; in ROS `rational_polynomial`).

use crate::aliases::{Mat2, Vec2};
use crate::distortion::{Distortion, invert};
use crate::pinhole::Pinhole;
use crate::polynomial::first_sign_change;
use serde::{Deserialize, Serialize};

/// A pinhole whose radial factor is `(1 + k1 s + k2 s^2 + k3 s^3) / (1 + k4 s + k5 s^2 + k6 s^3)`, with `s` the squared radius.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rational {
    /// Focal lengths and principal point in pixels.
    pub camera: Pinhole,
    /// The numerator and the tangential terms.
    pub upper: Distortion,
    /// The denominator: `k4, k5, k6`.
    pub lower: [f64; 3],
}

impl Rational {
    /// The distorted place of an ideal normalized point.
    pub fn distort(&self, ideal: &Vec2) -> Vec2 {
        self.upper.bend(ideal, self.factor(ideal.norm_squared()).0)
    }

    /// The derivative of [`Rational::distort`] by the ideal point (a symmetric 2 by 2 matrix).
    pub fn distort_jacobian(&self, ideal: &Vec2) -> Mat2 {
        self.upper.bend_jacobian(ideal, self.factor(ideal.norm_squared()))
    }

    /// The ideal normalized point of a distorted one; beyond [`Rational::max_radius`] the closest point reached.
    pub fn undistort(&self, distorted: &Vec2) -> Vec2 {
        invert(distorted, |ideal| self.distort(ideal), |ideal| self.distort_jacobian(ideal))
    }

    /// The radius of ideal normalized points up to which the radial part grows; at most 1000.
    pub fn max_radius(&self) -> f64 {
        const END: f64 = 1000.0;
        let (n, d) = self.polynomials();
        // d(r N / D) / dr = ((N + 2 s N') D - 2 s N D') / D^2: the numerator, by powers of s.
        let mut grows = [0.0; 7];
        for (i, n) in n.iter().enumerate() {
            for (j, d) in d.iter().enumerate() {
                grows[i + j] += n * d * (1.0 + 2.0 * i as f64 - 2.0 * j as f64);
            }
        }
        // Where the denominator vanishes the image ends as well.
        let ends = [first_sign_change(&grows, END * END), first_sign_change(&d, END * END)];
        ends.into_iter().flatten().fold(END * END, f64::min).sqrt()
    }

    /// The radial factor and its derivative by the squared radius.
    fn factor(&self, r_sq: f64) -> (f64, f64) {
        let ([_, n1, n2, n3], [_, d1, d2, d3]) = self.polynomials();
        let upper = 1.0 + r_sq * (n1 + r_sq * (n2 + r_sq * n3));
        let lower = 1.0 + r_sq * (d1 + r_sq * (d2 + r_sq * d3));
        let upper_slope = n1 + r_sq * (2.0 * n2 + r_sq * 3.0 * n3);
        let lower_slope = d1 + r_sq * (2.0 * d2 + r_sq * 3.0 * d3);
        (upper / lower, (upper_slope * lower - upper * lower_slope) / (lower * lower))
    }

    fn polynomials(&self) -> ([f64; 4], [f64; 4]) {
        let Distortion { k1, k2, k3, .. } = self.upper;
        let [k4, k5, k6] = self.lower;
        ([1.0, k1, k2, k3], [1.0, k4, k5, k6])
    }
}
