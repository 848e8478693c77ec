//! The configuration in force, key by key, for people and tools.

use serde_json::Value as Json;

use super::Config;
use super::problem::Provenance;
use super::schema::Entry;
use super::table::SCHEMA;

/// A key with its value and where that comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Explained<'a> {
    /// Name, unit, range and meaning of the key.
    pub entry: &'static Entry,
    /// The value as YAML writes it; `None` where the key is absent.
    pub value: Option<String>,
    /// Who gave the value.
    pub place: &'a Provenance,
}

impl Config {
    /// All keys in the order of [`SCHEMA`], with the values in force.
    #[must_use]
    pub fn explain(&self) -> Vec<Explained<'_>> {
        let tree = serde_json::to_value(self).unwrap_or(Json::Null);
        let explained = |entry: &'static Entry| {
            let value = tree.pointer(&format!("/{}", entry.key.replace('.', "/")));
            let place = self.provenance(entry.key);
            Explained { entry, value: value.and_then(scalar), place }
        };
        SCHEMA.iter().map(explained).collect()
    }
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
