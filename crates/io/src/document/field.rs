//! Fields of a structured file: what is taken out of it, with errors that name file, line, field, found and expected.

use std::path::Path;

use super::{Node, Value};
use crate::dataset::DatasetError;
use crate::file::{counted, shown};

/// A part of a file that may be missing.
#[derive(Clone)]
pub(crate) struct Field<'a> {
    pub(crate) path: &'a Path,
    /// Its way from the top, as errors name it.
    pub(crate) name: String,
    node: Option<&'a Node>,
}

impl<'a> Field<'a> {
    /// The whole file.
    pub(crate) fn root(path: &'a Path, node: &'a Node) -> Self {
        Self { path, name: String::new(), node: Some(node) }
    }

    /// A field of a section; the last one of those with this name, as everywhere where a later value replaces an earlier one.
    pub(crate) fn at(&self, key: &str) -> Self {
        let node = self.entries().iter().rev().find(|(name, _)| name == key).map(|(_, node)| node);
        let name = if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) };
        Self { path: self.path, name, node }
    }

    /// A field as the top of a file: the outermost element of XML.
    pub(crate) fn inner(&self, key: &str) -> Self {
        Self { name: String::new(), ..self.at(key) }
    }

    /// The first of these fields that is there, else the first one.
    pub(crate) fn any(&self, keys: &[&str]) -> Self {
        let key = keys.iter().find(|key| self.at(key).is_there()).or(keys.first());
        self.at(key.copied().unwrap_or_default())
    }

    /// Whether something stands there.
    pub(crate) fn is_there(&self) -> bool {
        self.node.is_some_and(|node| node.value != Value::Nothing)
    }

    /// Itself if something stands there.
    pub(crate) fn there(self) -> Option<Self> {
        Some(self).filter(Self::is_there)
    }

    /// What `read` makes of it, if something stands there.
    ///
    /// # Errors
    /// Those of `read`.
    pub(crate) fn if_there<T>(
        &self,
        read: impl FnOnce(&Self) -> Result<T, DatasetError>,
    ) -> Result<Option<T>, DatasetError> {
        if self.is_there() { read(self).map(Some) } else { Ok(None) }
    }

    /// Names of the fields of a section.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'a str> {
        self.entries().iter().map(|(name, _)| name.as_str())
    }

    /// The items of a list; in XML the fields of a section.
    pub(crate) fn items(&self) -> Vec<Self> {
        let item =
            |i: usize, node| Self { path: self.path, name: format!("{}[{i}]", self.name), node: Some(node) };
        match self.node.map(|node| &node.value) {
            Some(Value::List(items)) => items.iter().enumerate().map(|(i, node)| item(i, node)).collect(),
            Some(Value::Section(entries)) => {
                entries.iter().enumerate().map(|(i, (_, node))| item(i, node)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Whether it is a list.
    pub(crate) fn is_list(&self) -> bool {
        matches!(self.node, Some(Node { value: Value::List(_), .. }))
    }

    /// The error of this field, with its line where it is there.
    pub(crate) fn error(&self, found: impl Into<String>, expected: impl Into<String>) -> DatasetError {
        let line = self.node.map_or(0, |node| node.line);
        let line = if line > 0 { format!(":{line}") } else { String::new() };
        DatasetError::Unexpected {
            path: self.path.to_path_buf(),
            place: format!("{line}: {}", self.name),
            found: found.into(),
            expected: expected.into(),
        }
    }

    /// The error of this field with what stands there.
    pub(crate) fn wrong(&self, expected: impl Into<String>) -> DatasetError {
        self.error(self.describe(), expected)
    }

    /// The error of a field that must be there; its line is not told, for there is none.
    ///
    /// # Errors
    /// The field is missing.
    pub(crate) fn need(&self, expected: &str) -> Result<(), DatasetError> {
        if self.is_there() { Ok(()) } else { Err(Self { node: None, ..self.clone() }.wrong(expected)) }
    }

    /// A word.
    ///
    /// # Errors
    /// The field is missing, or no word.
    pub(crate) fn text(&self, expected: &str) -> Result<&'a str, DatasetError> {
        match self.node.map(|node| &node.value) {
            Some(Value::Text(text)) => Ok(text),
            _ => Err(self.wrong(expected)),
        }
    }

    /// A finite number; also one in quotes.
    ///
    /// # Errors
    /// The field is missing, or no finite number.
    pub(crate) fn number(&self, expected: &str) -> Result<f64, DatasetError> {
        let number = match self.node.map(|node| &node.value) {
            Some(Value::Integer(value)) => Some(*value as f64),
            Some(Value::Real(value)) => Some(*value),
            Some(Value::Text(text)) => text.trim().parse().ok(),
            _ => None,
        };
        number.filter(|number: &f64| number.is_finite()).ok_or_else(|| self.wrong(expected))
    }

    /// The number, if the field is there.
    ///
    /// # Errors
    /// What stands there is no finite number.
    pub(crate) fn optional(&self, expected: &str) -> Result<Option<f64>, DatasetError> {
        self.if_there(|field| field.number(expected))
    }

    /// A number above 0.
    ///
    /// # Errors
    /// The field is missing, or not above 0.
    pub(crate) fn positive(&self, expected: &str) -> Result<f64, DatasetError> {
        let value = self.number(expected)?;
        if value > 0.0 { Ok(value) } else { Err(self.wrong(expected)) }
    }

    /// All numbers of a list, of a list of rows, of a matrix with `data`, or of a text with blanks between them.
    ///
    /// # Errors
    /// The field is missing, or something in it is not a finite number.
    pub(crate) fn numbers(&self, expected: &str) -> Result<Vec<f64>, DatasetError> {
        self.need(expected)?;
        if self.at("data").is_there() {
            // The line is that of the matrix.
            let data = Self { name: self.name.clone(), ..self.at("data") };
            return data.numbers(expected);
        }
        let mut numbers = Vec::new();
        match self.node.map(|node| &node.value) {
            Some(Value::List(_) | Value::Section(_)) => {
                for item in self.items() {
                    // A row, or a number; errors name the whole.
                    let item = Self { name: self.name.clone(), ..item };
                    if item.items().is_empty() {
                        numbers.push(item.number(expected)?);
                    } else {
                        numbers.extend(item.numbers(expected)?);
                    }
                }
            }
            Some(Value::Text(text)) => {
                for word in
                    text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty())
                {
                    let number = word.parse().ok().filter(|number: &f64| number.is_finite());
                    numbers.push(number.ok_or_else(|| self.error(shown(word), expected))?);
                }
            }
            _ => numbers.push(self.number(expected)?),
        }
        Ok(numbers)
    }

    /// `N` numbers.
    ///
    /// # Errors
    /// As [`Field::numbers`], or another count.
    pub(crate) fn exactly<const N: usize>(&self, expected: &str) -> Result<[f64; N], DatasetError> {
        let numbers = self.numbers(expected)?;
        <[f64; N]>::try_from(numbers.as_slice())
            .map_err(|_| self.error(counted(numbers.len(), "number"), expected))
    }

    /// What stands there, in few words.
    fn describe(&self) -> String {
        match self.node.map(|node| &node.value) {
            None | Some(Value::Nothing) => "nothing".to_owned(),
            Some(Value::Flag(flag)) => flag.to_string(),
            Some(Value::Integer(value)) => value.to_string(),
            Some(Value::Real(value)) => value.to_string(),
            Some(Value::Text(text)) => shown(text),
            Some(Value::List(items)) => {
                let inside = Self::root(self.path, self.node.unwrap_or(&NOTHING)).numbers("");
                inside.map_or_else(|_| format!("a list of {}", items.len()), |numbers| listed(&numbers))
            }
            Some(Value::Section(_)) => format!("a section ({})", self.keys().collect::<Vec<_>>().join(", ")),
        }
    }

    fn entries(&self) -> &'a [(String, Node)] {
        match self.node.map(|node| &node.value) {
            Some(Value::Section(entries)) => entries,
            _ => &[],
        }
    }
}

static NOTHING: Node = Node { line: 0, column: 0, value: Value::Nothing };

/// `[1, 2.5]`.
pub(crate) fn listed(numbers: &[f64]) -> String {
    // Adding 0 makes 0 of -0.
    let words: Vec<String> = numbers.iter().map(|number| (number + 0.0).to_string()).collect();
    format!("[{}]", words.join(", "))
}
