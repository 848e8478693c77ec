//! What a run leaves: a record per frame, the map, the timings.

use geometry::SE3;
use map::{KeyframeId, Map};
use slam::{Lost, NotReady, OffsetEstimate};
use thiserror::Error;

use crate::timings::Timings;

/// What became of a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum FrameStatus {
    /// There was no map yet and the frame could not start one.
    NotReady(NotReady),
    /// The frame has a pose.
    Tracked {
        /// Map points that agree with the pose; 0 for the frame that started the map.
        inliers: usize,
    },
    /// Tracking failed.
    Lost(Lost),
    /// The images could not be used.
    Dropped(String),
}

impl FrameStatus {
    /// Whether the frame has a pose of its own.
    pub fn has_pose(&self) -> bool {
        matches!(self, FrameStatus::Tracked { .. })
    }
}

/// A frame after the run.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRecord {
    /// Number of the frame in its sequence.
    pub index: u32,
    /// Time, seconds.
    pub timestamp_s: f64,
    /// What became of it.
    pub status: FrameStatus,
    /// Final pose, after all corrections of the map; of lost and dropped frames the last one known, `None` before
    /// the map was started.
    pub world_from_cam: Option<SE3>,
}

/// A run's results. Complete up to where it was interrupted.
#[derive(Clone, Debug)]
pub struct RunOutcome {
    /// One record per frame that was read.
    pub frames: Vec<FrameRecord>,
    /// The map.
    pub map: Map,
    /// Disparity offset in force, pixels; see [`Setup`](crate::Setup).
    pub disparity_offset_px: f64,
    /// What the calibration pass found, if there was one and the images told.
    pub calibration: Option<OffsetEstimate>,
    /// Wall-clock times.
    pub timings: Timings,
    /// Whether the run was stopped before its last frame.
    pub interrupted: bool,
}

/// Why a run could not begin.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RunError {
    /// There is nothing to run on.
    #[error("the sequence has no frames")]
    NoFrames,
    /// The thread that decodes images could not be started.
    #[error("the decoding thread could not be started: {0}")]
    Thread(String),
}

/// A frame's pose relative to a keyframe, until the map is final.
#[derive(Clone, Debug)]
pub(crate) struct RelativePose {
    pub(crate) reference: KeyframeId,
    pub(crate) cam_from_reference: SE3,
}

impl RelativePose {
    /// The pose in the final map, through keyframes that were removed since.
    pub(crate) fn world_from_cam(&self, map: &Map) -> Option<SE3> {
        let (alive, reference_from_alive) = map.resolve_keyframe(self.reference)?;
        let alive_from_world = map.keyframe(alive)?.cam_from_world;
        Some((self.cam_from_reference * reference_from_alive * alive_from_world).normalized().inverse())
    }
}
