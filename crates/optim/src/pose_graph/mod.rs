//! Pose graph optimization: poses from measured motions between them, on SE(3), Sim(3) or SO(3).

mod edge;
mod group;
mod solver;
mod structure;

pub use group::PoseGroup;

use nalgebra::{SMatrix, SVector};

use crate::report::Report;

/// A measured motion from node `a` to node `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseGraphEdge<G: PoseGroup> {
    /// Index into [`PoseGraphProblem::poses`].
    pub a: u32,
    /// Index into [`PoseGraphProblem::poses`].
    pub b: u32,
    /// The measurement.
    pub b_from_a: G,
    /// Inverse covariance of `log(b_from_a^-1 * predicted)` in the group's tangent order (translation, rotation, scale);
    /// symmetric and positive semidefinite.
    pub information: G::Matrix,
}

/// A pose graph.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseGraphProblem<G: PoseGroup> {
    /// Initial poses, node_from_world.
    pub poses: Vec<G>,
    /// Per pose whether it must not move.
    pub fixed: Vec<bool>,
    /// Measurements in any order.
    pub edges: Vec<PoseGraphEdge<G>>,
}

/// How to solve a [`PoseGraphProblem`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseGraphOptions {
    /// Limit on linear systems solved.
    pub max_iterations: usize,
    /// Huber's loss on the whitened norm of each edge, quadratic up to this many sigma; `None`: plain squares.
    pub huber: Option<f64>,
    /// Stop once a step promises to change the cost by less than this part of it.
    pub relative_tolerance: f64,
    /// Levenberg-Marquardt damping of the first step, relative to the diagonal of the normal equations.
    pub initial_damping: f64,
}

impl Default for PoseGraphOptions {
    fn default() -> Self {
        Self { max_iterations: 50, huber: None, relative_tolerance: 1e-8, initial_damping: 1e-9 }
    }
}

/// A solved [`PoseGraphProblem`].
#[derive(Clone, Debug, PartialEq)]
pub struct PoseGraphSolution<G> {
    /// Poses, node_from_world; fixed ones unchanged.
    pub poses: Vec<G>,
    /// Whitened squared error per edge in input order, without loss; NaN for an edge that was left out.
    pub chi_sq: Vec<f64>,
    /// How the solve went; inliers are edges within the 95 % chi-square limit of the group's degrees of freedom.
    pub report: Report,
}

/// Minimizes half the sum of (robust) whitened squared errors `log(b_from_a^-1 * b_from_world * a_from_world^-1)`.
///
/// Levenberg-Marquardt (Gauss-Newton with a safeguard, for the initial damping is tiny) with analytic Jacobians and sparse
/// Cholesky factorization. Each connected part of the graph without a fixed node keeps its lowest node in place, which fixes
/// the gauge; nodes without an edge stay. On one thread; equal input gives equal bits.
///
/// Edges that say nothing are skipped, and their `chi_sq` is NaN: an index out of range, `a == b`, a pose or measurement
/// that is not finite, an information matrix that is not finite, not symmetric, zero or not positive semidefinite. Nodes
/// beyond the end of `fixed` are free.
pub fn refine_pose_graph<G, const D: usize>(
    problem: &PoseGraphProblem<G>,
    options: &PoseGraphOptions,
) -> PoseGraphSolution<G>
where
    G: PoseGroup<Tangent = SVector<f64, D>, Matrix = SMatrix<f64, D, D>>,
{
    solver::solve(problem, options)
}
