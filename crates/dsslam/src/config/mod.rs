//! The configuration: defaults, a YAML file, `--set` arguments, and the calibration of the dataset, in rising order of power.
//! Its sections are the parameter structs of the crates that use them: a new key stands there and nowhere else.

mod camera;
mod preset;
mod rules;

use std::path::Path;
use std::sync::LazyLock;

use features::{ExtractorConfig, StereoConfig};
use io::{
    CameraSettings, ConfigErrors, ConfigSource, Explained, InputSettings, Origins, Problem, Provenance,
};
use runtime::Lags;
use serde::{Deserialize, Serialize};
use settings::{Entry, Section, integer};
use slam::{LoopParams, MappingParams, TrackingParams, Weights};

pub use camera::CameraError;
pub use preset::{Chosen, presets};

/// A complete, checked configuration. [`SCHEMA`] documents its keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The camera, used where the dataset has no calibration file.
    pub camera: CameraSettings,
    /// What is read.
    pub input: InputSettings,
    /// Keypoints.
    pub features: ExtractorConfig,
    /// Where the activation of features counts.
    pub weights: Weights,
    /// Depth from two images.
    pub stereo: StereoConfig,
    /// Poses of frames.
    pub tracking: TrackingParams,
    /// The map.
    pub mapping: MappingParams,
    /// Places seen again.
    pub loops: LoopParams,
    /// How the stages of a run are scheduled.
    pub runtime: Lags,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Where each value comes from that is not a default.
    #[serde(skip)]
    origins: Origins,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            camera: CameraSettings::default(),
            input: InputSettings::default(),
            features: ExtractorConfig::default(),
            weights: Weights::default(),
            stereo: StereoConfig::default(),
            tracking: TrackingParams::default(),
            mapping: MappingParams::default(),
            loops: LoopParams::default(),
            runtime: Lags::default(),
            seed: 1,
            origins: Origins::default(),
        }
    }
}

/// All keys, in the order in which they are written.
pub static SCHEMA: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    let sections = [
        CameraSettings::KEYS,
        InputSettings::KEYS,
        ExtractorConfig::KEYS,
        Weights::KEYS,
        StereoConfig::KEYS,
        TrackingParams::KEYS,
        MappingParams::KEYS,
        LoopParams::KEYS,
        Lags::KEYS,
    ];
    let seed = integer("seed", "", [0, i64::MAX], "seed of all random numbers");
    sections.into_iter().flatten().copied().chain([seed]).collect()
});

impl Config {
    /// Reads a configuration: the defaults, over them the file's values, over them the overrides (`key=value`, the last
    /// one wins). A path that is not a file may name a built-in configuration, such as `kitti`.
    ///
    /// # Errors
    /// [`ConfigErrors`] with everything that is wrong in the file and the overrides.
    pub fn load(path: Option<&Path>, overrides: &[String]) -> Result<Self, ConfigErrors> {
        match path.filter(|path| !path.is_file()) {
            Some(path) => match preset::find(path) {
                Some((name, text)) => Self::of_text(name, text, overrides),
                None if preset::is_name(path) => Err(preset::unknown(path)),
                None => Self::of(Some(ConfigSource::File(path)), overrides),
            },
            None => {
                let read = Self::of(path.map(ConfigSource::File), overrides);
                read.map_err(|errors| path.and_then(calibration).unwrap_or(errors))
            }
        }
    }

    /// A built-in configuration.
    fn of_text(name: &str, text: &str, overrides: &[String]) -> Result<Self, ConfigErrors> {
        let name = format!("{name} (built in)");
        Self::of(Some(ConfigSource::Text { name: &name, text }), overrides)
    }

    fn of(source: Option<ConfigSource<'_>>, overrides: &[String]) -> Result<Self, ConfigErrors> {
        let (config, origins): (Self, Origins) = io::read_config(&SCHEMA, source, overrides)?;
        let config = Self { origins, ..config };
        let problems = rules::check(&config);
        if problems.is_empty() { Ok(config) } else { Err(ConfigErrors(problems)) }
    }

    /// Where the value of a key comes from.
    pub fn provenance(&self, key: &str) -> &Provenance {
        self.origins.of(key)
    }

    /// Keys of older versions that were given, with what they are called now.
    pub fn renamed_keys(&self) -> &[String] {
        self.origins.renamed()
    }

    /// All keys in the order of [`SCHEMA`], with the values in force.
    pub fn explain(&self) -> Vec<Explained<'_>> {
        io::explain(&SCHEMA, self, &self.origins)
    }

    /// All keys with the values in force as YAML, each with its meaning, unit and origin as a comment; keys that are absent
    /// stand there as comments. Reading it gives the same configuration.
    pub fn to_yaml(&self) -> String {
        io::to_yaml("Complete configuration, as in force.", &self.explain())
    }
}

/// What is wrong with a file that holds a calibration of cameras and no configuration; `None` for any other file.
fn calibration(file: &Path) -> Option<ConfigErrors> {
    /// Formats that look like the section `camera` of a configuration.
    const ALIKE: [&str; 2] = ["Replica cam_params.json", "intrinsics"];
    let format = io::read_calibration(file).ok()?.format;
    let place = Provenance::File { path: file.to_path_buf(), line: 0, column: 0 };
    let found = format!("a calibration of cameras ({format})");
    let problem = Problem::new(&place, "", found, "a configuration; --calib reads this file");
    (!ALIKE.contains(&format)).then(|| ConfigErrors(vec![problem]))
}
