//! The motion of the camera from frame to frame, without the jumps of a map that is corrected.

use geometry::SE3;
use map::{KeyframeId, Map, RelativePose};

/// The last frame with a pose.
#[derive(Debug, Default)]
pub(crate) struct Motion {
    last: Option<Last>,
}

#[derive(Clone, Copy, Debug)]
struct Last {
    /// Number in its sequence.
    index: u32,
    /// `None`: it started a map, and only its keyframe tells where it is.
    relative: Option<RelativePose>,
    /// Whether it may have become a keyframe, whose pose is then the better one.
    was_asked: bool,
}

impl Motion {
    /// The frame of number `index` was found at `cam_from_world` in this map; returns its pose in the camera of the last frame, as both
    /// stand in this map. `None` where they have no map in common.
    pub(crate) fn to(
        &mut self,
        map: &Map,
        (index, relative, was_asked): (u32, Option<RelativePose>, bool),
        cam_from_world: &SE3,
    ) -> Option<SE3> {
        let last = self.last.replace(Last { index, relative, was_asked });
        let submap = map.submap_of(relative?.on_living(map).keyframe)?;
        let last = last?.in_map(map)?;
        let is_near = map.submap_of(last.on_living(map).keyframe) == Some(submap);
        let last_from_world = last.cam_from_world(map).filter(|_| is_near)?;
        Some((last_from_world * cam_from_world.inverse()).normalized())
    }
}

impl Last {
    fn in_map(self, map: &Map) -> Option<RelativePose> {
        let newest: Option<KeyframeId> = map.newest_keyframe().filter(|_| self.was_asked);
        let own =
            newest.and_then(|id| map.keyframe(id)).filter(|keyframe| keyframe.frame.index == self.index);
        own.map(|keyframe| RelativePose::of_keyframe(keyframe.id)).or(self.relative)
    }
}
