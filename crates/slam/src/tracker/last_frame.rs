//! The last tracked frame, as the tracker remembers it: relative to a keyframe, so that corrections move it along.

use std::sync::Arc;

use features::Frame;
use geometry::SE3;
use map::{KeyframeId, Map, PointId};

/// A tracked frame with its matches.
#[derive(Clone, Debug)]
pub(crate) struct LastFrame {
    pub(crate) frame: Arc<Frame>,
    /// The keyframe that the pose refers to.
    pub(crate) reference: KeyframeId,
    pub(crate) cam_from_reference: SE3,
    /// [`Map::scale_of`] the reference for which `cam_from_reference` holds.
    scale: f64,
    /// Matches of features with map points, sorted by feature.
    pub(crate) matches: Vec<(u32, PointId)>,
}

impl LastFrame {
    pub(crate) fn new(
        frame: Arc<Frame>,
        map: &Map,
        reference: KeyframeId,
        cam_from_reference: SE3,
        matches: &[(u32, PointId)],
    ) -> Self {
        let scale = map.scale_of(reference);
        LastFrame { frame, reference, cam_from_reference, scale, matches: matches.to_vec() }
    }

    /// The newest keyframe, if it is this frame.
    pub(crate) fn of_newest_keyframe(map: &Map, frame: &Arc<Frame>) -> Option<Self> {
        let newest = map.newest_keyframe().and_then(|id| map.keyframe(id));
        let keyframe = newest.filter(|kf| Arc::ptr_eq(&kf.frame, frame))?;
        let shown = keyframe.points().iter().zip(0..);
        Some(LastFrame {
            frame: keyframe.frame.clone(),
            reference: keyframe.id,
            cam_from_reference: SE3::identity(),
            scale: map.scale_of(keyframe.id),
            matches: shown.filter_map(|(point, feature)| Some((feature, (*point)?))).collect(),
        })
    }

    /// Time from this frame to `frame`, seconds.
    pub(crate) fn seconds_to(&self, frame: &Frame) -> f64 {
        frame.timestamp_s - self.frame.timestamp_s
    }

    /// Pose in the world of `map`.
    pub(crate) fn cam_from_world(&self, map: &Map) -> SE3 {
        match map.resolve_keyframe(self.reference) {
            Some((alive, removed_from_alive)) => {
                let alive_from_world = map.keyframe(alive).map_or(SE3::identity(), |kf| kf.cam_from_world);
                self.cam_from_reference * removed_from_alive * alive_from_world
            }
            None => self.cam_from_reference,
        }
    }

    /// Follows what happened in the map since: removed keyframes, merged and removed points, and the frame itself
    /// having become a keyframe with new points.
    pub(crate) fn refreshed(mut self, map: &Map) -> Self {
        if let Some(keyframe) = LastFrame::of_newest_keyframe(map, &self.frame) {
            return keyframe;
        }
        let scale = map.scale_of(self.reference);
        self.cam_from_reference.translation *= scale / self.scale;
        self.scale = scale;
        if let Some((alive, removed_from_alive)) = map.resolve_keyframe(self.reference)
            && alive != self.reference
        {
            self.reference = alive;
            self.cam_from_reference = self.cam_from_reference * removed_from_alive;
            self.scale = map.scale_of(alive);
        }
        self.matches = self
            .matches
            .iter()
            .filter_map(|&(feature, point)| map.resolve(point).map(|point| (feature, point)))
            .collect();
        self
    }
}
