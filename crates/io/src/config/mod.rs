//! Reading of configurations: defaults, a YAML file and `--set` arguments, in rising order of power, checked against a list of
//! keys. This module does not know which sections exist: they are the parameter structs of the crates that use them.

mod dump;
mod explain;
mod origins;
mod problem;
mod resolve;
mod sections;
mod source;
mod suggest;
mod value;

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use settings::Entry;

pub use dump::to_yaml;
pub use explain::{Explained, explain};
pub use origins::Origins;
pub use problem::{ConfigErrors, Problem, Provenance};
pub use sections::{CameraSettings, InputSettings};

/// Where a configuration is read from.
#[derive(Clone, Copy, Debug)]
pub enum ConfigSource<'a> {
    /// A file in YAML.
    File(&'a Path),
    /// YAML, and what messages call it.
    Text {
        /// What messages call it.
        name: &'a str,
        /// YAML.
        text: &'a str,
    },
}

/// Reads a configuration of these keys: the defaults, over them the file's values, over them the overrides (`key=value`, the
/// last one wins). `T` has a field for each section, and in it one for each key.
///
/// # Errors
/// [`ConfigErrors`] with everything that is wrong in the file and the overrides.
pub fn read_config<T: Default + Serialize + DeserializeOwned>(
    keys: &[Entry],
    source: Option<ConfigSource<'_>>,
    overrides: &[String],
) -> Result<(T, Origins), ConfigErrors> {
    let mut problems = Vec::new();
    let from_file = match source {
        None => Vec::new(),
        Some(ConfigSource::File(path)) => source::read_file(path, &mut problems),
        Some(ConfigSource::Text { name, text }) => source::read_text(Path::new(name), text, &mut problems),
    };
    let from_overrides: Vec<_> =
        overrides.iter().filter_map(|argument| source::read_override(argument, &mut problems)).collect();
    resolve::resolve(keys, &from_file, &from_overrides, problems)
}
