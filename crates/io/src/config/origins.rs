//! Where the values of a configuration come from.

use std::collections::BTreeMap;

use super::problem::Provenance;

/// Where each value of a configuration comes from that is not a default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origins {
    values: BTreeMap<String, Provenance>,
    renamed: Vec<String>,
}

impl Origins {
    /// Where the value of a key comes from.
    pub fn of(&self, key: &str) -> &Provenance {
        self.values.get(key).unwrap_or(&Provenance::Default)
    }

    /// Notes a new origin of a key's value; returns the old one if it was not the default.
    pub fn set(&mut self, key: &str, origin: Provenance) -> Option<Provenance> {
        self.values.insert(key.to_owned(), origin)
    }

    /// Keys of older configurations that were understood: where they stand, and what they are called now.
    pub fn renamed(&self) -> &[String] {
        &self.renamed
    }

    pub(super) fn note_renamed(&mut self, words: String) {
        self.renamed.push(words);
    }
}
