//! One key of the configuration.

/// One key of the configuration. Its default is that of the parameter struct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Dotted path, `section.key`.
    pub key: &'static str,
    /// Type and range.
    pub kind: Kind,
    /// Unit of the value, empty where it has none.
    pub unit: &'static str,
    /// Whether the key may be absent: an `Option` in the parameter struct.
    pub is_optional: bool,
    /// Whether only somebody who knows the algorithms will want to change it.
    pub is_expert: bool,
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

/// Any finite number.
pub const ANY: Range = Range { low: f64::NEG_INFINITY, with_low: true, high: f64::INFINITY };

/// Numbers above `low`.
pub const fn above(low: f64) -> Range {
    Range { low, with_low: false, high: f64::INFINITY }
}

/// Numbers from `low` to `high`, both included.
pub const fn between(low: f64, high: f64) -> Range {
    Range { low, with_low: true, high }
}

/// A key with a number.
pub const fn real(key: &'static str, unit: &'static str, range: Range, help: &'static str) -> Entry {
    Entry { unit, ..entry(key, Kind::Real(range), help) }
}

/// A key with a number that may be absent.
pub const fn optional_real(key: &'static str, unit: &'static str, range: Range, help: &'static str) -> Entry {
    Entry { is_optional: true, ..real(key, unit, range, help) }
}

/// A key with a whole number between `bounds[0]` and `bounds[1]`.
pub const fn integer(key: &'static str, unit: &'static str, bounds: [i64; 2], help: &'static str) -> Entry {
    Entry { unit, ..entry(key, Kind::Integer { least: bounds[0], most: bounds[1] }, help) }
}

/// A key with a whole number that may be absent.
pub const fn optional_integer(
    key: &'static str,
    unit: &'static str,
    bounds: [i64; 2],
    help: &'static str,
) -> Entry {
    Entry { is_optional: true, ..integer(key, unit, bounds, help) }
}

/// A key with a truth value.
pub const fn flag(key: &'static str, help: &'static str) -> Entry {
    entry(key, Kind::Flag, help)
}

/// A key with one of some words.
pub const fn choice(key: &'static str, words: &'static [&'static str], help: &'static str) -> Entry {
    entry(key, Kind::Choice(words), help)
}

/// A key with one of some words, which may be absent.
pub const fn optional_choice(key: &'static str, words: &'static [&'static str], help: &'static str) -> Entry {
    Entry { is_optional: true, ..choice(key, words, help) }
}

/// A key with a file name, which may be absent.
pub const fn optional_file(key: &'static str, help: &'static str) -> Entry {
    Entry { is_optional: true, ..entry(key, Kind::File, help) }
}

const fn entry(key: &'static str, kind: Kind, help: &'static str) -> Entry {
    Entry { key, kind, unit: "", is_optional: false, is_expert: false, help }
}

impl Entry {
    /// The same key, listed only on request.
    pub const fn expert(self) -> Entry {
        Entry { is_expert: true, ..self }
    }

    /// Section of the key, empty for a key at the top.
    pub fn section(&self) -> &'static str {
        self.key.rsplit_once('.').map_or("", |(section, _)| section)
    }

    /// The key within its section.
    pub fn name(&self) -> &'static str {
        self.key.rsplit_once('.').map_or(self.key, |(_, name)| name)
    }

    /// What a value must be, with range and unit, as text.
    pub fn expectation(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        match self.kind {
            Kind::Integer { least, most: i64::MAX } => format!("a whole number, at least {least}{unit}"),
            Kind::Integer { least, most } => format!("a whole number from {least} to {most}{unit}"),
            Kind::Real(range) => range.expectation(&unit),
            Kind::Flag => "true or false".to_string(),
            Kind::Choice(words) => format!("one of {}", words.join(", ")),
            Kind::File => "a file name".to_string(),
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
            (true, true, false) => format!("a number, at least {low}{unit}"),
            (true, false, true) => format!("a number above {low} and up to {high}{unit}"),
            (true, false, false) => format!("a number above {low}{unit}"),
        }
    }
}
