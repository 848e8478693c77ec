//! Reading of configuration files and `--set` arguments into a flat list of keys and values with their places.

use std::path::Path;

use super::problem::{Problem, Provenance};
use crate::document::{Node, SyntaxError, Value, parse_yaml};
use crate::file::TextFile;

/// A key with its value, as given.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Given {
    pub(super) key: String,
    pub(super) value: Value,
    pub(super) place: Provenance,
}

/// Reads a file; what is wrong with its form is added to `problems`.
pub(super) fn read_file(path: &Path, problems: &mut Vec<Problem>) -> Vec<Given> {
    let whole = file_place(path, 0, 0);
    let file = match TextFile::read(path, "a configuration in YAML") {
        Ok(file) => file,
        Err(error) => {
            // The error names the file itself.
            let message = error.to_string();
            let message = message
                .strip_prefix(&format!("{}:", path.display()))
                .unwrap_or(&message)
                .trim_start()
                .to_string();
            problems.push(Problem { place: whole, key: String::new(), message });
            return Vec::new();
        }
    };
    read_text(path, file.text(), problems)
}

/// Reads YAML that is called `path`; what is wrong with its form is added to `problems`.
pub(super) fn read_text(path: &Path, text: &str, problems: &mut Vec<Problem>) -> Vec<Given> {
    let mut given = Vec::new();
    match parse_yaml(text) {
        Ok(root) => flatten(path, "", root, &mut given, problems),
        Err(SyntaxError { line, column, message, .. }) => {
            let message = format!("invalid YAML: {message}");
            problems.push(Problem { place: file_place(path, line, column), key: String::new(), message });
        }
    }
    given
}

/// Takes `key=value` apart; the value is read as YAML reads it.
pub(super) fn read_override(argument: &str, problems: &mut Vec<Problem>) -> Option<Given> {
    let place = Provenance::Override(argument.to_string());
    let Some((key, text)) = argument.split_once('=') else {
        problems.push(Problem::new(&place, "", "no `=`", "key=value, such as features.keep=500"));
        return None;
    };
    let value = parse_yaml(text).ok().map(|node| node.value).filter(Value::is_scalar);
    let value = value.unwrap_or_else(|| Value::Text(text.to_string()));
    Some(Given { key: key.trim().to_string(), value, place })
}

/// Adds all values under a node; a key is its path with dots.
fn flatten(path: &Path, key: &str, node: Node, given: &mut Vec<Given>, problems: &mut Vec<Problem>) {
    let place = file_place(path, node.line, node.column);
    match node.value {
        // An empty file is a configuration without wishes.
        Value::Nothing if key.is_empty() => {}
        list @ Value::List(_) => {
            problems.push(Problem::new(&place, key, list, "one value or a section with keys"));
        }
        Value::Section(entries) => {
            for (name, value) in entries {
                let key = if key.is_empty() { name } else { format!("{key}.{name}") };
                flatten(path, &key, value, given, problems);
            }
        }
        value if key.is_empty() => {
            problems.push(Problem::new(&place, "", value, "sections with keys"));
        }
        value => given.push(Given { key: key.to_string(), value, place }),
    }
}

fn file_place(path: &Path, line: u64, column: u64) -> Provenance {
    Provenance::File { path: path.to_path_buf(), line, column }
}
