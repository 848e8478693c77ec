//! The section `loops` of the configuration.

use serde::{Deserialize, Serialize};
use settings::{Entry, Section, flag};

/// Parameters of loop closing: the section `loops` of the configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LoopParams {
    /// Whether loops are looked for.
    pub enabled: bool,
    /// Keyframes that must have come since the start and since the last loop.
    pub min_gap: usize,
    /// Shared points from which a neighbor certainly sees the same place.
    pub min_covisible_weight: u32,
    /// Keyframes in a row, before the present one, from which the place must have looked alike.
    pub consistency: usize,
    /// Descriptor matches that a candidate needs.
    pub min_matches: usize,
    /// Of those, matches that one motion must explain.
    pub min_ransac_inliers: usize,
    /// Points of the earlier visit that the refined motion must find.
    pub min_inliers: usize,
    /// Share of the points that should be visible that it must find.
    pub min_inlier_share: f64,
    /// Shared points from which covisibility is an edge of the pose graph.
    pub essential_weight: u32,
    /// Iterations of the global bundle adjustment.
    pub global_iterations: usize,
}

impl Default for LoopParams {
    fn default() -> Self {
        Self {
            enabled: true,
            min_gap: 10,
            min_covisible_weight: 15,
            consistency: 3,
            min_matches: 20,
            min_ransac_inliers: 20,
            min_inliers: 40,
            min_inlier_share: 0.1,
            essential_weight: 100,
            global_iterations: 10,
        }
    }
}

impl Section for LoopParams {
    const KEYS: &'static [Entry] =
        &[flag("loops.enabled", "recognize places seen before and correct the map; needs a vocabulary")];
}
