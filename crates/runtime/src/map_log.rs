//! What mapping leaves beside the map: its journal, its loops, its times.

use map::KeyframeId;

use crate::corrections::StageTimes;
use crate::journal::Operation;

/// A loop that was looked at closely.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopRecord {
    /// Number of the frame that saw a place again.
    pub frame: u32,
    /// Its keyframe.
    pub keyframe: KeyframeId,
    /// Number of the frame of the earlier visit.
    pub matched_frame: u32,
    /// Its keyframe.
    pub matched: KeyframeId,
    /// What became of it.
    pub result: LoopResult,
}

/// What became of a loop.
#[derive(Clone, Debug, PartialEq)]
pub enum LoopResult {
    /// The map was corrected.
    Closed {
        /// Matches that agree with the loop's geometry.
        inliers: usize,
        /// How far the keyframe moved, metres.
        moved_m: f64,
        /// How far it turned, degrees.
        turned_deg: f64,
        /// Whether two sub-maps became one.
        joined: bool,
    },
    /// The places look alike, but are not the same, with the reason.
    Rejected(String),
    /// The map refused the correction, with the reason.
    Refused(String),
}

/// How often things happened in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Loops closed.
    pub loops_closed: usize,
    /// Loops looked at and rejected, or refused by the map.
    pub loops_rejected: usize,
    /// Global bundle adjustments taken over.
    pub globals_adopted: usize,
    /// Global bundle adjustments given up, since another loop was closed meanwhile.
    pub globals_discarded: usize,
    /// Sub-maps started after a lasting loss.
    pub submaps_started: usize,
    /// Sub-maps joined to another one by a loop.
    pub submaps_joined: usize,
    /// Times that a lost camera, or one in a map from a file, found its place again.
    pub relocalisations: usize,
}

/// A frame that became a keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InsertedFrame {
    /// Position in the feed.
    pub(crate) n: usize,
    /// Number in its sequence.
    pub(crate) index: u32,
    pub(crate) keyframe: KeyframeId,
}

/// Complete up to the last operation, even if the stage fails at the next.
#[derive(Default)]
pub(crate) struct MapLog {
    pub(crate) operations: Vec<Operation>,
    /// In the order of their ids.
    pub(crate) inserted: Vec<InsertedFrame>,
    pub(crate) loops: Vec<LoopRecord>,
    pub(crate) statistics: Statistics,
    /// Times by position of the frame that they belong to.
    pub(crate) times: Vec<(usize, StageTimes)>,
    /// Whether corrections were still to come when the run was interrupted.
    pub(crate) cut_short: bool,
}
