//! A loop is applied: the map is corrected, then duplicates on its two sides become one.

use map::{KeyframeId, MapError};

use super::Mapper;
use crate::loops::LoopCorrection;

/// Keyframes around the new side into which the earlier visit's points are projected.
const NEIGHBORS: usize = 10;

impl Mapper {
    pub(super) fn apply_loop(&mut self, found: &LoopCorrection) -> Result<(), MapError> {
        // The new side as it is before both sides share points.
        let around =
            self.world.map.keyframe(found.keyframe).map_or(&[][..], |kf| kf.best_covisible(NEIGHBORS));
        let targets: Vec<KeyframeId> =
            std::iter::once(found.keyframe).chain(around.iter().map(|&(id, _)| id)).collect();
        self.world.map.apply_correction(&found.correction)?;
        for target in targets {
            self.fuse_into(target, &found.earlier_points);
        }
        debug_assert_eq!(self.world.map.check(), Ok(()), "after the loop at keyframe {:?}", found.keyframe);
        Ok(())
    }
}

#[cfg(test)]
#[path = "../../tests/steps/close_loop.rs"]
mod tests;
