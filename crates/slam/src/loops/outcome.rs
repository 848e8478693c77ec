//! What became of the search for a loop, as values with numbers.

use std::fmt;

use super::LoopCorrection;
use map::KeyframeId;

/// The answer for one keyframe.
#[derive(Clone, Debug)]
pub enum LoopOutcome {
    /// No place looks alike; the normal case.
    None(NoLoop),
    /// A place looked alike for long enough, but it is not the same.
    Rejected {
        /// The keyframe of the earlier visit.
        candidate: KeyframeId,
        /// Why it was refused.
        reason: NoLoop,
    },
    /// The place is the same.
    Closed(Box<LoopCorrection>),
}

/// Why there is no loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoLoop {
    /// No other keyframe shares enough with this one.
    Alone,
}

impl fmt::Display for NoLoop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoLoop::Alone => f.write_str("no other place looks alike"),
        }
    }
}
