//! A frame without a pose, and how tracking goes on after it.

use std::sync::Arc;

use features::Frame;
use geometry::SE3;
use map::Map;

use super::last_frame::LastFrame;
use super::{TrackState, Tracked, Tracker};
use crate::lost::Lost;
use crate::params::Params;

/// Inliers that suffice shortly after a loss where the pose agrees with the motion before it.
const RESUMING_INLIERS: usize = 12;
/// How far it may then be off, as a part of the way since.
const RESUMING_REACH: f64 = 0.25;
/// And how far it may have turned otherwise.
const RESUMING_ANGLE_RAD: f64 = 0.1;

/// Whether the camera is lost, or was a moment ago.
#[derive(Clone, Debug, Default)]
pub(super) struct Loss {
    /// Whether the last frame got no pose.
    pub(super) is_lost: bool,
    /// Frames in a row that are lost although a map could be started with them.
    startable: u32,
    /// Until this frame few points suffice if the motion goes on as before: the map knows little of what is ahead.
    pub(super) resuming_until: u32,
}

impl Loss {
    /// The camera has a pose.
    pub(super) fn end(&mut self) {
        (self.is_lost, self.startable) = (false, 0);
    }

    /// The next frame that gets no pose may start a map.
    pub(super) fn has_lasted(&mut self, params: &Params) {
        self.startable = params.camera.max_lost_frames;
    }
}

impl Tracker {
    /// The camera has a pose. If it was lost and is where the motion before puts it, the map knows little of what is ahead.
    pub(super) fn end_loss(&mut self, frame: &Frame, is_relocalized: bool) {
        if self.loss.is_lost && !is_relocalized {
            self.loss.resuming_until = frame.index + self.params.camera.max_keyframe_gap;
        }
        self.loss.end();
    }

    /// Points of the local map that must agree with the pose of a frame.
    pub(super) fn inliers_needed(
        &self,
        frame: &Frame,
        map: &Map,
        last: Option<&LastFrame>,
        cam_from_world: &SE3,
    ) -> usize {
        let usual = self.params.tracking.min_inliers;
        let is_resumed = last.is_some_and(|last| self.resumes(frame, map, last, cam_from_world));
        if is_resumed { usual.min(RESUMING_INLIERS) } else { usual }
    }

    /// Whether the camera was lost lately and is now where it would be had it moved on as before. Without a scale nobody can tell.
    fn resumes(&self, frame: &Frame, map: &Map, last: &LastFrame, cam_from_world: &SE3) -> bool {
        let is_metric = !self.params.camera.sensor.is_scale_free();
        let Some(velocity) = self.velocity.filter(|_| is_metric) else { return false };
        if !self.loss.is_lost && frame.index >= self.loss.resuming_until {
            return false;
        }
        let motion = velocity.motion_over(last.seconds_to(frame));
        let off = *cam_from_world * (motion * last.cam_from_world(map)).inverse();
        off.translation.norm() <= RESUMING_REACH * motion.translation.norm()
            && off.rotation.angle() <= RESUMING_ANGLE_RAD
    }

    /// Keeps the last good frame, so that recovery starts from it; after a lasting loss a new sub-map begins where the
    /// camera was last seen.
    pub(super) fn lose(
        &mut self,
        frame: &Arc<Frame>,
        map: &Map,
        last: Option<LastFrame>,
        lost: Lost,
    ) -> Tracked {
        self.loss.is_lost = true;
        self.assessor.forget();
        let tracking = &self.params.tracking;
        let could_start =
            self.params.camera.sensor.is_scale_free() || frame.n_with_depth() >= tracking.init_min_features;
        self.loss.startable += u32::from(could_start);
        if self.loss.startable > self.params.camera.max_lost_frames && !tracking.localize_only {
            let started =
                self.start(frame, last.as_ref().map_or(SE3::identity(), |last| last.cam_from_world(map)));
            if started.keyframe.is_some() {
                return started;
            }
        }
        let tracked = Tracked::without_pose(TrackState::Lost(lost), last.as_ref());
        self.last = last;
        tracked
    }
}
