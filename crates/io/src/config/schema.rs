//! The form of the schema: what a key is. The keys themselves stand in `table.rs`.

use std::fmt;

/// One key of the configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Dotted path, `section.key`.
    pub key: &'static str,
    /// Type and range.
    pub kind: Kind,
    /// Unit of the value, empty where it has none.
    pub unit: &'static str,
    /// Value when nobody gives one; `None`: the key may be absent (an `Option` in the typed structure).
    pub default: Option<Literal>,
    /// One line for the user.
    pub help: &'static str,
}

/// Type and range of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A whole number, bounds included.
    Integer {
        /// Smallest value.
        least: i64,
        /// Largest value.
        most: i64,
    },
    /// A finite number.
    Real(Range),
    /// `true` or `false`.
    Flag,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// The name of a file.
    File,
}

/// An interval of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower end.
    pub low: f64,
    /// Whether `low` itself is allowed.
    pub with_low: bool,
    /// Upper end, included; infinite for none.
    pub high: f64,
}

/// A value of the configuration.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    /// Nothing stands there.
    Nothing,
    /// A truth value.
    Flag(bool),
    /// A whole number.
    Integer(i64),
    /// Any other number.
    Real(f64),
    /// Anything else.
    Text(String),
}

/// A default in the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Literal {
    /// A truth value.
    Flag(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Real(f64),
    /// A word.
    Text(&'static str),
}

/// Numbers above `low`.
pub(super) const fn above(low: f64) -> Range {
    Range { low, with_low: false, high: f64::INFINITY }
}

/// Numbers from `low` to `high`, both included.
pub(super) const fn between(low: f64, high: f64) -> Range {
    Range { low, with_low: true, high }
}

/// Any finite number.
pub(super) const ANY: Range = Range { low: f64::NEG_INFINITY, with_low: true, high: f64::INFINITY };

/// A key with a number.
pub(super) const fn real(
    key: &'static str,
    default: f64,
    unit: &'static str,
    range: Range,
    help: &'static str,
) -> Entry {
    Entry { key, kind: Kind::Real(range), unit, default: Some(Literal::Real(default)), help }
}

/// A key with a number that may be absent.
pub(super) const fn optional_real(
    key: &'static str,
    unit: &'static str,
    range: Range,
    help: &'static str,
) -> Entry {
    Entry { key, kind: Kind::Real(range), unit, default: None, help }
}

/// A key with a whole number between `bounds[0]` and `bounds[1]`.
pub(super) const fn integer(
    key: &'static str,
    default: i64,
    unit: &'static str,
    bounds: [i64; 2],
    help: &'static str,
) -> Entry {
    let kind = Kind::Integer { least: bounds[0], most: bounds[1] };
    Entry { key, kind, unit, default: Some(Literal::Integer(default)), help }
}

/// A key with a whole number that may be absent.
pub(super) const fn optional_integer(
    key: &'static str,
    unit: &'static str,
    bounds: [i64; 2],
    help: &'static str,
) -> Entry {
    Entry { key, kind: Kind::Integer { least: bounds[0], most: bounds[1] }, unit, default: None, help }
}

/// A key with a truth value.
pub(super) const fn flag(key: &'static str, default: bool, help: &'static str) -> Entry {
    Entry { key, kind: Kind::Flag, unit: "", default: Some(Literal::Flag(default)), help }
}

/// A key with one of some words.
pub(super) const fn choice(
    key: &'static str,
    default: &'static str,
    words: &'static [&'static str],
    help: &'static str,
) -> Entry {
    Entry { key, kind: Kind::Choice(words), unit: "", default: Some(Literal::Text(default)), help }
}

/// A key with one of some words, which may be absent.
pub(super) const fn optional_choice(
    key: &'static str,
    words: &'static [&'static str],
    help: &'static str,
) -> Entry {
    Entry { key, kind: Kind::Choice(words), unit: "", default: None, help }
}

/// A key with the name of a file, which may be absent.
pub(super) const fn optional_file(key: &'static str, help: &'static str) -> Entry {
    Entry { key, kind: Kind::File, unit: "", default: None, help }
}

impl Entry {
    /// Section of the key, empty for a key at the top.
    pub fn section(&self) -> &'static str {
        self.key.rsplit_once('.').map_or("", |(section, _)| section)
    }

    /// The key within its section.
    pub fn name(&self) -> &'static str {
        self.key.rsplit_once('.').map_or(self.key, |(_, name)| name)
    }

    /// What a value must be, with range and unit, in words.
    pub fn expectation(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        match self.kind {
            Kind::Integer { least, most: i64::MAX } => format!("a whole number from {least}{unit} on"),
            Kind::Integer { least, most } => format!("a whole number from {least} to {most}{unit}"),
            Kind::Real(range) => range.expectation(&unit),
            Kind::Flag => "true or false".to_string(),
            Kind::Choice(words) => format!("one of {}", words.join(", ")),
            Kind::File => "the name of a file".to_string(),
        }
    }

    /// Whether a value has the type and lies in the range.
    pub(super) fn accepts(&self, value: &Value) -> bool {
        match (self.kind, value) {
            (Kind::Integer { least, most }, Value::Integer(value)) => (least..=most).contains(value),
            (Kind::Real(range), Value::Integer(value)) => range.contains(*value as f64),
            (Kind::Real(range), Value::Real(value)) => range.contains(*value),
            (Kind::Flag, Value::Flag(_)) => true,
            (Kind::Choice(words), Value::Text(text)) => words.contains(&text.as_str()),
            (Kind::File, Value::Text(text)) => !text.is_empty(),
            _ => false,
        }
    }
}

impl Range {
    /// Whether a finite number lies in the interval.
    pub fn contains(&self, value: f64) -> bool {
        let above_low = if self.with_low { value >= self.low } else { value > self.low };
        value.is_finite() && above_low && value <= self.high
    }

    fn expectation(&self, unit: &str) -> String {
        let Self { low, with_low, high } = self;
        match (low.is_finite(), with_low, high.is_finite()) {
            (false, _, false) => "a finite number".to_string(),
            (false, _, true) => format!("a number up to {high}{unit}"),
            (true, true, true) => format!("a number from {low} to {high}{unit}"),
            (true, true, false) => format!("a number from {low}{unit} on"),
            (true, false, true) => format!("a number above {low} and up to {high}{unit}"),
            (true, false, false) => format!("a number above {low}{unit}"),
        }
    }
}

impl From<Literal> for Value {
    fn from(literal: Literal) -> Self {
        match literal {
            Literal::Flag(flag) => Self::Flag(flag),
            Literal::Integer(integer) => Self::Integer(integer),
            Literal::Real(real) => Self::Real(real),
            Literal::Text(text) => Self::Text(text.to_string()),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => write!(f, "nothing"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Integer(integer) => write!(f, "{integer}"),
            Self::Real(real) => write!(f, "{real:?}"),
            Self::Text(text) => write!(f, "{text:?}"),
        }
    }
}
