//! What a run leaves: a record per frame, the map, the loops, the timings.

use std::sync::Arc;

use std::fmt;

use events::FrameState;
use features::ActivationError;
use geometry::SE3;
use io::{ImageError, ImageSize};
use map::{KeyframeId, Map};
use slam::{Assessment, Lost, NotReady, RefinedCalibration};
use thiserror::Error;

use crate::failure::StageFailure;
use crate::journal::{Journal, JournalError};
use crate::timings::Timings;

/// Outcome of a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum FrameStatus {
    /// There was no map yet and the frame could not start one.
    NotReady(NotReady),
    /// The frame has a pose.
    Tracked {
        /// Map points that agree with the pose; 0 for a frame that started a map.
        inliers: usize,
    },
    /// Tracking failed.
    Lost(Lost),
    /// The images could not be used, or came while tracking was behind.
    Dropped(Unusable),
}

impl FrameStatus {
    /// Whether the frame has a pose of its own.
    pub fn has_pose(&self) -> bool {
        matches!(self, FrameStatus::Tracked { .. })
    }

    /// Its state alone.
    pub fn state(&self) -> FrameState {
        match self {
            FrameStatus::NotReady(_) => FrameState::NotReady,
            FrameStatus::Tracked { .. } => FrameState::Tracked,
            FrameStatus::Lost(_) => FrameState::Lost,
            FrameStatus::Dropped(_) => FrameState::Dropped,
        }
    }

    /// Map points that agree with its pose; `None` without a pose.
    pub fn inliers(&self) -> Option<usize> {
        match self {
            FrameStatus::Tracked { inliers } => Some(*inliers),
            _ => None,
        }
    }

    /// Why it has no pose, in words; `None` if it has one.
    pub fn reason(&self) -> Option<String> {
        match self {
            FrameStatus::NotReady(reason) => Some(reason.to_string()),
            FrameStatus::Tracked { .. } => None,
            FrameStatus::Lost(reason) => Some(reason.to_string()),
            FrameStatus::Dropped(reason) => Some(reason.to_string()),
        }
    }

    /// The reason in a few words without numbers and names, the same for every frame that has it; `None` with a pose.
    pub fn cause(&self) -> Option<&'static str> {
        match self {
            FrameStatus::NotReady(reason) => Some(reason.cause()),
            FrameStatus::Tracked { .. } => None,
            FrameStatus::Lost(reason) => Some(reason.cause()),
            FrameStatus::Dropped(reason) => Some(reason.cause()),
        }
    }
}

impl fmt::Display for FrameStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FrameStatus::NotReady(_) => f.write_str("waiting for initialization"),
            FrameStatus::Tracked { inliers } => write!(f, "tracking {inliers} points"),
            FrameStatus::Lost(_) => f.write_str("lost"),
            FrameStatus::Dropped(_) => f.write_str("frame dropped"),
        }
    }
}

/// Why the images of a frame give no features.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Unusable {
    /// An image cannot be read, or is not the one that the camera takes.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// An image does not have the size of its camera.
    #[error(
        "the {image} image is {} x {} pixels, expected {} x {}",
        found.width, found.height, expected.width, expected.height
    )]
    Size {
        /// `left`, `right` or `depth`.
        image: &'static str,
        /// Its size.
        found: ImageSize,
        /// That of the camera.
        expected: ImageSize,
    },
    /// An image that the sensor has is not there.
    #[error("the {0} image is missing")]
    Missing(&'static str),
    /// There is an image of a camera that the calibration does not know.
    #[error("found no rectification of the {0} image")]
    Unrectified(&'static str),
    /// The network that selects features does not work.
    #[error(transparent)]
    Network(#[from] ActivationError),
    /// The frame came while tracking was behind.
    #[error("skipped: tracking was behind")]
    Skipped,
}

impl Unusable {
    /// The reason in a few words without numbers and names.
    pub fn cause(&self) -> &'static str {
        match self {
            Unusable::Image(ImageError::Missing { .. }) | Unusable::Missing(_) => "an image is missing",
            Unusable::Image(ImageError::WrongSize { .. }) | Unusable::Size { .. } => {
                "an image has another size than expected"
            }
            Unusable::Image(_) => "an image cannot be read",
            Unusable::Unrectified(_) => "a camera is not calibrated",
            Unusable::Network(_) => "the network does not work",
            Unusable::Skipped => "tracking was behind",
        }
    }
}

/// A frame after the run.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRecord {
    /// Number of the frame in its sequence.
    pub index: u32,
    /// Time, seconds.
    pub timestamp_s: f64,
    /// Its outcome.
    pub status: FrameStatus,
    /// Final pose, after all corrections of the map; of lost and dropped frames the last one known, `None` before
    /// the map was started.
    pub world_from_cam: Option<SE3>,
    /// The sub-map that the pose belongs to, named by the root of its keyframes. Poses of different sub-maps are in
    /// unrelated coordinate frames.
    pub submap: Option<KeyframeId>,
    /// How far the pose is to be trusted, with its covariance, as tracking saw it.
    pub assessment: Assessment,
}

impl FrameRecord {
    /// A frame of no known sub-map, whose pose was not assessed.
    pub fn new(index: u32, timestamp_s: f64, status: FrameStatus, world_from_cam: Option<SE3>) -> Self {
        let (submap, assessment) = (None, Assessment::default());
        Self { index, timestamp_s, status, world_from_cam, submap, assessment }
    }
}

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
    /// Its outcome.
    pub result: LoopResult,
}

/// Outcome of a loop.
#[derive(Clone, Debug, PartialEq)]
pub enum LoopResult {
    /// The map was corrected.
    Closed {
        /// Matches that agree with the loop's geometry.
        inliers: usize,
        /// How far the keyframe moved, meters.
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
    /// It had been closed, and was taken back for loops that contradict it; the last of them is closed instead.
    TakenBack {
        /// Number of the frame that this one starts from.
        by: u32,
    },
}

/// How often things happened in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Loops closed.
    pub loops_closed: usize,
    /// Loops that were closed and taken back later.
    pub loops_taken_back: usize,
    /// Loops looked at and rejected, or refused by the map.
    pub loops_rejected: usize,
    /// Global bundle adjustments applied.
    pub globals_adopted: usize,
    /// Global bundle adjustments discarded, since another loop was closed meanwhile.
    pub globals_discarded: usize,
    /// Sub-maps started after a lasting loss.
    pub submaps_started: usize,
    /// Sub-maps joined to another one by a loop.
    pub submaps_joined: usize,
    /// Times that a lost camera, or one in a map from a file, found its place again.
    pub relocalizations: usize,
}

/// A run's results. Complete up to where it was interrupted or where a stage failed.
#[derive(Clone, Debug)]
pub struct RunOutcome {
    /// One record per frame that was read.
    pub frames: Vec<FrameRecord>,
    /// The map; after a failure of mapping the last state that was shown to tracking.
    pub map: Map,
    /// Loops that were looked at closely, in order.
    pub loops: Vec<LoopRecord>,
    /// How often things happened.
    pub statistics: Statistics,
    /// Disparity offset in force, pixels; see [`Setup`](crate::Setup).
    pub disparity_offset_px: f64,
    /// The calibration that the images told, where it is not the given one.
    pub calibration: Option<Arc<RefinedCalibration>>,
    /// Wall-clock times.
    pub timings: Timings,
    /// In which order things happened; [`replay`](crate::replay) does the same again.
    pub journal: Journal,
    /// Whether the run was stopped before its last frame or its last correction.
    pub interrupted: bool,
    /// The stage that ended the run, if one did.
    pub failure: Option<StageFailure>,
}

/// Why a run could not begin.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RunError {
    /// There is nothing to run on.
    #[error("the sequence has no frames")]
    NoFrames,
    /// A thread could not be started.
    #[error("the thread `{stage}` could not be started: {reason}")]
    Thread {
        /// Its name.
        stage: &'static str,
        /// What the operating system says.
        reason: String,
    },
    /// The journal cannot be replayed.
    #[error("the journal cannot be replayed: {0}")]
    Journal(#[from] JournalError),
}
