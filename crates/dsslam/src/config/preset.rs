//! Configurations that are part of the library: what is known to be best for the layouts of datasets.

use std::path::Path;

use dsfeat::Runner;
use features::SelectionRule;
use io::{ConfigErrors, Problem, Provenance, SequenceKind};

use super::Config;
use crate::NetworkOptions;

/// A built-in configuration.
struct Preset {
    name: &'static str,
    text: &'static str,
    /// The layout that it goes with.
    kind: Option<SequenceKind>,
}

const PRESETS: [Preset; 4] = [
    Preset { name: "default", text: "", kind: None },
    Preset { name: "euroc", text: include_str!("../../presets/euroc.yaml"), kind: Some(SequenceKind::Euroc) },
    Preset { name: "kitti", text: include_str!("../../presets/kitti.yaml"), kind: Some(SequenceKind::Kitti) },
    Preset {
        name: "tum-rgbd",
        text: include_str!("../../presets/tum-rgbd.yaml"),
        kind: Some(SequenceKind::TumRgbd),
    },
];

/// The camera of `tum-rgbd` is that of these sequences.
const TUM_FIRST: [&str; 2] = ["freiburg1", "fr1"];

/// Names of the built-in configurations.
pub fn presets() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|preset| preset.name)
}

/// Name and text of a built-in configuration, called `kitti` or `kitti.yaml`.
pub(super) fn find(name: &Path) -> Option<(&'static str, &'static str)> {
    let name = name.to_str()?;
    let name = name.strip_suffix(".yaml").unwrap_or(name);
    PRESETS.iter().find(|preset| preset.name == name).map(|preset| (preset.name, preset.text))
}

/// Whether a path has no folder in it and nothing of its name is there.
pub(super) fn is_name(path: &Path) -> bool {
    path.components().count() == 1 && !path.exists()
}

/// That a name is neither that of a file nor built in.
pub(super) fn unknown(name: &Path) -> ConfigErrors {
    let names: Vec<&str> = presets().collect();
    let message = format!(
        "no such file, expected a configuration in YAML or one of the built-in ones: {}",
        names.join(", ")
    );
    let place = Provenance::File { path: name.to_path_buf(), line: 0, column: 0 };
    ConfigErrors(vec![Problem { place, key: String::new(), message }])
}

/// The configuration that is best for a sequence as far as is known.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Chosen {
    /// The configuration.
    pub config: Config,
    /// Name of the built-in configuration that the layout of the folder has chosen.
    pub preset: Option<&'static str>,
    /// What the user should know of the choice.
    pub notices: Vec<String>,
}

impl Config {
    /// A built-in configuration: `kitti`, `euroc`, `tum-rgbd` or `default`.
    ///
    /// # Errors
    /// A name that is not among them.
    pub fn preset(name: &str) -> Result<Self, ConfigErrors> {
        let (name, text) = find(Path::new(name)).ok_or_else(|| unknown(Path::new(name)))?;
        Self::of_text(name, text, &[])
    }

    /// The built-in configuration that goes with the layout of a folder, with overrides (`key=value`) above it; the defaults where
    /// there is none.
    ///
    /// # Errors
    /// Everything that is wrong with the overrides.
    pub fn for_sequence(folder: impl AsRef<Path>, overrides: &[String]) -> Result<Chosen, ConfigErrors> {
        Self::choose(None, Some(folder.as_ref()), overrides, &NetworkOptions::default())
    }

    /// The configuration of `file`, which may also be the name of a built-in one; without it the one that goes with `folder`, as
    /// [`Config::for_sequence`] chooses it for this network.
    ///
    /// # Errors
    /// Everything that is wrong with the file and the overrides.
    pub fn choose(
        file: Option<&Path>,
        folder: Option<&Path>,
        overrides: &[String],
        network: &NetworkOptions,
    ) -> Result<Chosen, ConfigErrors> {
        let preset = folder.filter(|_| file.is_none()).and_then(for_layout);
        let config = match preset {
            Some(preset) => Self::of_text(preset.name, preset.text, overrides)?,
            None => Self::load(file, overrides)?,
        };
        let notices = network_notice(&config, network).into_iter().collect();
        Ok(Chosen { config, preset: preset.map(|preset| preset.name), notices })
    }
}

/// What the user should know of what runs the network: nothing where it is ONNX Runtime or no network is wanted.
fn network_notice(config: &Config, network: &NetworkOptions) -> Option<String> {
    let is_wanted = config.features.selection != SelectionRule::Response;
    let runner = is_wanted.then(|| dsfeat::runner(network.library.as_deref()));
    matches!(runner, Some(Ok(Runner::BuiltIn))).then(|| {
        format!(
            "ONNX Runtime was not found, so the network runs on the built-in engine, several times slower; {}",
            dsfeat::INSTALL
        )
    })
}

/// The built-in configuration that goes with what lies in a folder.
fn for_layout(folder: &Path) -> Option<&'static Preset> {
    let kind = match io::layout_of(folder)? {
        SequenceKind::KittiRaw | SequenceKind::Kitti360 => SequenceKind::Kitti,
        kind => kind,
    };
    let name = folder.canonicalize().ok()?;
    let name = name.file_name()?.to_string_lossy().into_owned();
    let fits = kind != SequenceKind::TumRgbd || TUM_FIRST.iter().any(|word| name.contains(word));
    PRESETS.iter().find(|preset| fits && preset.kind == Some(kind))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_or_without_its_ending_is_built_in() {
        for name in presets() {
            let config = Config::preset(name).unwrap();
            assert_eq!(Config::load(Some(Path::new(&format!("{name}.yaml"))), &[]).unwrap(), config);
        }
        assert_eq!(
            Config::preset("kitti").unwrap().provenance("features.keep").to_string(),
            "kitti (built in):6:9"
        );
        let error = Config::load(Some(Path::new("kiti")), &[]).unwrap_err().to_string();
        assert_eq!(
            error,
            "kiti: no such file, expected a configuration in YAML or one of the built-in ones: default, euroc, kitti, \
             tum-rgbd"
        );
    }

    #[test]
    fn the_layout_chooses_and_the_camera_of_one_series_is_not_taken_for_another() {
        let folder = tempfile::tempdir().unwrap();
        let chosen = |name: &str| Config::for_sequence(folder.path().join(name), &[]).unwrap();
        for name in ["rgbd_dataset_freiburg1_desk", "rgbd_dataset_freiburg2_desk", "mine"] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
            std::fs::write(folder.path().join(name).join("rgb.txt"), "").unwrap();
        }
        assert_eq!(chosen("rgbd_dataset_freiburg1_desk").preset, Some("tum-rgbd"));
        assert_eq!(chosen("rgbd_dataset_freiburg1_desk").config, Config::preset("tum-rgbd").unwrap());
        assert_eq!(chosen("rgbd_dataset_freiburg2_desk").preset, None);
        assert_eq!(chosen("nowhere").config, Config::default());
    }
}
