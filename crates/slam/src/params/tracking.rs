//! The section `tracking` of the configuration.

use serde::{Deserialize, Serialize};
use settings::{Entry, Section, between, integer, optional_real};

/// Parameters of the tracker: the section `tracking` of the configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TrackingParams {
    /// Features with depth needed to start a map.
    pub init_min_features: usize,
    /// Inliers that the local map needs.
    pub min_inliers: usize,
    /// Share of the reference keyframe's points below which a keyframe is due; `None`: the sensor's own.
    pub keyframe_ratio: Option<f64>,
    /// Fewer tracked close points than this, with enough untracked ones, ask for a keyframe.
    pub close_tracked_min: usize,
    /// More untracked close features than this can be turned into points.
    pub close_untracked_max: usize,
    /// Matches that the motion model needs before it optimizes.
    pub min_motion_matches: usize,
    /// Descriptor matches that the reference keyframe needs.
    pub min_reference_matches: usize,
    /// Inliers that a prediction needs.
    pub min_predicted_inliers: usize,
    /// Keyframes in the local map at most.
    pub max_local_keyframes: usize,
    /// Whether the map is only read: no keyframe is ever asked for.
    pub localize_only: bool,
}

impl Default for TrackingParams {
    fn default() -> Self {
        Self {
            init_min_features: 100,
            min_inliers: 30,
            keyframe_ratio: None,
            close_tracked_min: 100,
            close_untracked_max: 70,
            min_motion_matches: 20,
            min_reference_matches: 15,
            min_predicted_inliers: 10,
            max_local_keyframes: 80,
            localize_only: false,
        }
    }
}

#[rustfmt::skip]
impl Section for TrackingParams {
    const KEYS: &'static [Entry] = &[
        integer("tracking.init_min_features", "", [10, 100_000], "features with depth needed to start a map").expert(),
        integer("tracking.min_inliers", "", [4, 10_000], "minimum matched map points; a frame with fewer is lost"),
        optional_real("tracking.keyframe_ratio", "", between(0.0, 1.0), "a keyframe is due when less than this fraction of the reference's points is tracked; absent: 0.75, monocular 0.9"),
        integer("tracking.close_tracked_min", "", [0, 100_000], "close points tracked, below which a keyframe is due (of 2000 features; in proportion of fewer) ...").expert(),
        integer("tracking.close_untracked_max", "", [0, 100_000], "... if more close features than this have no point").expert(),
    ];
}
