//! The last tracked frame, as the tracker remembers it: relative to a keyframe, so that corrections move it along.

use std::sync::Arc;

use features::Frame;
use geometry::SE3;
use map::{KeyframeId, Map, PointId, RelativePose};

/// A tracked frame with its matches.
#[derive(Clone, Debug)]
pub(crate) struct LastFrame {
    pub(crate) frame: Arc<Frame>,
    pub(crate) pose: RelativePose,
    /// Matches of features with map points, sorted by feature.
    pub(crate) matches: Vec<(u32, PointId)>,
}

impl LastFrame {
    pub(crate) fn new(frame: Arc<Frame>, pose: RelativePose, matches: &[(u32, PointId)]) -> Self {
        LastFrame { frame, pose, matches: matches.to_vec() }
    }

    /// The newest keyframe, if it is this frame.
    pub(crate) fn of_newest_keyframe(map: &Map, frame: &Arc<Frame>) -> Option<Self> {
        let newest = map.newest_keyframe().and_then(|id| map.keyframe(id));
        LastFrame::of_keyframe(map, newest.filter(|kf| kf.frame.is_same(frame))?.id)
    }

    /// A keyframe of the map.
    pub(crate) fn of_keyframe(map: &Map, id: KeyframeId) -> Option<Self> {
        let keyframe = map.keyframe(id)?;
        let shown = keyframe.points().iter().zip(0..);
        Some(LastFrame {
            frame: keyframe.frame.clone(),
            pose: RelativePose::new(map, keyframe.id, SE3::identity()),
            matches: shown.filter_map(|(point, feature)| Some((feature, (*point)?))).collect(),
        })
    }

    /// Time from this frame to `frame`, seconds.
    pub(crate) fn seconds_to(&self, frame: &Frame) -> f64 {
        frame.timestamp_s - self.frame.timestamp_s
    }

    /// Pose in the world of `map`.
    pub(crate) fn cam_from_world(&self, map: &Map) -> SE3 {
        self.pose.cam_from_world(map).unwrap_or(self.pose.cam_from_keyframe)
    }

    /// Follows what happened in the map since: removed keyframes, merged and removed points, and the frame itself
    /// having become a keyframe with new points.
    pub(crate) fn refreshed(mut self, map: &Map) -> Self {
        if let Some(keyframe) = LastFrame::of_newest_keyframe(map, &self.frame) {
            return keyframe;
        }
        self.pose = self.pose.on_living(map);
        self.matches = self
            .matches
            .iter()
            .filter_map(|&(feature, point)| map.resolve(point).map(|point| (feature, point)))
            .collect();
        self
    }
}

#[cfg(test)]
#[path = "../../tests/steps/last_frame.rs"]
mod tests;
