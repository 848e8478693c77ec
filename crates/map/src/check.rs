//! `check`: recounts every invariant of the map from scratch and names what is broken.

mod graph;
mod history;
mod numbers;
mod observations;
mod violation;

pub use violation::Violation;

use crate::Map;

impl Map {
    /// Asserts every invariant, without relying on the bookkeeping of the mutations.
    ///
    /// # Errors
    /// All violations found, with the ids that they concern, in a fixed order.
    pub fn check(&self) -> Result<(), Vec<Violation>> {
        let mut found = Vec::new();
        self.check_ids(&mut found);
        self.check_history(&mut found);
        self.check_observations(&mut found);
        self.check_covisibility(&mut found);
        self.check_tree(&mut found);
        self.check_loop_edges(&mut found);
        self.check_closed_loops(&mut found);
        self.check_numbers(&mut found);
        if found.is_empty() { Ok(()) } else { Err(found) }
    }
}
