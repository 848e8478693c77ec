//! The section `mapping` of the configuration.

use serde::{Deserialize, Serialize};
use settings::{Entry, Section, between, flag, integer, optional_integer, real};

/// Parameters of the mapper: the section `mapping` of the configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MappingParams {
    /// Covisible keyframes that triangulation and fusion look at; `None`: the sensor's own number.
    pub neighbours: Option<usize>,
    /// Robust iterations of the local bundle adjustment.
    pub local_ba_first_iterations: usize,
    /// Plain iterations after the outliers are out.
    pub local_ba_second_iterations: usize,
    /// A keyframe is redundant when this share of its close points is seen by three others.
    pub keyframe_cull_ratio: f64,
    /// Young points found in less than this share of the frames that should see them are dropped.
    pub point_found_ratio: f64,
    /// Second-order neighbors of each neighbor in fusion.
    pub second_neighbors: usize,
    /// Shared points from which two keyframes are optimized together.
    pub min_covisible_weight: u32,
    /// Keyframes that the local bundle adjustment moves at most.
    pub max_local_keyframes: usize,
    /// Close points made from depth when a keyframe is inserted; all that are closer are made anyway.
    pub min_depth_points: usize,
    /// Whether the calibration is refined from the map so far (not with depth images).
    pub refine_calibration: bool,
    /// Whether all keyframes and points are adjusted together after the last frame.
    pub final_bundle: bool,
}

impl Default for MappingParams {
    fn default() -> Self {
        Self {
            neighbours: None,
            local_ba_first_iterations: 5,
            local_ba_second_iterations: 10,
            keyframe_cull_ratio: 0.9,
            point_found_ratio: 0.25,
            second_neighbors: 5,
            min_covisible_weight: 15,
            max_local_keyframes: 40,
            min_depth_points: 100,
            refine_calibration: true,
            final_bundle: true,
        }
    }
}

#[rustfmt::skip]
impl Section for MappingParams {
    const KEYS: &'static [Entry] = &[
        optional_integer("mapping.neighbours", "keyframes", [1, 100], "number of covisible keyframes used to triangulate and fuse a new one; absent: 10, monocular 20"),
        integer("mapping.local_ba_first_iterations", "", [1, 1000], "local bundle adjustment: iterations with the robust kernel").expert(),
        integer("mapping.local_ba_second_iterations", "", [0, 1000], "local bundle adjustment: iterations after outliers are removed").expert(),
        real("mapping.keyframe_cull_ratio", "", between(0.1, 1.0), "a keyframe is culled when more than this fraction of its points is seen by three others").expert(),
        flag("mapping.refine_calibration", "refine the calibration from the map so far: focal lengths, center and distortion of one camera, disparities of a pair; what the images do not tell clearly stays"),
        flag("mapping.final_bundle", "adjust all keyframes and points together after the last frame"),
        real("mapping.point_found_ratio", "", between(0.0, 1.0), "a recent point is culled when it is found in less than this fraction of the frames that should see it").expert(),
    ];
}
