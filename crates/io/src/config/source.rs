//! Reading of configuration files and `--set` arguments into a flat list of keys and values with their places.

use std::fmt;
use std::path::Path;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde_saphyr::Spanned;
use serde_saphyr::options::{DuplicateKeyPolicy, NonFiniteFloatPolicy};

use super::problem::{Problem, Provenance};
use super::value::Value;
use crate::file::TextFile;

/// A key with its value, as given.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Given {
    pub(super) key: String,
    pub(super) value: Value,
    pub(super) place: Provenance,
}

/// A YAML node, before anything is known about keys.
enum Node {
    Scalar(Value),
    List,
    Section(Vec<(Spanned<String>, Spanned<Node>)>),
}

/// Reads a file; what is wrong with its form is added to `problems`.
pub(super) fn read_file(path: &Path, problems: &mut Vec<Problem>) -> Vec<Given> {
    let whole = file_place(path, 0, 0);
    let file = match TextFile::read(path, "a configuration in YAML") {
        Ok(file) => file,
        Err(error) => {
            // The error names the file itself.
            let message = error.to_string();
            let message =
                message.strip_prefix(&format!("{}: ", path.display())).unwrap_or(&message).to_string();
            problems.push(Problem { place: whole, key: String::new(), message });
            return Vec::new();
        }
    };
    read_text(path, file.text(), problems)
}

/// Reads YAML that is called `path`; what is wrong with its form is added to `problems`.
pub(super) fn read_text(path: &Path, text: &str, problems: &mut Vec<Problem>) -> Vec<Given> {
    let mut given = Vec::new();
    match serde_saphyr::from_str_with_options::<Spanned<Node>>(text, options()) {
        Ok(root) => flatten(path, "", root, &mut given, problems),
        Err(error) => problems.push(syntax_problem(path, &error)),
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
    let value = match serde_saphyr::from_str_with_options::<Node>(text, options()) {
        Ok(Node::Scalar(value)) => value,
        _ => Value::Text(text.to_string()),
    };
    Some(Given { key: key.trim().to_string(), value, place })
}

/// Repeated keys and numbers that are not finite are let through, so that they are reported beside all other problems.
fn options() -> serde_saphyr::Options {
    serde_saphyr::options! {
        duplicate_keys: DuplicateKeyPolicy::PassThrough,
        non_finite_float_policy: NonFiniteFloatPolicy::PassThrough,
    }
}

/// Adds all values under a node; a key is its path with dots.
fn flatten(path: &Path, key: &str, node: Spanned<Node>, given: &mut Vec<Given>, problems: &mut Vec<Problem>) {
    let place = file_place(path, node.referenced.line(), node.referenced.column());
    match node.value {
        // An empty file is a configuration without wishes.
        Node::Scalar(Value::Nothing) if key.is_empty() => {}
        Node::Scalar(value) if key.is_empty() => {
            problems.push(Problem::new(&place, "", value, "sections with keys"))
        }
        Node::Scalar(value) => given.push(Given { key: key.to_string(), value, place }),
        Node::List => problems.push(Problem::new(&place, key, "a list", "one value or a section with keys")),
        Node::Section(entries) => {
            for (name, value) in entries {
                let key = if key.is_empty() { name.value } else { format!("{key}.{}", name.value) };
                flatten(path, &key, value, given, problems);
            }
        }
    }
}

fn file_place(path: &Path, line: u64, column: u64) -> Provenance {
    Provenance::File { path: path.to_path_buf(), line, column }
}

/// The parser's own message; its position has been printed already.
fn syntax_problem(path: &Path, error: &serde_saphyr::Error) -> Problem {
    let (line, column) = error.location().map_or((0, 0), |location| (location.line(), location.column()));
    let message = error.without_snippet().to_string();
    let message = message.strip_suffix(&format!(" at line {line}, column {column}")).unwrap_or(&message);
    let place = file_place(path, line, column);
    Problem { place, key: String::new(), message: format!("invalid YAML: {message}") }
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NodeVisitor)
    }
}

/// Takes any value.
struct NodeVisitor;

impl<'de> Visitor<'de> for NodeVisitor {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value or a section")
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Scalar(Value::Nothing))
    }

    fn visit_bool<E>(self, value: bool) -> Result<Node, E> {
        Ok(Node::Scalar(Value::Flag(value)))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Node, E> {
        Ok(Node::Scalar(Value::Integer(value)))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Node, E> {
        Ok(Node::Scalar(i64::try_from(value).map_or(Value::Real(value as f64), Value::Integer)))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Node, E> {
        Ok(Node::Scalar(Value::Real(value)))
    }

    fn visit_str<E>(self, value: &str) -> Result<Node, E> {
        Ok(Node::Scalar(Value::Text(value.to_string())))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Node, A::Error> {
        while items.next_element::<serde::de::IgnoredAny>()?.is_some() {}
        Ok(Node::List)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Node, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = map.next_entry()? {
            entries.push(entry);
        }
        Ok(Node::Section(entries))
    }
}
