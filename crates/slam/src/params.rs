//! What can be set in tracking, mapping and loop closing. Defaults follow ORB-SLAM2's published constants where not said otherwise.

use features::Frame;
use geometry::Sensor;

use crate::noise::Noise;

/// Residuals of rectified stereo on real drives have a standard deviation of 0.35 px at octave 0; twice that leaves room
/// for what a chi-square test should not call an outlier.
const STEREO_SIGMA_PX: f64 = 0.7;
/// Rolling shutters, motion blur and depth that is not quite of the same moment: as ORB-SLAM2.
const RGBD_SIGMA_PX: f64 = 1.0;

/// As RGB-D: nothing but the rows and columns of one image.
const MONO_SIGMA_PX: f64 = 1.0;

/// Parameters of the tracker.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackingParams {
    /// Features with depth needed to start a map.
    pub min_initial_depths: usize,
    /// Half window of the search around the predicted position, pixels at octave 0 (stereo 7, RGB-D 15).
    pub motion_radius_px: f32,
    /// Matches that the motion model needs before it optimises.
    pub min_motion_matches: usize,
    /// Descriptor matches that the reference keyframe needs.
    pub min_reference_matches: usize,
    /// Inliers that a prediction needs.
    pub min_predicted_inliers: usize,
    /// Inliers that the local map needs.
    pub min_inliers: usize,
    /// Factor on the local map's search window (stereo 1, RGB-D 3).
    pub local_radius_factor: f32,
    /// Keyframes in the local map at most.
    pub max_local_keyframes: usize,
    /// Whether the map is only read: no keyframe is ever asked for.
    pub localize_only: bool,
    /// Frames that could start a map, one after another, lost, before a new sub-map is started.
    pub max_lost_frames: u32,
    /// A keyframe is due after this many frames without one (the camera's frame rate, that is one second).
    pub max_keyframe_gap: u32,
    /// Share of the reference keyframe's points below which a keyframe is due.
    pub keyframe_ratio: f64,
    /// Features nearer than this depth count as close, metres.
    pub close_depth_m: f64,
    /// Fewer tracked close points than this, with enough untracked ones, ask for a keyframe.
    pub min_close_tracked: usize,
    /// More untracked close features than this can be turned into points.
    pub max_close_untracked: usize,
}

/// Parameters of the mapper.
#[derive(Clone, Debug, PartialEq)]
pub struct MappingParams {
    /// Covisible keyframes that triangulation and fusion look at.
    pub neighbours: usize,
    /// Second-order neighbours of each neighbour in fusion.
    pub second_neighbours: usize,
    /// Shared points from which two keyframes are optimised together.
    pub min_covisible_weight: u32,
    /// Young points found in less than this share of the frames that should see them are dropped.
    pub min_found_ratio: f64,
    /// Robust iterations of the local bundle adjustment.
    pub first_iterations: usize,
    /// Plain iterations after the outliers are out.
    pub second_iterations: usize,
    /// Keyframes that the local bundle adjustment moves at most.
    pub max_local_keyframes: usize,
    /// A keyframe is redundant when this share of its close points is seen by three others.
    pub redundant_ratio: f64,
    /// Features nearer than this depth count as close, metres.
    pub close_depth_m: f64,
    /// Close points made from depth when a keyframe is inserted; all that are closer are made anyway.
    pub min_depth_points: usize,
}

/// Parameters of loop closing.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopParams {
    /// Whether loops are looked for.
    pub enabled: bool,
    /// Keyframes that must have come since the start and since the last loop.
    pub min_gap: usize,
    /// Shared points from which a neighbour certainly sees the same place.
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
    /// Length of a metre in the map: 1 where lengths are metres.
    pub unit: f64,
    /// Drift that is expected, metres per metre of path (standard deviation).
    pub drift_sigma: f64,
    /// Drift that is believed at all when places are looked for, metres per metre of path.
    pub max_drift: f64,
    /// Added to it: how far two views of one place can be apart, metres.
    pub prior_margin_m: f64,
    /// Shared points from which covisibility is an edge of the pose graph.
    pub essential_weight: u32,
    /// Iterations of the global bundle adjustment.
    pub global_iterations: usize,
}

/// Where the activation of features counts, beside their selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Weights {
    /// In samples and scores of RANSAC.
    pub ransac: bool,
    /// In optimisation, as a factor on the information of an observation.
    pub optimisation: bool,
    /// In bags of words.
    pub words: bool,
}

impl Default for Weights {
    fn default() -> Self {
        Weights { ransac: true, optimisation: false, words: true }
    }
}

impl Weights {
    /// The weight of feature `i` in RANSAC.
    pub(crate) fn of_sample(self, frame: &Frame, i: usize) -> f64 {
        if self.ransac { f64::from(frame.activation[i]) } else { 1.0 }
    }
}

/// All parameters of the SLAM steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// The tracker's.
    pub tracking: TrackingParams,
    /// The mapper's.
    pub mapping: MappingParams,
    /// The loop closer's.
    pub loops: LoopParams,
    /// Which images a frame has. With one camera maps start from two views, and their unit of length is free.
    pub sensor: Sensor,
    /// Standard deviation of a feature's position at octave 0, pixels; errors are judged in units of it.
    pub feature_sigma_px: f64,
    /// Where the activation of features counts.
    pub weights: Weights,
    /// Seed of every random decision.
    pub seed: u64,
}

impl Params {
    /// For rectified stereo; `close_depth_m` is usually 35 to 40 baselines.
    pub fn stereo(close_depth_m: f64, frame_rate_hz: f64) -> Self {
        Params {
            tracking: TrackingParams {
                min_initial_depths: 100,
                motion_radius_px: 7.0,
                min_motion_matches: 20,
                min_reference_matches: 15,
                min_predicted_inliers: 10,
                min_inliers: 30,
                local_radius_factor: 1.0,
                max_local_keyframes: 80,
                localize_only: false,
                max_lost_frames: frame_rate_hz.round().max(1.0) as u32,
                max_keyframe_gap: frame_rate_hz.round().max(1.0) as u32,
                keyframe_ratio: 0.75,
                close_depth_m,
                min_close_tracked: 100,
                max_close_untracked: 70,
            },
            mapping: MappingParams {
                neighbours: 10,
                second_neighbours: 5,
                min_covisible_weight: 15,
                min_found_ratio: 0.25,
                first_iterations: 5,
                second_iterations: 10,
                max_local_keyframes: 40,
                redundant_ratio: 0.9,
                close_depth_m,
                min_depth_points: 100,
            },
            loops: LoopParams {
                enabled: true,
                min_gap: 10,
                min_covisible_weight: 15,
                consistency: 3,
                min_matches: 20,
                min_ransac_inliers: 20,
                min_inliers: 40,
                min_inlier_share: 0.1,
                unit: 1.0,
                drift_sigma: 0.01,
                max_drift: 0.05,
                prior_margin_m: close_depth_m,
                essential_weight: 100,
                global_iterations: 10,
            },
            sensor: Sensor::Stereo,
            feature_sigma_px: STEREO_SIGMA_PX,
            weights: Weights::default(),
            seed: 0,
        }
    }

    /// How exactly features are placed.
    pub(crate) fn noise(&self) -> Noise {
        Noise { sigma_px: self.feature_sigma_px, weighted: self.weights.optimisation }
    }

    /// For RGB-D: wider windows, since hand-held cameras turn faster.
    pub fn rgbd(close_depth_m: f64, frame_rate_hz: f64) -> Self {
        let mut params = Params::stereo(close_depth_m, frame_rate_hz);
        params.sensor = Sensor::Rgbd;
        params.tracking.motion_radius_px = 15.0;
        params.tracking.local_radius_factor = 3.0;
        params.feature_sigma_px = RGBD_SIGMA_PX;
        params.loops.drift_sigma = 0.02;
        params.loops.max_drift = 0.1;
        params
    }

    /// For one camera without depth.
    pub fn mono(frame_rate_hz: f64) -> Self {
        let mut params = Params::stereo(f64::INFINITY, frame_rate_hz);
        params.sensor = Sensor::Mono;
        params.tracking.motion_radius_px = 15.0;
        params.tracking.keyframe_ratio = 0.9;
        params.mapping.neighbours = 20;
        params.feature_sigma_px = MONO_SIGMA_PX;
        // The unit is the first scene's median depth, of the order of ten metres.
        params.loops.unit = 0.1;
        params.loops.drift_sigma = 0.1;
        params.loops.max_drift = f64::INFINITY;
        params.loops.prior_margin_m = 0.0;
        params
    }
}
