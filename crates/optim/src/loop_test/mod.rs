//! Whether a loop agrees with the odometry around it and with the loops found earlier, before any pose is moved.
//!
//! First the rotations: the shortest cycle that the candidate closes must close within its accumulated uncertainty; then
//! the error is spread by rotation averaging. With rotations fixed the positions are a convex problem, whose answer cannot
//! depend on where the search began: there the cycle must close in translation, and no edge may be torn.

mod cycle;
mod doubts;
mod drift;
mod measure;

use geometry::SE3;

pub use doubts::{Doubts, Witness, culprit};
pub use drift::DriftModel;

use crate::convex::ConvexError;

/// Where an edge comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CycleEdgeKind {
    /// Consecutive nodes of the trajectory.
    Odometry,
    /// A loop that was accepted before.
    EarlierLoop,
    /// The loop to be tested.
    Candidate,
}

/// A measured motion between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleEdge {
    /// Index of the first node.
    pub a: u32,
    /// Index of the second node.
    pub b: u32,
    /// The measurement, meters.
    pub b_from_a: SE3,
    /// Standard deviation of each coordinate of its translation, meters; without what rotation errors elsewhere do to the
    /// position, which the test adds itself.
    pub sigma_m: f64,
    /// Standard deviation of its rotation about each axis, radians.
    pub sigma_rad: f64,
    /// Where it comes from.
    pub kind: CycleEdgeKind,
}

/// The gate of [`test_loop`]: the largest square over its variance of a closure in rotation, one in translation, and the residual of
/// a single edge after the fit (chi-square, 3 degrees of freedom, 99.9 %).
pub const CHI2_CLOSURE: f64 = 16.266;

/// What [`test_loop`] measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoopNumbers {
    /// Edges of the cycle with the least variance of rotation, the candidate included.
    pub cycle_edges: usize,
    /// Length of that cycle, meters.
    pub cycle_length_m: f64,
    /// Angle by which the cycle fails to close, degrees.
    pub rotation_closure_deg: f64,
    /// Standard deviation of each component of it, degrees.
    pub rotation_sigma_deg: f64,
    /// Distance by which the cycle with the least variance of translation fails to close under averaged rotations, meters.
    pub translation_closure_m: f64,
    /// Standard deviation of each component of it, meters.
    pub translation_sigma_m: f64,
    /// Residual of the candidate after the fit, the larger of that in rotation and that in translation, sigma.
    pub candidate_residual: f64,
    /// The largest such residual of an earlier loop; 0 without one.
    pub earlier_loop_residual: f64,
    /// The largest such residual of an odometry edge.
    pub odometry_residual: f64,
}

impl LoopNumbers {
    /// The largest of all that was measured, in its standard deviations.
    fn sigmas(&self) -> f64 {
        let closures = [
            (self.rotation_closure_deg, self.rotation_sigma_deg),
            (self.translation_closure_m, self.translation_sigma_m),
        ];
        let closures = closures.into_iter().filter(|c| c.1 > 0.0).map(|(closure, sigma)| closure / sigma);
        let residuals = [self.candidate_residual, self.earlier_loop_residual, self.odometry_residual];
        closures.chain(residuals).fold(0.0, f64::max)
    }
}

/// Why a candidate was refused.
#[derive(Clone, Debug, PartialEq)]
pub enum Inconsistency {
    /// Not exactly one candidate, or an edge with an unknown node or unusable numbers.
    BadInput {
        /// Index of the first such edge, or the number of edges where the number of candidates is wrong.
        edge: usize,
    },
    /// The candidate closes no cycle: there is nothing to test it against.
    NoCycle,
    /// The cycle does not close in rotation.
    Rotation {
        /// Closure over its standard deviation.
        sigmas: f64,
    },
    /// The cycle does not close in translation.
    Translation {
        /// Closure over its standard deviation.
        sigmas: f64,
    },
    /// An edge is torn: its residual after the fit is above the gate, and the largest of all.
    Residual {
        /// Index of the edge.
        edge: usize,
        /// Where it comes from.
        kind: CycleEdgeKind,
        /// Its residual, sigma.
        sigmas: f64,
    },
    /// The convex problem has no answer.
    Convex(ConvexError),
}

/// Answer of [`test_loop`].
#[derive(Clone, Debug, PartialEq)]
pub enum LoopVerdict {
    /// The candidate agrees with everything.
    Consistent(LoopNumbers),
    /// It does not.
    Inconsistent {
        /// The first gate that it fails.
        reason: Inconsistency,
        /// As far as measured; zero beyond.
        numbers: LoopNumbers,
    },
}

impl LoopVerdict {
    /// Whether the candidate agrees with everything.
    pub fn is_consistent(&self) -> bool {
        matches!(self, LoopVerdict::Consistent(_))
    }

    /// How far the candidate goes in what the default gates allow: above 1 if it is refused, without limit if it could not be tested.
    pub fn strain(&self) -> f64 {
        let of = |numbers: &LoopNumbers| numbers.sigmas() / CHI2_CLOSURE.sqrt();
        match self {
            LoopVerdict::Consistent(numbers) => of(numbers),
            LoopVerdict::Inconsistent {
                reason: Inconsistency::BadInput { .. } | Inconsistency::NoCycle | Inconsistency::Convex(_),
                ..
            } => f64::INFINITY,
            LoopVerdict::Inconsistent { numbers, .. } => of(numbers),
        }
    }
}

/// Tests the one edge of kind [`CycleEdgeKind::Candidate`] against all others, at the current estimates `nodes`
/// (node_from_world).
///
/// The nodes must be connected. Errors of rotation move positions by their lever arms: spread over a cycle that closes, the
/// rotation of one edge moves the closure by its lever arm about the centroid of the cycle, so `sigma_rad` times that arm is
/// added to the edge's `sigma_m` (squares added).
pub fn test_loop(nodes: &[SE3], edges: &[CycleEdge]) -> LoopVerdict {
    let mut numbers = LoopNumbers::default();
    match measure::measure(nodes, edges, &mut numbers) {
        Ok(()) => LoopVerdict::Consistent(numbers),
        Err(reason) => LoopVerdict::Inconsistent { reason, numbers },
    }
}
