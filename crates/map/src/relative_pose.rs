//! A pose relative to a keyframe, so that it moves along with the keyframe.

use geometry::SE3;

use crate::ids::KeyframeId;
use crate::map::Map;

/// Where a camera is, seen from a keyframe of a map that goes on changing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativePose {
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Points in the keyframe's camera frame to the camera frame; meters, or the unit of the monocular sub-map.
    pub cam_from_keyframe: SE3,
    /// [`Map::scale_of`] the keyframe for which the translation holds.
    pub(crate) scale: f64,
    /// Revision of the map on which it was found.
    pub(crate) revision: u64,
}

impl RelativePose {
    /// A pose found in `map`.
    pub fn new(map: &Map, keyframe: KeyframeId, cam_from_keyframe: SE3) -> Self {
        RelativePose { keyframe, cam_from_keyframe, scale: map.scale_of(keyframe), revision: map.revision() }
    }

    /// The pose of a keyframe itself.
    pub fn of_keyframe(keyframe: KeyframeId) -> Self {
        let (cam_from_keyframe, scale, revision) = (SE3::identity(), 1.0, u64::MAX);
        RelativePose { keyframe, cam_from_keyframe, scale, revision }
    }

    /// The pose in the world of `map`, through keyframes that were removed since; the translation follows the keyframe's
    /// scale. Where a loop was taken back that stood when the pose was found on its new visit, it follows that visit. Not
    /// normalized. `None` when the map never had the keyframe.
    pub fn cam_from_world(&self, map: &Map) -> Option<SE3> {
        let pose = self.parted(map);
        let (alive, keyframe_from_alive) = map.resolve_keyframe(pose.keyframe)?;
        Some(pose.scaled(map) * keyframe_from_alive * map.keyframe(alive)?.cam_from_world)
    }

    /// The same pose relative to the living keyframe that carries it in `map`.
    pub fn on_living(&self, map: &Map) -> Self {
        let pose = self.parted(map);
        let cam_from_keyframe = pose.scaled(map);
        match map.resolve_keyframe(pose.keyframe) {
            Some((alive, keyframe_from_alive)) if alive != pose.keyframe => {
                Self::new(map, alive, cam_from_keyframe * keyframe_from_alive)
            }
            _ => Self::new(map, pose.keyframe, cam_from_keyframe),
        }
    }

    /// The same pose relative to a keyframe of its own visit, where loops have been taken back since.
    fn parted(&self, map: &Map) -> Self {
        map.taken_back.iter().fold(*self, |pose, loop_| loop_.moved(&pose).unwrap_or(pose))
    }

    fn scaled(&self, map: &Map) -> SE3 {
        let mut cam_from_keyframe = self.cam_from_keyframe;
        cam_from_keyframe.translation *= map.scale_of(self.keyframe) / self.scale;
        cam_from_keyframe
    }
}
