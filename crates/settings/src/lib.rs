//! What a key of the configuration is: its type, range, unit and meaning.
//!
//! A section of the configuration *is* the parameter struct of the crate that uses it. The struct's fields are the keys, its
//! `Default` holds the default values, and [`Section::KEYS`] beside it says what each key may be. A field without a key is a
//! parameter that only code can set.

mod entry;

pub use entry::{
    ANY, Entry, Kind, Range, above, between, choice, flag, integer, optional_choice, optional_file,
    optional_integer, optional_real, real,
};

/// A parameter struct that is a section of the configuration.
pub trait Section {
    /// Its keys, in the order in which they are written; each is the section's name, a dot and the field's name.
    const KEYS: &'static [Entry];
}
