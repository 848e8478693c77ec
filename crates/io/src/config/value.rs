//! A value of the configuration as somebody gave it.

use std::fmt;

use serde_json::Value as Json;
use settings::{Entry, Kind};

use crate::document::Value;

impl Value {
    /// Whether it is one value.
    pub(super) fn is_scalar(&self) -> bool {
        !matches!(self, Self::List(_) | Self::Section(_))
    }

    /// The whole number that it is, however it is written (`500.0`, `5e2`).
    fn as_integer(&self) -> Option<i64> {
        /// Beyond it a real number does not tell one whole number from the next.
        const EXACT: f64 = 9.0e15;
        match self {
            Self::Integer(value) => Some(*value),
            Self::Real(value) if value.fract() == 0.0 && value.abs() <= EXACT => Some(*value as i64),
            _ => None,
        }
    }

    /// The value as the key's type wants it.
    pub(super) fn for_entry(&self, entry: &Entry) -> Self {
        match (entry.kind, self.as_integer()) {
            (Kind::Integer { .. }, Some(integer)) => Self::Integer(integer),
            _ => self.clone(),
        }
    }

    /// Whether it has the type of the key and lies in its range.
    pub(super) fn is_accepted_by(&self, entry: &Entry) -> bool {
        match (entry.kind, self) {
            (Kind::Integer { least, most }, value) => {
                value.as_integer().is_some_and(|n| (least..=most).contains(&n))
            }
            (Kind::Real(range), Self::Integer(value)) => range.contains(*value as f64),
            (Kind::Real(range), Self::Real(value)) => range.contains(*value),
            (Kind::Flag, Self::Flag(_)) => true,
            (Kind::Choice(words), Self::Text(text)) => words.contains(&text.as_str()),
            (Kind::File, Self::Text(text)) => !text.is_empty(),
            _ => false,
        }
    }
}

impl From<&Value> for Json {
    fn from(value: &Value) -> Self {
        match value {
            Value::Nothing => Self::Null,
            Value::Flag(flag) => Self::Bool(*flag),
            Value::Integer(integer) => Self::from(*integer),
            Value::Real(real) => Self::from(*real),
            Value::Text(text) => Self::String(text.clone()),
            // No key takes them.
            Value::List(_) | Value::Section(_) => Self::Null,
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
            Self::List(_) => write!(f, "a list"),
            Self::Section(_) => write!(f, "a section"),
        }
    }
}
