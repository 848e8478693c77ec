//! Names of keyframes and points: dense, given out in order of insertion, never reused.

use std::fmt;

/// Names a keyframe of one map for ever; the n-th inserted keyframe has the value n.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeyframeId(pub u32);

/// Names a point of one map for ever; the n-th inserted point has the value n.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PointId(pub u32);

/// An id that indexes an [`Arena`](crate::arena::Arena).
pub(crate) trait Id: Copy + fmt::Display {
    fn from_index(index: usize) -> Self;
    fn index(self) -> usize;
}

impl Id for KeyframeId {
    fn from_index(index: usize) -> Self {
        KeyframeId(u32::try_from(index).expect("fewer than 2^32 keyframes"))
    }

    fn index(self) -> usize {
        self.0 as usize
    }
}

impl Id for PointId {
    fn from_index(index: usize) -> Self {
        PointId(u32::try_from(index).expect("fewer than 2^32 points"))
    }

    fn index(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for KeyframeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "K{}", self.0)
    }
}

impl fmt::Display for PointId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "P{}", self.0)
    }
}
