//! The start of a map, or of a sub-map after a lasting loss.

use std::sync::Arc;

use features::Frame;
use geometry::SE3;

use super::initializer::Initializer;
use super::keyframe_policy::KeyframeReason;
use super::{KeyframeRequest, Placement, TrackState, Tracked, Tracker};
use crate::assess::Assessment;
use crate::lost::NotReady;

impl Tracker {
    /// Asks for the first keyframe of a sub-map, at the given pose, if the frame has enough depth, or for the first
    /// two if there is one camera only and it has moved enough.
    pub(super) fn start(&mut self, frame: &Arc<Frame>, cam_from_world: SE3) -> Tracked {
        let (found, needed) = (frame.n_with_depth(), self.params.tracking.init_min_features);
        let mut pair = None;
        if self.params.camera.sensor.is_scale_free() {
            match Initializer::advance(&mut self.initializer, frame, cam_from_world, &self.params) {
                Ok(found) => pair = Some(Arc::new(found)),
                Err(reason) => {
                    return Tracked::without_pose(TrackState::NotReady(NotReady::NoPair(reason)), None);
                }
            }
        } else if found < needed {
            let reason = NotReady::TooFewDepths { found, needed, features: frame.len() };
            return Tracked::without_pose(TrackState::NotReady(reason), None);
        }
        self.last_keyframe_index = frame.index;
        self.velocity = None;
        self.turning = None;
        self.last = None;
        self.assessor.forget();
        self.loss.end();
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
        Tracked { keyframe: Some(request), assessment, ..Tracked::without_pose(TrackState::Started, None) }
    }
}
