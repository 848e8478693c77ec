//! The configuration in force as YAML, with a comment per key; reading it back gives the same configuration.

use std::fmt::Write as _;

use settings::Entry;

use super::explain::Explained;
use super::problem::Provenance;

/// These keys with the values in force, each with its meaning, unit and origin as a comment; keys that are absent stand there as
/// comments. `title` is the first line.
pub fn to_yaml(title: &str, explained: &[Explained<'_>]) -> String {
    let mut text = format!("# {title}\n");
    let mut section = "";
    for Explained { entry, value, place } in explained {
        // Writing to a string cannot fail.
        if entry.section() != section {
            section = entry.section();
            let _ = if section.is_empty() { writeln!(text) } else { writeln!(text, "\n{section}:") };
        }
        let indent = if section.is_empty() { "" } else { "  " };
        let comment = comment(entry, place);
        let _ = match value {
            Some(value) => writeln!(text, "{indent}{}: {value}  # {comment}", entry.name()),
            None => writeln!(text, "{indent}# {}:  # {comment}", entry.name()),
        };
    }
    text
}

fn comment(entry: &Entry, provenance: &Provenance) -> String {
    let unit = if entry.unit.is_empty() { String::new() } else { format!(" [{}]", entry.unit) };
    match provenance {
        Provenance::Default => format!("{}{unit}", entry.help),
        other => format!("{}{unit} ({})", entry.help, other.to_string().replace(['\n', '\r'], " ")),
    }
}
