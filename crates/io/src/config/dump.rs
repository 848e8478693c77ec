//! The configuration in force as YAML, complete, with a comment per key; reading it back gives the same configuration.

use std::fmt::Write as _;

use serde_json::Value as Json;

use super::Config;
use super::problem::Provenance;
use super::schema::Entry;
use super::table::SCHEMA;

impl Config {
    /// All keys with the values in force, each with its meaning, unit and origin as a comment; keys that are absent
    /// stand there as comments.
    pub fn to_yaml(&self) -> String {
        let tree = serde_json::to_value(self).unwrap_or(Json::Null);
        let mut text = String::from("# Complete configuration, as in force.\n");
        let mut section = "";
        for entry in SCHEMA {
            // Writing to a string cannot fail.
            if entry.section() != section {
                section = entry.section();
                let _ = if section.is_empty() { writeln!(text) } else { writeln!(text, "\n{section}:") };
            }
            let value = &tree.pointer(&format!("/{}", entry.key.replace('.', "/"))).unwrap_or(&Json::Null);
            let indent = if section.is_empty() { "" } else { "  " };
            let comment = comment(entry, self.provenance(entry.key));
            let _ = match scalar(value) {
                Some(value) => writeln!(text, "{indent}{}: {value}  # {comment}", entry.name()),
                None => writeln!(text, "{indent}# {}:  # {comment}", entry.name()),
            };
        }
        text
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

fn comment(entry: &Entry, provenance: &Provenance) -> String {
    let unit = if entry.unit.is_empty() { String::new() } else { format!(" [{}]", entry.unit) };
    match provenance {
        Provenance::Default => format!("{}{unit}", entry.help),
        other => format!("{}{unit} ({})", entry.help, other.to_string().replace(['\n', '\r'], " ")),
    }
}
