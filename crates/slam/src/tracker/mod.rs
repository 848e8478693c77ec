//! Tracking: a frame and an immutable map give a pose, or a reason why there is none.

mod align;
mod assessor;
mod beliefs;
mod directions;
mod evidence;
mod inertia;
mod initializer;
mod keyframe_policy;
mod last_frame;
mod local_map;
mod loss;
mod motion_model;
mod predict;
mod relocalize;
mod residuals;
mod track_reference_keyframe;
mod turning;

use std::sync::Arc;

use features::Frame;
use geometry::SE3;
use map::{KeyframeId, Map, PointCount, PointId, RelativePose};

use crate::assess::Assessment;
use crate::lost::{Lost, NotReady};
use crate::params::Params;
use crate::probe::{Probe, Stage, staged};
use crate::world::World;
use assessor::Assessor;
use beliefs::Beliefs;
use evidence::{Yardstick, add_evidence};
use initializer::Initializer;
pub use initializer::{InitialPair, NoPair};
pub use keyframe_policy::KeyframeReason;
pub(crate) use keyframe_policy::stereo_observations;
use last_frame::LastFrame;
use local_map::{LocalMap, LocallyTracked};
use motion_model::MotionModel;
use predict::Attempt;
use turning::{Found, Turning};

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
    /// Probability, of all that is known with this frame, that the point of each of them stands still.
    pub trust: Vec<f32>,
    /// Those of them that agree with the pose.
    pub inliers: Vec<(u32, PointId)>,
    /// How far features were moved to where their points look the same, `(feature, dx, dy)` in pixels.
    pub shifts: Vec<(u32, f32, f32)>,
    /// How far the pose is to be trusted.
    pub assessment: Assessment,
}

/// The tracker's memory between two frames: the last frame and how the camera moved.
#[derive(Clone, Debug)]
pub struct Tracker {
    params: Params,
    last: Option<LastFrame>,
    /// The first view of a monocular map that is about to start.
    initializer: Option<Initializer>,
    /// The frame that was handed over to start a sub-map and is not seen in the map yet.
    starting: Option<Arc<Frame>>,
    /// Frames in a row that are lost although a map could be started with them.
    lost_frames: u32,
    /// How the camera moved between the last two frames with a pose; `None` after a start or a relocalization.
    velocity: Option<MotionModel>,
    /// Whether the last frame got no pose.
    is_lost: bool,
    /// Until this frame few points suffice if the motion goes on as before: the map knows little of what is ahead.
    resuming_until: u32,
    /// A turn on the spot that is going on.
    turning: Option<Turning>,
    /// Index of the frame that last became a keyframe.
    last_keyframe_index: u32,
    /// Judges poses; tracking itself never asks it.
    assessor: Assessor,
    /// What it knows of its points beyond the map.
    beliefs: Beliefs,
}

impl Tracker {
    /// A tracker that has seen nothing. In a world that has keyframes already it begins by relocalization.
    pub fn new(params: Params) -> Self {
        Tracker {
            params,
            last: None,
            initializer: None,
            starting: None,
            lost_frames: 0,
            velocity: None,
            is_lost: false,
            resuming_until: 0,
            turning: None,
            last_keyframe_index: 0,
            assessor: Assessor::default(),
            beliefs: Beliefs::default(),
        }
    }

    /// Finds the pose of `frame` in the map of `world`. `mapper_idle` says whether mapping waits for work; it must
    /// depend on frame numbers only where a run has to be repeatable.
    pub fn track(
        &mut self,
        frame: &Arc<Frame>,
        world: &World,
        mapper_idle: bool,
        probe: &mut dyn Probe,
    ) -> Tracked {
        let calibrated = world.calibrated(frame);
        let mut tracked = self.track_calibrated(&calibrated, world, mapper_idle, probe);
        if let Some(request) = &mut tracked.keyframe {
            // As it was extracted: the map may have another calibration by the time it is inserted.
            request.frame = if tracked.shifts.is_empty() {
                frame.clone()
            } else {
                Arc::new(frame.moved(&tracked.shifts))
            };
        }
        tracked
    }

    fn track_calibrated(
        &mut self,
        frame: &Arc<Frame>,
        world: &World,
        mapper_idle: bool,
        probe: &mut dyn Probe,
    ) -> Tracked {
        let map = &world.map;
        if let Some(started) = &self.starting {
            let Some(first) = LastFrame::of_newest_keyframe(map, started) else {
                return not_tracked(TrackState::NotReady(NotReady::MapStarting), None);
            };
            self.assessor.remember(first.clone());
            self.last = Some(first);
            self.starting = None;
        }
        let last = self.last.take().map(|last| last.refreshed(map));
        if last.is_none() && map.n_keyframes() == 0 && !self.params.tracking.localize_only {
            return self.start(frame, SE3::identity());
        }
        match self.find_pose_or_turn(frame, world, last.as_ref(), probe) {
            Found::Local(local) => self.accept(frame, map, last.as_ref(), *local, mapper_idle, probe),
            Found::Held(tracked) => *tracked,
            Found::Lost(lost) => self.lose(frame, map, last, lost),
        }
    }

    /// The frame has a pose: remembers it, and decides whether it becomes a keyframe.
    fn accept(
        &mut self,
        frame: &Arc<Frame>,
        map: &Map,
        last: Option<&LastFrame>,
        mut local: LocallyTracked,
        mapper_idle: bool,
        probe: &mut dyn Probe,
    ) -> Tracked {
        self.lost_frames = 0;
        if std::mem::take(&mut self.is_lost) && !local.stats.relocalized {
            self.resuming_until = frame.index + self.params.camera.max_keyframe_gap;
        }
        self.initializer = None;
        if let Some(last) = last.filter(|_| !local.stats.relocalized) {
            let (seconds, camera) = (last.seconds_to(frame), &self.params.camera);
            let is_metric = !camera.sensor.is_scale_free();
            let yardstick =
                Yardstick::new(&local.cam_from_world, &last.cam_from_world(map), seconds, is_metric);
            add_evidence(&mut local, frame, map, yardstick, camera.feature_sigma_px);
        }
        self.beliefs.add(map, &local.counts);
        let trust = local.matched.iter().map(|&(_, id)| self.beliefs.trust(map, id)).collect();
        self.velocity = last.filter(|_| !local.stats.relocalized).map(|last| {
            let seconds = last.seconds_to(frame);
            MotionModel::between(&last.cam_from_world(map), &local.cam_from_world, seconds)
        });
        let pose = RelativePose::new(map, local.reference, local.cam_from_reference);
        let keyframe = staged(probe, Stage::Decide, || self.decide_keyframe(frame, map, &local, mapper_idle))
            .map(|reason| {
                self.last_keyframe_index = frame.index;
                KeyframeRequest {
                    frame: frame.clone(),
                    placement: Placement::Near(pose),
                    matches: local.matches.clone(),
                    reason,
                    pair: None,
                }
            });
        let frame = local.aligned.clone().unwrap_or_else(|| frame.clone());
        let assessment =
            staged(probe, Stage::Assess, || self.assessor.assess(&frame, map, &local, &self.params));
        let last = LastFrame::new(frame, pose, &local.matches);
        self.assessor.remember(last.clone());
        self.last = Some(last);
        Tracked {
            state: TrackState::Tracked,
            pose: Some(pose),
            counts: local.counts,
            keyframe,
            stats: local.stats,
            matched: local.matched,
            trust,
            inliers: local.matches,
            shifts: local.shifts,
            assessment,
        }
    }

    /// Tries the ways of prediction in turn, each confirmed by the local map. The reason of the attempt that came
    /// furthest is returned if all fail.
    fn find_pose(
        &self,
        frame: &Frame,
        world: &World,
        last: Option<&LastFrame>,
        probe: &mut dyn Probe,
    ) -> Result<LocallyTracked, Lost> {
        let attempts = match (last, self.velocity) {
            (Some(_), Some(_)) if !self.is_lost => {
                &[Attempt::Motion, Attempt::ReferenceKeyframe, Attempt::Relocalization][..]
            }
            (Some(_), _) => &[Attempt::ReferenceKeyframe, Attempt::Motion, Attempt::Relocalization],
            (None, _) => &[Attempt::Relocalization],
        };
        let mut reason: Option<Lost> = None;
        for &attempt in attempts {
            let lost = match self.attempt(attempt, frame, world, last, probe) {
                Ok(local) => return Ok(local),
                Err(lost) => lost,
            };
            reason = Some(reason.map_or(lost, |earlier| earlier.further(lost)));
        }
        Err(reason
            .unwrap_or(Lost::TooFewMatches { found: 0, needed: self.params.tracking.min_reference_matches }))
    }

    /// One way of prediction, confirmed by the local map.
    fn attempt(
        &self,
        attempt: Attempt,
        frame: &Frame,
        world: &World,
        last: Option<&LastFrame>,
        probe: &mut dyn Probe,
    ) -> Result<LocallyTracked, Lost> {
        let (map, tracking) = (&world.map, &self.params.tracking);
        let predicted = staged(probe, Stage::Predict, || self.predict(attempt, frame, world, last))?;
        let fallback = last.map_or(KeyframeId(0), |last| last.pose.keyframe);
        let local = staged(probe, Stage::LocalMap, || {
            let local = LocalMap::gather(map, &predicted.matches, fallback, tracking);
            local.track(frame, map, &predicted, &self.params)
        });
        let needed = self.inliers_needed(frame, map, last, &local.cam_from_world);
        let found = local.matches.len();
        if found < needed {
            return Err(Lost::TooFewLocalInliers { found, needed });
        }
        let inertia =
            last.filter(|_| attempt != Attempt::Relocalization).and_then(|l| self.inertia(frame, map, l));
        inertia.map_or(Ok(()), |inertia| inertia.check(&local.cam_from_world))?;
        Ok(local)
    }

    /// Asks for the first keyframe of a sub-map, at the given pose, if the frame has enough depth, or for the first
    /// two if there is one camera only and it has moved enough.
    fn start(&mut self, frame: &Arc<Frame>, cam_from_world: SE3) -> Tracked {
        let (found, needed) = (frame.n_with_depth(), self.params.tracking.init_min_features);
        let mut pair = None;
        if self.params.camera.sensor.is_scale_free() {
            match Initializer::advance(&mut self.initializer, frame, cam_from_world, &self.params) {
                Ok(found) => pair = Some(Arc::new(found)),
                Err(reason) => return not_tracked(TrackState::NotReady(NotReady::NoPair(reason)), None),
            }
        } else if found < needed {
            let reason = NotReady::TooFewDepths { found, needed, features: frame.len() };
            return not_tracked(TrackState::NotReady(reason), None);
        }
        self.last_keyframe_index = frame.index;
        self.velocity = None;
        self.turning = None;
        self.last = None;
        self.assessor.forget();
        self.lost_frames = 0;
        self.is_lost = false;
        self.starting = Some(frame.clone());
        let request = KeyframeRequest {
            frame: frame.clone(),
            placement: Placement::NewSubmap {
                cam_from_world: pair.as_ref().map_or(cam_from_world, |pair| pair.second_from_world),
            },
            matches: Vec::new(),
            reason: KeyframeReason::First,
            pair,
        };
        let assessment = Assessment::of_start();
        Tracked { keyframe: Some(request), assessment, ..not_tracked(TrackState::Started, None) }
    }
}

/// The answer for a frame without a pose of its own.
fn not_tracked(state: TrackState, last: Option<&LastFrame>) -> Tracked {
    Tracked {
        state,
        pose: last.map(|last| last.pose),
        counts: Vec::new(),
        keyframe: None,
        stats: TrackStats::default(),
        matched: Vec::new(),
        trust: Vec::new(),
        inliers: Vec::new(),
        shifts: Vec::new(),
        assessment: Assessment::default(),
    }
}

#[cfg(test)]
#[path = "../../tests/steps/tracker.rs"]
mod tests;
