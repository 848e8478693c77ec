//! The configuration in force, key by key, for people and tools.

use serde::Serialize;
use serde_json::Value as Json;
use settings::Entry;

use super::origins::Origins;
use super::problem::Provenance;

/// A key with its value and where that comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Explained<'a> {
    /// Name, unit, range and meaning of the key.
    pub entry: &'a Entry,
    /// The value as YAML writes it; `None` where the key is absent.
    pub value: Option<String>,
    /// Who gave the value.
    pub place: &'a Provenance,
}

/// These keys, in their order, with the values in force.
pub fn explain<'a>(keys: &'a [Entry], config: &impl Serialize, origins: &'a Origins) -> Vec<Explained<'a>> {
    let tree = serde_json::to_value(config).unwrap_or(Json::Null);
    let explained = |entry: &'a Entry| {
        let value = tree.pointer(&format!("/{}", entry.key.replace('.', "/")));
        Explained { entry, value: value.and_then(scalar), place: origins.of(entry.key) }
    };
    keys.iter().map(explained).collect()
}

/// A value as YAML writes it, `None` where there is none.
fn scalar(value: &Json) -> Option<String> {
    match value {
        Json::Null => None,
        Json::String(text) if text.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c)) => {
            Some(text.clone())
        }
        other => Some(other.to_string()),
    }
}
