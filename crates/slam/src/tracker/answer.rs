//! What the tracker answers for a frame.

use std::sync::Arc;

use features::Frame;
use geometry::SE3;
use map::{PointCount, PointId, RelativePose};

use super::initializer::InitialPair;
use super::keyframe_policy::KeyframeReason;
use super::last_frame::LastFrame;
use crate::assess::Assessment;
use crate::lost::{Lost, NotReady};

/// Outcome of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackState {
    /// There is no map yet, and this frame cannot start one.
    NotReady(NotReady),
    /// This frame starts the map, or after a lasting loss a new sub-map.
    Started,
    /// The frame has a pose.
    Tracked,
    /// The frame has none.
    Lost(Lost),
}

/// Counts of one tracked frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TrackStats {
    /// Matches that the prediction was optimized with.
    pub predicted: usize,
    /// Points of the local map.
    pub local_points: usize,
    /// Points of the local map that should be visible.
    pub visible: usize,
    /// Matches before the last optimization.
    pub matches: usize,
    /// Inlier matches after it.
    pub inliers: usize,
    /// Whether the motion model failed and the reference keyframe or recovery gave the prediction.
    pub without_motion_model: bool,
    /// Whether the place index gave the prediction.
    pub relocalized: bool,
}

/// Where a new keyframe belongs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placement {
    /// It is the first one of a sub-map.
    NewSubmap {
        /// Its pose in the coordinates of the sub-map.
        cam_from_world: SE3,
    },
    /// It belongs to the sub-map of another keyframe; a map that changed meanwhile moves it along.
    Near(RelativePose),
}

/// A request to insert a keyframe.
#[derive(Clone, Debug)]
pub struct KeyframeRequest {
    /// The frame to insert.
    pub frame: Arc<Frame>,
    /// Where.
    pub placement: Placement,
    /// Matches of features with map points, sorted by feature.
    pub matches: Vec<(u32, PointId)>,
    /// Why.
    pub reason: KeyframeReason,
    /// Both views of a monocular start; `frame` is the second.
    pub pair: Option<Arc<InitialPair>>,
}

/// The answer of the tracker for one frame.
#[derive(Clone, Debug)]
pub struct Tracked {
    /// Outcome of the frame.
    pub state: TrackState,
    /// The pose, of a lost frame the last one known; `None` without a map, or while the first keyframe is being made.
    pub pose: Option<RelativePose>,
    /// Which points should have been seen and which were found, for the map's statistics.
    pub counts: Vec<PointCount>,
    /// A keyframe to insert, if one is due.
    pub keyframe: Option<KeyframeRequest>,
    /// Counts.
    pub stats: TrackStats,
    /// All matches of features with map points, sorted by feature.
    pub matched: Vec<(u32, PointId)>,
    /// Those of them that agree with the pose.
    pub inliers: Vec<(u32, PointId)>,
    /// How far features were moved to where their points look the same, `(feature, dx, dy)` in pixels.
    pub shifts: Vec<(u32, f32, f32)>,
    /// How far the pose is to be trusted.
    pub assessment: Assessment,
}

impl Tracked {
    /// The answer for a frame without a pose of its own.
    pub(super) fn without_pose(state: TrackState, last: Option<&LastFrame>) -> Self {
        Tracked {
            state,
            pose: last.map(|last| last.pose),
            counts: Vec::new(),
            keyframe: None,
            stats: TrackStats::default(),
            matched: Vec::new(),
            inliers: Vec::new(),
            shifts: Vec::new(),
            assessment: Assessment::default(),
        }
    }
}
