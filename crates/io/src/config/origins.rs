//! Where the values of a configuration come from.

use std::collections::BTreeMap;

use super::problem::Provenance;

/// Where each value of a configuration comes from that is not a default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origins(BTreeMap<String, Provenance>);

impl Origins {
    /// Where the value of a key comes from.
    pub fn of(&self, key: &str) -> &Provenance {
        self.0.get(key).unwrap_or(&Provenance::Default)
    }

    /// Notes a new origin of a key's value; returns the old one if it was not the default.
    pub fn set(&mut self, key: &str, origin: Provenance) -> Option<Provenance> {
        self.0.insert(key.to_owned(), origin)
    }
}
