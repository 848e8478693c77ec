//! Configuration: defaults, a YAML file, `--set` arguments, and the calibration of the dataset, in rising order of power.
//! The keys stand in `table.rs`, their typed fields in `settings.rs`; nothing else knows a single key but the camera.

mod camera;
mod dump;
mod explain;
mod problem;
mod resolve;
mod rules;
pub(crate) mod schema;
mod settings;
mod source;
mod suggest;
pub(crate) mod table;

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

pub use camera::CameraError;
pub use explain::Explained;
pub use problem::{ConfigErrors, Problem, Provenance};
pub use settings::{
    CameraSettings, FeatureSelection, FeatureSettings, FeatureSpread, InputSettings, LoopSettings,
    MappingSettings, RuntimeSettings, StereoSettings, TrackingSettings, WeightSettings,
};

/// A complete, checked configuration. [`crate::SCHEMA`] documents its keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The camera, used where the dataset has no calibration file.
    pub camera: CameraSettings,
    /// What is read.
    pub input: InputSettings,
    /// Keypoints.
    pub features: FeatureSettings,
    /// Where the activation of features counts.
    pub weights: WeightSettings,
    /// Depth from two images.
    pub stereo: StereoSettings,
    /// Poses of frames.
    pub tracking: TrackingSettings,
    /// The map.
    pub mapping: MappingSettings,
    /// Places seen again.
    pub loops: LoopSettings,
    /// How the stages of a run share time.
    pub runtime: RuntimeSettings,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Where each value comes from that is no default.
    #[serde(skip)]
    provenance: BTreeMap<String, Provenance>,
}

impl Config {
    /// Reads a configuration: the defaults, over them the file's values, over them the overrides (`key=value`, the last
    /// one wins).
    ///
    /// # Errors
    /// [`ConfigErrors`] with everything that is wrong in the file and the overrides.
    pub fn load(path: Option<&Path>, overrides: &[String]) -> Result<Self, ConfigErrors> {
        let mut problems = Vec::new();
        let from_file = path.map_or_else(Vec::new, |path| source::read_file(path, &mut problems));
        let from_overrides: Vec<_> =
            overrides.iter().filter_map(|argument| source::read_override(argument, &mut problems)).collect();
        resolve::resolve(&from_file, &from_overrides, problems)
    }

    /// The configuration without file and overrides.
    ///
    /// # Errors
    /// None, unless table and typed structure disagree, which a test excludes.
    pub fn defaults() -> Result<Self, ConfigErrors> {
        Self::load(None, &[])
    }

    /// Where the value of a key comes from.
    pub fn provenance(&self, key: &str) -> &Provenance {
        self.provenance.get(key).unwrap_or(&Provenance::Default)
    }
}
