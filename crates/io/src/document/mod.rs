//! A structured file (YAML, JSON, XML) as one value, whose parts know their lines. Formats are read out of it by [`Field`].

mod field;
mod xml;
mod yaml;

pub(crate) use field::{Field, listed};
pub(crate) use yaml::parse as parse_yaml;

use crate::file::TextFile;

/// A value with its place, from 1; 0 where it is not known.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) line: u64,
    pub(crate) column: u64,
    pub(crate) value: Value,
}

/// What stands in a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Nothing,
    Flag(bool),
    Integer(i64),
    Real(f64),
    Text(String),
    List(Vec<Node>),
    /// In the order of the file; XML may repeat a name.
    Section(Vec<(String, Node)>),
}

/// Text that is not of its format.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SyntaxError {
    /// From 1; 0 where it is not known.
    pub(crate) line: u64,
    pub(crate) column: u64,
    /// `YAML`, `JSON` or `XML`.
    pub(crate) format: &'static str,
    pub(crate) message: String,
}

/// The value of a file; its beginning tells the format.
///
/// # Errors
/// [`SyntaxError`] in the parser's words.
pub(crate) fn parse(file: &TextFile) -> Result<Node, SyntaxError> {
    match file.text().trim_start().chars().next() {
        Some('<') => xml::parse(file.text()),
        Some('{') => json(file.text()),
        _ => yaml::parse(&opencv_as_yaml(file.text())),
    }
}

/// YAML 1.0 of OpenCV's `FileStorage` as YAML that others read: without its directive and its tags.
fn opencv_as_yaml(text: &str) -> String {
    let plain = text.strip_prefix("%YAML:1.0").unwrap_or(text);
    let mut plain = plain.replace("!!opencv-matrix", "");
    for tag in ["!!opencv-nd-matrix", "!<tag:yaml.org,2002:opencv-matrix>"] {
        plain = plain.replace(tag, "");
    }
    plain
}

/// JSON keeps no lines.
fn json(text: &str) -> Result<Node, SyntaxError> {
    let error = |error: serde_json::Error| SyntaxError {
        line: error.line() as u64,
        column: error.column() as u64,
        format: "JSON",
        message: error.to_string(),
    };
    serde_json::from_str::<serde_json::Value>(text).map(node_of_json).map_err(error)
}

fn node_of_json(value: serde_json::Value) -> Node {
    use serde_json::Value as Json;
    let value = match value {
        Json::Null => Value::Nothing,
        Json::Bool(flag) => Value::Flag(flag),
        Json::Number(number) => number
            .as_i64()
            .map(Value::Integer)
            .or_else(|| number.as_f64().map(Value::Real))
            .unwrap_or(Value::Nothing),
        Json::String(text) => Value::Text(text),
        Json::Array(items) => Value::List(items.into_iter().map(node_of_json).collect()),
        Json::Object(entries) => {
            Value::Section(entries.into_iter().map(|(key, value)| (key, node_of_json(value))).collect())
        }
    };
    Node { line: 0, column: 0, value }
}
