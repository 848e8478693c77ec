//! The configuration as the program uses it: a typed field for each key of `table.rs`, which tests keep equal.
//! Units, ranges and defaults stand in the table; real numbers are `f64`, keys that may be absent are `Option`s.

use std::path::PathBuf;

use geometry::Sensor;
use serde::{Deserialize, Serialize};

/// Section `camera`: used where the dataset has no calibration file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSettings {
    /// Focal length, px.
    pub fx: Option<f64>,
    /// Focal length, px.
    pub fy: Option<f64>,
    /// Principal point, px.
    pub cx: Option<f64>,
    /// Principal point, px.
    pub cy: Option<f64>,
    /// Radial distortion, r^2.
    pub k1: f64,
    /// Radial distortion, r^4.
    pub k2: f64,
    /// Tangential distortion.
    pub p1: f64,
    /// Tangential distortion.
    pub p2: f64,
    /// Radial distortion, r^6.
    pub k3: f64,
    /// Image width, px.
    pub width: Option<usize>,
    /// Image height, px.
    pub height: Option<usize>,
    /// Distance of the two cameras, m; virtual for RGB-D.
    pub baseline_m: Option<f64>,
    /// Frames per second.
    pub fps: f64,
    /// Value of a depth image at one metre.
    pub depth_units_per_metre: f64,
}

/// Section `input`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputSettings {
    /// What to use of the dataset.
    pub sensor: Option<Sensor>,
    /// Factor by which images are reduced.
    pub scale: f64,
    /// Image that is 0 where no features are to be taken.
    pub mask: Option<PathBuf>,
    /// Largest time between a colour image and its depth image, s.
    pub association_tolerance_s: f64,
}

/// Section `features`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureSettings {
    /// Keypoints kept per image.
    pub keep: usize,
    /// Keypoints kept per image of a single camera, where they are not as many.
    pub keep_mono: Option<usize>,
    /// By what they are chosen.
    pub selection: FeatureSelection,
    /// Keypoints among which a network chooses.
    pub candidates: usize,
    /// Whether those chosen are spread over the image.
    pub spread: FeatureSpread,
    /// Threads of the network.
    pub network_threads: usize,
    /// Levels of the pyramid.
    pub levels: usize,
    /// Ratio of the sizes of two neighbouring levels.
    pub scale_factor: f64,
    /// FAST threshold tried first.
    pub fast_initial: u8,
    /// FAST threshold of cells where the first finds nothing.
    pub fast_minimum: u8,
    /// Whether keypoints are refined below one pixel.
    pub subpixel: bool,
}

impl FeatureSettings {
    /// The settings of a run with this sensor: `keep` is the number kept with it.
    #[must_use]
    pub fn with_sensor(&self, sensor: Sensor) -> Self {
        let keep = match sensor {
            Sensor::Mono => self.keep_mono.unwrap_or(self.keep),
            Sensor::Stereo | Sensor::Rgbd => self.keep,
        };
        FeatureSettings { keep, ..self.clone() }
    }
}

/// By what features are chosen among the candidates of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FeatureSelection {
    /// The network trained with the hybrid loss: highest activation.
    Activation,
    /// The network trained with the semantic loss: highest response off what may move.
    Semantic,
    /// No network: highest response, spread over the image.
    Response,
}

/// Whether features chosen by a network are spread over the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FeatureSpread {
    /// The best of each of as many cells as features are wanted.
    Cells,
    /// The best of the image.
    Anywhere,
}

/// Section `weights`: where the activation of features counts beside their selection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WeightSettings {
    /// In samples and scores of RANSAC.
    pub ransac: bool,
    /// In optimisation.
    pub optimisation: bool,
    /// In bags of words.
    pub words: bool,
}

/// Section `stereo`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StereoSettings {
    /// Nearest depth searched for, m; absent: four baselines.
    pub min_depth_m: Option<f64>,
    /// Depth in baselines up to which a point is close.
    pub close_depth_baselines: f64,
    /// Added to every disparity, px.
    pub disparity_offset_px: f64,
    /// Frames of the calibration pass; 0: none.
    pub calibration_frames: usize,
}

/// Section `tracking`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackingSettings {
    /// Features needed to start a map.
    pub init_min_features: usize,
    /// Matched points below which a frame is lost.
    pub min_inliers: usize,
    /// Share of the reference's points below which a keyframe is due.
    pub keyframe_ratio: Option<f64>,
    /// Close points tracked below which a keyframe may be due.
    pub close_tracked_min: usize,
    /// Close features without a point above which it is.
    pub close_untracked_max: usize,
}

/// Section `mapping`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MappingSettings {
    /// Covisible keyframes worked with.
    pub neighbours: Option<usize>,
    /// Local bundle adjustment: iterations with the robust kernel.
    pub local_ba_first_iterations: usize,
    /// Local bundle adjustment: iterations without outliers.
    pub local_ba_second_iterations: usize,
    /// Share of points seen elsewhere above which a keyframe goes.
    pub keyframe_cull_ratio: f64,
    /// Share of frames that find a young point below which it goes.
    pub point_found_ratio: f64,
}

/// Section `loops`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoopSettings {
    /// Whether loops are looked for.
    pub enabled: bool,
}

/// Section `runtime`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RuntimeSettings {
    /// Frames after which tracking sees the finished mapping of a keyframe.
    pub lag: usize,
    /// Frames after which a loop may be closed.
    pub loop_lag: usize,
}
