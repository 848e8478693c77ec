//! What a run tells while it runs. Observers print, draw and count; nothing is read back.

use map::KeyframeId;
use slam::{KeyframeReason, MappingReport, OffsetEstimate, TrackStats};

use crate::record::FrameStatus;

/// One thing that happened.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// The run begins.
    Started {
        /// Frames to come.
        frames: usize,
    },
    /// A frame of the calibration pass is done; `done` of `frames`.
    Calibrating {
        /// Frames done.
        done: usize,
        /// Frames of the pass.
        frames: usize,
    },
    /// The calibration pass is over.
    Calibrated {
        /// What it found; `None`: nothing clear, the calibration stays as it is.
        estimate: Option<OffsetEstimate>,
    },
    /// A frame went through tracking.
    Frame {
        /// Number of the frame in its sequence.
        index: u32,
        /// What became of it.
        status: &'a FrameStatus,
        /// Counts of tracking.
        stats: TrackStats,
        /// Features in the frame, and of those with depth.
        features: usize,
        /// Features with a depth.
        with_depth: usize,
        /// Keyframes in the map.
        keyframes: usize,
        /// Points in the map.
        points: usize,
        /// Time from the decoded images to the pose, milliseconds.
        track_ms: f64,
    },
    /// A keyframe was inserted and its mapping is done.
    Keyframe {
        /// Its id.
        id: KeyframeId,
        /// The frame that it was.
        frame: u32,
        /// Why.
        reason: KeyframeReason,
        /// What mapping did.
        report: MappingReport,
    },
}

/// Listens to a run.
pub trait Observer {
    /// Something happened.
    fn event(&mut self, event: &Event<'_>);
}

/// Listens to nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {
    fn event(&mut self, _: &Event<'_>) {}
}
