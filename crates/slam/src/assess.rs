//! How far a tracked frame is to be trusted: the covariance of its pose, and a number with its reasons.

use std::fmt;

use geometry::PoseCovariance;

/// Frames that a covariance looks back.
pub const COVARIANCE_FRAMES: usize = 10;

/// How far the pose of a frame is to be trusted. The default is that of a frame without a pose: not at all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assessment {
    /// Covariance of the pose, seen from the camera [`COVARIANCE_FRAMES`] frames before, or from the first frame since a start or a
    /// loss where that is nearer; `None` without a pose of its own, and for a frame that starts a map.
    pub covariance: Option<PoseCovariance>,
    /// Robust standard deviation of a residual of the inliers, pixels at octave 0.
    pub residual_px: Option<f64>,
    /// From 0 (not at all) to 1 (entirely).
    pub quality: f64,
    /// What lowers the quality most, the strongest reason first; empty for a good frame.
    pub reasons: Vec<QualityReason>,
}

impl Assessment {
    /// Of a frame that starts a map: what it says is the truth by definition.
    pub(crate) fn of_start() -> Self {
        Assessment { quality: 1.0, ..Assessment::default() }
    }
}

/// What makes a pose less trustworthy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum QualityReason {
    /// Few map points agree with the pose.
    FewInliers,
    /// The points fill a small part of the image.
    BadlySpread,
    /// The covariance of the pose is large.
    LargeCovariance,
    /// Hardly any of the points is near enough to tell where the camera is.
    MostlyFar,
    /// The points fit the pose badly.
    LargeResiduals,
    /// The camera was lost and has just found its place again.
    JustRelocalized,
    /// The motion model failed; descriptors alone gave the prediction.
    WithoutMotionModel,
    /// One camera turns on the spot: only its rotation is known, its position is held.
    TurningOnTheSpot,
}

impl QualityReason {
    /// In one word for programs and tables.
    pub fn key(self) -> &'static str {
        match self {
            QualityReason::FewInliers => "few_inliers",
            QualityReason::BadlySpread => "badly_spread",
            QualityReason::LargeCovariance => "large_covariance",
            QualityReason::MostlyFar => "mostly_far",
            QualityReason::LargeResiduals => "large_residuals",
            QualityReason::JustRelocalized => "just_relocalized",
            QualityReason::WithoutMotionModel => "without_motion_model",
            QualityReason::TurningOnTheSpot => "turning_on_the_spot",
        }
    }
}

impl fmt::Display for QualityReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            QualityReason::FewInliers => "few inliers",
            QualityReason::BadlySpread => "badly spread points",
            QualityReason::LargeCovariance => "large covariance",
            QualityReason::MostlyFar => "mostly far points",
            QualityReason::LargeResiduals => "large residuals",
            QualityReason::JustRelocalized => "just relocalized",
            QualityReason::WithoutMotionModel => "no motion model",
            QualityReason::TurningOnTheSpot => "turning on the spot, position held",
        })
    }
}
