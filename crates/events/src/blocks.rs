//! How a scene is divided, so that a change causes little to be sent again.

use std::collections::BTreeSet;

/// Points, by id, that are drawn together.
pub const POINTS_PER_BLOCK: u32 = 1024;
/// Keyframes, by id, that are drawn together.
pub const KEYFRAMES_PER_BLOCK: u32 = 64;
/// Frames, by number, whose path is drawn together.
pub const PATH_PER_BLOCK: u32 = 64;

/// Blocks that have to be redrawn.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Dirty {
    /// Of points.
    pub points: BTreeSet<u32>,
    /// Of keyframes.
    pub keyframes: BTreeSet<u32>,
    /// Of edges, by their newer keyframe.
    pub edges: BTreeSet<u32>,
    /// Of the path.
    pub path: BTreeSet<u32>,
}

impl Dirty {
    pub(crate) fn point(&mut self, id: u32) {
        self.points.insert(id / POINTS_PER_BLOCK);
    }

    pub(crate) fn keyframe(&mut self, id: u32) {
        self.keyframes.insert(id / KEYFRAMES_PER_BLOCK);
        self.edges.insert(id / KEYFRAMES_PER_BLOCK);
    }

    /// A block's path goes on to the first frame of the next block.
    pub(crate) fn frame(&mut self, index: u32) {
        self.path.insert(index / PATH_PER_BLOCK);
        if index.is_multiple_of(PATH_PER_BLOCK) && index > 0 {
            self.path.insert(index / PATH_PER_BLOCK - 1);
        }
    }
}
