//! One edge of a pose graph: its residual, Jacobians and blocks of the normal equations.

use nalgebra::{SMatrix, SVector};

use super::{PoseGraphEdge, PoseGroup};
use crate::robust::Loss;

/// A matrix over tangent vectors.
pub(crate) type Square<const D: usize> = SMatrix<f64, D, D>;

/// Huber's loss with its limit, or plain squares.
#[derive(Clone, Copy)]
pub(super) struct EdgeLoss {
    loss: Loss,
    delta_sq: f64,
}

impl EdgeLoss {
    pub(super) fn new(huber: Option<f64>) -> Self {
        match huber {
            Some(delta) => Self { loss: Loss::Huber, delta_sq: delta * delta },
            None => Self { loss: Loss::Squared, delta_sq: f64::INFINITY },
        }
    }

    /// The loss of a squared error; the cost is half of it.
    pub(super) fn rho(&self, chi_sq: f64) -> f64 {
        self.loss.rho(chi_sq, self.delta_sq)
    }

    fn weight(&self, chi_sq: f64) -> f64 {
        self.loss.weight(chi_sq, self.delta_sq)
    }
}

/// An edge prepared for many evaluations.
#[derive(Clone, Copy)]
pub(super) struct Factor<G, const D: usize> {
    pub(super) a: u32,
    pub(super) b: u32,
    /// Inverse of the measurement.
    a_from_b: G,
    information: Square<D>,
}

/// Gradient and upper blocks of the Gauss-Newton matrix of one edge.
pub(super) struct Blocks<const D: usize> {
    pub(super) gradient_a: SVector<f64, D>,
    pub(super) gradient_b: SVector<f64, D>,
    pub(super) aa: Square<D>,
    pub(super) ab: Square<D>,
    pub(super) bb: Square<D>,
}

impl<G, const D: usize> Factor<G, D>
where
    G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
{
    /// `None` for an edge that says nothing (see [`super::refine_pose_graph`]).
    pub(super) fn new(edge: &PoseGraphEdge<G>, poses: &[G]) -> Option<Self> {
        let is_known = |node: u32| poses.get(node as usize).is_some_and(G::is_valid);
        let usable = edge.a != edge.b
            && is_known(edge.a)
            && is_known(edge.b)
            && edge.b_from_a.is_valid()
            && is_information(&edge.information);
        usable.then(|| Self {
            a: edge.a,
            b: edge.b,
            a_from_b: edge.b_from_a.inverse(),
            information: edge.information,
        })
    }

    /// `b_from_a^-1 * b_from_world * a_from_world^-1`, whose logarithm is the residual.
    fn error(&self, poses: &[G]) -> G {
        self.a_from_b * poses[self.b as usize] * poses[self.a as usize].inverse()
    }

    /// Whitened squared error.
    pub(super) fn chi_sq(&self, poses: &[G]) -> f64 {
        let residual = self.error(poses).log();
        residual.dot(&(self.information * residual))
    }

    /// The residual with its derivatives by left perturbations of both poses.
    fn jacobians(&self, poses: &[G]) -> (SVector<f64, D>, Square<D>, Square<D>) {
        let error = self.error(poses);
        let residual = error.log();
        let inverse = G::left_jacobian_inverse(&residual);
        // E exp(-v) = exp(-Ad(E) v) E on the side of a; m^-1 exp(v) m E = exp(Ad(m^-1) v) E on that of b.
        (residual, -(inverse * error.adjoint()), inverse * self.a_from_b.adjoint())
    }

    /// Its part of the normal equations, weighted by the loss.
    pub(super) fn blocks(&self, poses: &[G], loss: &EdgeLoss) -> Blocks<D> {
        let (residual, by_a, by_b) = self.jacobians(poses);
        let chi_sq = residual.dot(&(self.information * residual));
        let weighted = self.information * loss.weight(chi_sq);
        let (info_a, info_b) = (weighted * by_a, weighted * by_b);
        Blocks {
            gradient_a: info_a.tr_mul(&residual),
            gradient_b: info_b.tr_mul(&residual),
            aa: by_a.tr_mul(&info_a),
            ab: by_a.tr_mul(&info_b),
            bb: by_b.tr_mul(&info_b),
        }
    }
}

/// Whether a matrix is finite, symmetric, positive semidefinite (to rounding) and not zero.
fn is_information<const D: usize>(matrix: &Square<D>) -> bool {
    const ROUNDING: f64 = 1e-9;
    let largest = matrix.amax();
    let diagonal = matrix + Square::<D>::from_diagonal_element(ROUNDING * largest);
    largest.is_finite()
        && (matrix - matrix.transpose()).amax() <= ROUNDING * largest
        && is_positive_definite(diagonal)
}

/// Cholesky's algorithm without the factor.
fn is_positive_definite<const D: usize>(mut m: Square<D>) -> bool {
    for c in 0..D {
        if !(m[(c, c)] > 0.0) {
            return false;
        }
        for r in c + 1..D {
            let factor = m[(r, c)] / m[(c, c)];
            for k in r..D {
                m[(k, r)] -= factor * m[(k, c)];
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use geometry::{SE3, SO3, Sim3};
    use rand::Rng;

    use super::*;
    use crate::common::random;

    fn tangent<const D: usize>(seed: u64, scale: f64) -> SVector<f64, D> {
        let mut random = random(seed);
        SVector::from_fn(|_, _| random.random_range(-scale..scale))
    }

    /// Both Jacobians against central differences, for small and for large residuals.
    fn check_jacobians<G, const D: usize>()
    where
        G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
    {
        const STEP: f64 = 1e-6;
        for seed in 0..40 {
            let scale = if seed % 2 == 0 { 0.05 } else { 1.0 };
            let poses = [G::exp(&tangent(3 * seed, 1.5)), G::exp(&tangent(3 * seed + 1, 1.5))];
            let b_from_a = poses[1] * poses[0].inverse() * G::exp(&tangent(3 * seed + 2, scale));
            let edge = PoseGraphEdge { a: 0, b: 1, b_from_a, information: Square::<D>::identity() };
            let factor = Factor::new(&edge, &poses).unwrap();
            let (residual, by_a, by_b) = factor.jacobians(&poses);
            assert!(residual.norm() > 0.1 * scale);
            for (node, jacobian) in [by_a, by_b].iter().enumerate() {
                for k in 0..D {
                    let at = |step: f64| {
                        let mut moved = poses;
                        let motion = SVector::from_fn(|i, _| if i == k { step } else { 0.0 });
                        moved[node] = G::exp(&motion) * moved[node];
                        factor.error(&moved).log()
                    };
                    let numeric = (at(STEP) - at(-STEP)) / (2.0 * STEP);
                    let error = (numeric - jacobian.column(k)).norm();
                    assert!(
                        error < 1e-7 * (1.0 + numeric.norm()),
                        "seed {seed}, node {node}, column {k}: {error}"
                    );
                }
            }
        }
    }

    #[test]
    fn analytic_jacobians_equal_numeric_ones() {
        check_jacobians::<SO3, 3>();
        check_jacobians::<SE3, 6>();
        check_jacobians::<Sim3, 7>();
    }

    #[test]
    fn blocks_are_the_weighted_products_of_the_jacobians() {
        let poses = [SE3::exp(&tangent(1, 1.0)), SE3::exp(&tangent(2, 1.0))];
        let root = Square::<6>::from_fn(|r, c| ((3 * r + 5 * c) as f64).sin());
        let edge = PoseGraphEdge {
            a: 0,
            b: 1,
            b_from_a: SE3::exp(&tangent(3, 1.0)),
            information: root.tr_mul(&root),
        };
        let factor = Factor::new(&edge, &poses).unwrap();
        let (residual, by_a, by_b) = factor.jacobians(&poses);
        let chi_sq = factor.chi_sq(&poses);
        assert!((chi_sq - (root * residual).norm_squared()).abs() < 1e-12 * chi_sq);
        for (huber, weight) in [(None, 1.0), (Some(1e3), 1.0), (Some(0.1), 0.1 / chi_sq.sqrt())] {
            let blocks = factor.blocks(&poses, &EdgeLoss::new(huber));
            let close = |value: f64| assert!(value.abs() < 1e-11, "{value}");
            close((blocks.aa - by_a.transpose() * edge.information * by_a * weight).amax());
            close((blocks.ab - by_a.transpose() * edge.information * by_b * weight).amax());
            close((blocks.bb - by_b.transpose() * edge.information * by_b * weight).amax());
            close((blocks.gradient_a - by_a.transpose() * edge.information * residual * weight).amax());
            close((blocks.gradient_b - by_b.transpose() * edge.information * residual * weight).amax());
        }
    }

    #[test]
    fn only_symmetric_positive_semidefinite_matrices_are_information() {
        let mut singular = Square::<6>::identity();
        singular[(4, 4)] = 0.0;
        assert!(is_information(&Square::<6>::identity()) && is_information(&singular));
        let mut indefinite = Square::<6>::identity();
        indefinite[(2, 2)] = -0.1;
        let mut skew = Square::<6>::identity();
        skew[(0, 1)] = 0.1;
        let infinite = Square::<6>::from_diagonal_element(f64::INFINITY);
        let nan = Square::<6>::from_diagonal_element(f64::NAN);
        for bad in [indefinite, skew, infinite, nan, Square::<6>::zeros()] {
            assert!(!is_information(&bad), "{bad}");
        }
    }
}
