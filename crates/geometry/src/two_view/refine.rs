//! The motion that fits the epipolar errors of all matches best, close to a first estimate.

use super::{CHI2_LINE, Views};
use crate::aliases::{Mat3, Vec3};
use crate::se3::SE3;
use crate::so3::SO3;
use nalgebra::{SMatrix, SVector};

/// Rotation, and the two directions across the translation.
type Vec5 = SVector<f64, 5>;
type Mat5 = SMatrix<f64, 5, 5>;

/// Minimizes the weighted sum of `e^2 / (1 + e^2)`, `e` being the Sampson distance over its limit (Geman and McClure 1987, so that
/// wrong matches have no say), by reweighted Gauss-Newton steps as long as they help.
///
/// Translations have length one. The sign of the translation is kept: the errors do not depend on it.
pub(super) fn refine_motion(views: &Views<'_>, start: &SE3) -> Refined {
    const MAX_ITERATIONS: usize = 20;
    /// Relative gain below which the next step is not worth it.
    const MIN_GAIN: f64 = 1e-9;
    let mut motion = *start;
    let mut system = System::new(views, &motion);
    for _ in 0..MAX_ITERATIONS {
        let Some(next) = system.step(&motion) else { break };
        let next_system = System::new(views, &next);
        // Also false when the cost is not a number.
        let better = next_system.cost < system.cost * (1.0 - MIN_GAIN);
        if !better {
            break;
        }
        (motion, system) = (next, next_system);
    }
    Refined { motion, direction_sigma_deg: system.direction_sigma(views).to_degrees() }
}

/// A motion, and how well the matches determine it.
pub(super) struct Refined {
    pub(super) motion: SE3,
    /// Standard deviation of the direction of the translation along its least certain axis, degrees.
    pub(super) direction_sigma_deg: f64,
}

/// Cost and normal equations at a motion.
struct System {
    cost: f64,
    hessian: Mat5,
    gradient: Vec5,
    /// Two unit vectors across the translation and each other.
    across: [Vec3; 2],
}

impl System {
    fn new(views: &Views<'_>, motion: &SE3) -> Self {
        let t = motion.translation;
        let first = t.cross(&Vec3::ith(t.iamin(), 1.0)).normalize();
        let across = [first, t.cross(&first)];
        let mut system = Self { cost: 0.0, hessian: Mat5::zeros(), gradient: Vec5::zeros(), across };
        let essential = SO3::hat(&t) * motion.rotation.matrix();
        let limit_sq = CHI2_LINE * views.variance();
        for i in 0..views.len() {
            let (residual, jacobian) = system.residual(views, motion, &essential, i);
            let error_sq = residual * residual / limit_sq;
            if !error_sq.is_finite() {
                continue;
            }
            system.cost += views.weights[i] * error_sq / (1.0 + error_sq);
            let weight = views.weights[i] / (1.0 + error_sq).powi(2);
            system.hessian += jacobian * jacobian.transpose() * weight;
            system.gradient += jacobian * (residual * weight);
        }
        system
    }

    /// Sampson distance of a match in pixels and its derivative, for which the denominator counts as constant.
    fn residual(&self, views: &Views<'_>, motion: &SE3, essential: &Mat3, i: usize) -> (f64, Vec5) {
        let (a, b) = views.rays(i);
        let (first, second) = (&views.reconstruction.first, &views.reconstruction.second);
        let (line_b, line_a) = (essential * a, essential.tr_mul(&b));
        // By the pixels, hence over the focal lengths.
        let gradient = [line_b.x / second.fx, line_b.y / second.fy, line_a.x / first.fx, line_a.y / first.fy];
        let scale = 1.0 / gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
        let turned = motion.rotation * a;
        // b . (t x Ra): by a turn w of R it grows by (b x t) . (w x Ra), by a shift d of t by d . (Ra x b).
        let by_turn = turned.cross(&b.cross(&motion.translation));
        let by_shift = turned.cross(&b);
        let [first, second] = self.across.map(|direction| direction.dot(&by_shift));
        let jacobian = Vec5::new(by_turn.x, by_turn.y, by_turn.z, first, second);
        (b.dot(&line_b) * scale, jacobian * scale)
    }

    /// Standard deviation of the translation's direction in radians, by the inverse of the normal equations; infinite where they
    /// leave it open.
    fn direction_sigma(&self, views: &Views<'_>) -> f64 {
        let Some(cholesky) = self.hessian.cholesky() else { return f64::INFINITY };
        let covariance = cholesky.inverse() * views.variance();
        let (a, b, c) = (covariance[(3, 3)], covariance[(3, 4)], covariance[(4, 4)]);
        // The larger eigenvalue of [a b; b c].
        (0.5 * (a + c) + (0.25 * (a - c) * (a - c) + b * b).sqrt()).sqrt()
    }

    /// The motion after a Gauss-Newton step; `None` when the matches leave it open.
    fn step(&self, motion: &SE3) -> Option<SE3> {
        let step = self.hessian.cholesky()?.solve(&-self.gradient);
        let turn = SO3::exp(&step.fixed_rows::<3>(0).into_owned());
        let shifted = motion.translation + self.across[0] * step[3] + self.across[1] * step[4];
        let next = SE3::new((turn * motion.rotation).orthonormalized(), shifted.normalize());
        next.is_finite().then_some(next)
    }
}
