//! Tracking: a frame and an immutable map give a pose, or a reason why there is none.

mod align;
mod answer;
mod assessor;
mod beliefs;
mod directions;
mod evidence;
mod find_pose;
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
mod start;
mod track_reference_keyframe;
mod turning;

use std::sync::Arc;

use features::Frame;
use geometry::SE3;
use map::{Map, PointId, RelativePose};

use crate::lost::NotReady;
use crate::params::Params;
use crate::probe::{Probe, Stage, staged};
use crate::world::World;
pub use answer::{KeyframeRequest, Placement, TrackState, TrackStats, Tracked};
use assessor::Assessor;
use beliefs::Beliefs;
use evidence::{Yardstick, add_evidence};
use initializer::Initializer;
pub use initializer::{InitialPair, NoPair};
pub use keyframe_policy::KeyframeReason;
pub(crate) use keyframe_policy::stereo_observations;
use last_frame::LastFrame;
use local_map::LocallyTracked;
use loss::Loss;
use motion_model::MotionModel;
use turning::{Found, Turning};

/// The tracker's memory between two frames: the last frame and how the camera moved.
#[derive(Clone, Debug)]
pub struct Tracker {
    params: Params,
    last: Option<LastFrame>,
    /// The first view of a monocular map that is about to start.
    initializer: Option<Initializer>,
    /// The frame that was handed over to start a sub-map and is not seen in the map yet.
    starting: Option<Arc<Frame>>,
    /// How the camera moved between the last two frames with a pose; `None` after a start or a relocalization.
    velocity: Option<MotionModel>,
    /// Whether it lost the camera.
    loss: Loss,
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
            velocity: None,
            loss: Loss::default(),
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
                return Tracked::without_pose(TrackState::NotReady(NotReady::MapStarting), None);
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

    /// Probability, of all that is known with the last frame, that the point of each of its matches in this map stands still.
    pub fn trust(&self, map: &Map, matches: &[(u32, PointId)]) -> Vec<f32> {
        matches.iter().map(|&(_, id)| self.beliefs.trust(map, id)).collect()
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
        self.end_loss(frame, local.stats.relocalized);
        self.initializer = None;
        if let Some(last) = last.filter(|_| !local.stats.relocalized) {
            let (seconds, camera) = (last.seconds_to(frame), &self.params.camera);
            let is_metric = !camera.sensor.is_scale_free();
            let yardstick =
                Yardstick::new(&local.cam_from_world, &last.cam_from_world(map), seconds, is_metric);
            add_evidence(&mut local, frame, map, yardstick, camera.feature_sigma_px);
        }
        self.beliefs.add(map, &local.counts);
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
            inliers: local.matches,
            shifts: local.shifts,
            assessment,
        }
    }
}

#[cfg(test)]
#[path = "../../tests/steps/tracker.rs"]
mod tests;
