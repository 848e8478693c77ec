//! Tracking: a frame and an immutable map give a pose, or a reason why there is none.

mod keyframe_policy;
mod last_frame;
mod local_map;
mod pose;
mod predict;
mod recover;
mod velocity;

use std::sync::Arc;

use features::Frame;
use geometry::SE3;
use map::{KeyframeId, Map, PointCount, PointId};

use crate::lost::{Lost, NotReady};
use crate::params::Params;
use crate::probe::{Probe, Stage, staged};
use crate::world::World;
pub use keyframe_policy::KeyframeReason;
pub(crate) use keyframe_policy::stereo_observations;
use last_frame::LastFrame;
use local_map::{LocalMap, LocallyTracked};
use predict::{Attempt, Prediction};
use velocity::Velocity;

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackState {
    /// There is no map yet, and this frame cannot start one.
    NotReady(NotReady),
    /// This frame starts the map.
    Started,
    /// The frame has a pose.
    Tracked,
    /// The frame has none.
    Lost(Lost),
}

/// Counts of one tracked frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TrackStats {
    /// Matches that the prediction was optimised with.
    pub predicted: usize,
    /// Points of the local map.
    pub local_points: usize,
    /// Points of the local map that should be visible.
    pub visible: usize,
    /// Matches before the last optimisation.
    pub matches: usize,
    /// Inlier matches after it.
    pub inliers: usize,
    /// Whether the motion model failed and the reference keyframe or recovery gave the prediction.
    pub without_motion_model: bool,
}

/// A request to insert a keyframe; poses are relative, so that a map that changed meanwhile moves them along.
#[derive(Clone, Debug)]
pub struct KeyframeRequest {
    /// The frame to insert.
    pub frame: Arc<Frame>,
    /// The keyframe that its pose refers to; `None` for the first keyframe.
    pub reference: Option<KeyframeId>,
    /// Pose relative to the reference (of the world for the first keyframe).
    pub cam_from_reference: SE3,
    /// Matches of features with map points, sorted by feature.
    pub matches: Vec<(u32, PointId)>,
    /// Why.
    pub reason: KeyframeReason,
}

/// The answer of the tracker for one frame.
#[derive(Clone, Debug)]
pub struct Tracked {
    /// What became of the frame.
    pub state: TrackState,
    /// The keyframe that the pose refers to (`None` without a map, or while the first keyframe is being made).
    pub reference: Option<KeyframeId>,
    /// Pose relative to the reference keyframe; of a lost frame the last one known.
    pub cam_from_reference: SE3,
    /// Which points should have been seen and which were found, for the map's statistics.
    pub counts: Vec<PointCount>,
    /// A keyframe to insert, if one is due.
    pub keyframe: Option<KeyframeRequest>,
    /// Counts.
    pub stats: TrackStats,
}

/// The tracker's memory between two frames: the last frame and how the camera moved.
#[derive(Clone, Debug)]
pub struct Tracker {
    params: Params,
    last: Option<LastFrame>,
    /// How the camera moved between the last two frames; `None` after a start or a loss.
    velocity: Option<Velocity>,
    /// Index of the frame that last became a keyframe.
    last_keyframe_index: u32,
}

impl Tracker {
    /// A tracker that has seen nothing.
    pub fn new(params: Params) -> Self {
        Tracker { params, last: None, velocity: None, last_keyframe_index: 0 }
    }

    /// Finds the pose of `frame` in the map of `world`. `mapper_idle` says whether mapping waits for work; it must depend on frame
    /// numbers only where a run has to be repeatable.
    pub fn track(
        &mut self,
        frame: &Arc<Frame>,
        world: &World,
        mapper_idle: bool,
        probe: &mut dyn Probe,
    ) -> Tracked {
        let map = &world.map;
        let Some(last) = self.last.take().map(|last| last.refreshed(map)) else {
            return self.start(frame);
        };
        let last_cam_from_world = last.cam_from_world(map);
        let (local, stats) = match self.find_pose(frame, map, &last, probe) {
            Ok(found) => found,
            Err(lost) => return self.lose(last, lost),
        };
        let seconds = last.seconds_to(frame);
        self.velocity = Some(Velocity::between(&last_cam_from_world, &local.cam_from_world, seconds));
        let keyframe = staged(probe, Stage::Decide, || self.decide_keyframe(frame, map, &local, mapper_idle))
            .map(|reason| {
                self.last_keyframe_index = frame.index;
                KeyframeRequest {
                    frame: frame.clone(),
                    reference: Some(local.reference),
                    cam_from_reference: local.cam_from_reference,
                    matches: local.matches.clone(),
                    reason,
                }
            });
        self.last =
            Some(LastFrame::new(frame.clone(), local.reference, local.cam_from_reference, &local.matches));
        Tracked {
            state: TrackState::Tracked,
            reference: Some(local.reference),
            cam_from_reference: local.cam_from_reference,
            counts: local.counts,
            keyframe,
            stats,
        }
    }

    /// Tries the ways of prediction in turn, each confirmed by the local map. The reason of the attempt that came
    /// furthest is returned if all fail.
    fn find_pose(
        &self,
        frame: &Frame,
        map: &Map,
        last: &LastFrame,
        probe: &mut dyn Probe,
    ) -> Result<(LocallyTracked, TrackStats), Lost> {
        let attempts = match self.velocity {
            Some(_) => [Attempt::Motion, Attempt::Recovery],
            None => [Attempt::Recovery, Attempt::Motion],
        };
        let mut reason: Option<Lost> = None;
        for attempt in attempts {
            let lost = match staged(probe, Stage::Predict, || self.predict(attempt, frame, map, last)) {
                Err(lost) => lost,
                Ok(predicted) => {
                    let local = staged(probe, Stage::LocalMap, || {
                        LocalMap::gather(map, &predicted.matches, last.reference, &self.params.tracking)
                            .track(frame, map, &predicted, &self.params)
                    });
                    let (found, needed) = (local.matches.len(), self.params.tracking.min_inliers);
                    if found >= needed {
                        let stats = stats_of(&predicted, &local);
                        return Ok((local, stats));
                    }
                    Lost::TooFewLocalInliers { found, needed }
                }
            };
            reason = Some(reason.map_or(lost, |earlier| earlier.further(lost)));
        }
        Err(reason
            .unwrap_or(Lost::TooFewMatches { found: 0, needed: self.params.tracking.min_reference_matches }))
    }

    /// Asks for the first keyframe if the frame has enough depth.
    fn start(&mut self, frame: &Arc<Frame>) -> Tracked {
        let found = (0..frame.len()).filter(|&feature| frame.has_depth(feature)).count();
        let needed = self.params.tracking.min_initial_depths;
        let mut tracked = Tracked {
            state: TrackState::NotReady(NotReady::TooFewDepths { found, needed, features: frame.len() }),
            reference: None,
            cam_from_reference: SE3::identity(),
            counts: Vec::new(),
            keyframe: None,
            stats: TrackStats::default(),
        };
        if found >= needed {
            tracked.state = TrackState::Started;
            tracked.keyframe = Some(KeyframeRequest {
                frame: frame.clone(),
                reference: None,
                cam_from_reference: SE3::identity(),
                matches: Vec::new(),
                reason: KeyframeReason::First,
            });
            self.last_keyframe_index = frame.index;
            self.velocity = None;
            self.last = Some(LastFrame::first(frame.clone()));
        }
        tracked
    }

    /// Keeps the last good frame, so that recovery starts from it.
    fn lose(&mut self, last: LastFrame, lost: Lost) -> Tracked {
        self.velocity = None;
        let tracked = Tracked {
            state: TrackState::Lost(lost),
            reference: Some(last.reference),
            cam_from_reference: last.cam_from_reference,
            counts: Vec::new(),
            keyframe: None,
            stats: TrackStats::default(),
        };
        self.last = Some(last);
        tracked
    }
}

fn stats_of(predicted: &Prediction, local: &LocallyTracked) -> TrackStats {
    TrackStats {
        predicted: predicted.matches.len(),
        local_points: local.n_points,
        visible: local.counts.len(),
        matches: local.n_matches,
        inliers: local.matches.len(),
        without_motion_model: predicted.without_motion_model,
    }
}
