//! Metrics, tables and plots of trajectories: the field's own figures, computed to the letter of their definitions.
//!
//! Start reading at [`Evaluation::of`], the one evaluator, and at its [`kitti_drift`] (t_rel, r_rel) and [`ate()`](fn@ate).
//! Poses are `world_from_cam`, lengths meters.

pub mod alignment;
pub mod association;
pub mod ate;
pub mod baseline;
pub mod command;
pub mod compare;
pub mod consistency;
pub mod coverage;
pub mod detections;
pub mod drift;
pub mod evaluation;
pub mod figures;
pub mod frames_table;
pub mod loops;
pub mod plot;
pub mod precision_recall;
pub mod report;
pub mod rpe;
pub mod scale_drift;
pub mod statistics;
pub mod suite;
pub mod table;

pub use alignment::{Alignment, apply_alignment, estimate_alignment, positions};
pub use association::{Association, TIMESTAMP_TOLERANCE_S, match_stamps};
pub use ate::{AteReport, ate};
pub use coverage::{Coverage, fill_lost};
pub use drift::{Drift, DriftBin, KITTI_LENGTHS_M, Segment, kitti_drift, kitti_drift_sparse};
pub use evaluation::{Estimate, Evaluation, EvaluationOptions, LostFrames, Matched, Subject};
pub use loops::{LoopScore, LoopTruth, SamePlace, score_loops};
pub use precision_recall::{Detection, PrecisionRecall, PrecisionRecallCurve, precision_recall};
pub use rpe::{DeltaUnit, PairMode, RpeOptions, RpeReport, rpe};
pub use scale_drift::scale_drift;
pub use statistics::Statistics;
