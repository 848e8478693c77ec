//! Least squares on plain problems: the pose of one frame ([`refine_pose`]), bundle adjustment ([`refine_bundle`]) and pose
//! graphs ([`refine_pose_graph`]); and the convex test of a loop ([`test_loop`]) before it may move anything.
//!
//! The first three are Levenberg-Marquardt with Huber's loss. Nothing here knows of maps, keyframes or threads: a caller
//! collects a problem into plain vectors, solves it and writes the answer back. Equal input gives equal bits.

#![allow(clippy::needless_range_loop, reason = "small matrices read best by their indices")]
#![allow(clippy::neg_cmp_op_on_partial_ord, reason = "a negated comparison is how NaN is refused")]

// Lets unit tests share the scenes of the integration tests.
#[cfg(test)]
extern crate self as dsslam_optim;
#[cfg(test)]
#[path = "../tests/common/mod.rs"]
mod common;

mod bundle;
pub mod convex;
mod descent;
pub mod loop_test;
mod pose;
pub mod pose_graph;
mod report;
mod robust;
mod sparse;
#[cfg(test)]
mod wide;

pub use bundle::calibration::{
    CalibrationProblem, CalibrationSolution, CalibrationVector, N_CALIBRATION, refine_calibration,
};
pub use bundle::model::{Linearization, ObservationModel, Point};
pub use bundle::rig::{RigCamera, RigModel, RigObservation};
pub use bundle::solver::{Edge, Graph, Minimum, minimize};
pub use bundle::{BundleObservation, BundleOptions, BundleProblem, BundleSolution, refine_bundle};
pub use convex::{ConvexError, TranslationEdge, TranslationFit, TranslationProblem, fit_translations};
pub use loop_test::{
    CHI2_CLOSURE, CycleEdge, CycleEdgeKind, DriftModel, Inconsistency, LoopNumbers, LoopVerdict, test_loop,
};
pub use pose::{PoseObservation, PoseOptions, PoseSolution, refine_pose};
pub use pose_graph::{
    PoseGraphEdge, PoseGraphOptions, PoseGraphProblem, PoseGraphSolution, PoseGroup, refine_pose_graph,
};
pub use report::{Report, StopReason};
pub use robust::{CHI2_MONO, CHI2_SE3, CHI2_SIM3, CHI2_STEREO, Loss};
