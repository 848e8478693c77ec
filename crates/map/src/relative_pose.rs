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
    scale: f64,
}

impl RelativePose {
    /// A pose found in `map`.
    pub fn new(map: &Map, keyframe: KeyframeId, cam_from_keyframe: SE3) -> Self {
        RelativePose { keyframe, cam_from_keyframe, scale: map.scale_of(keyframe) }
    }

    /// The pose of a keyframe itself.
    pub fn of_keyframe(keyframe: KeyframeId) -> Self {
        RelativePose { keyframe, cam_from_keyframe: SE3::identity(), scale: 1.0 }
    }

    /// The pose in the world of `map`, through keyframes that were removed since; the translation follows the keyframe's
    /// scale. Not normalized. `None` when the map never had the keyframe.
    pub fn cam_from_world(&self, map: &Map) -> Option<SE3> {
        let (alive, keyframe_from_alive) = map.resolve_keyframe(self.keyframe)?;
        Some(self.scaled(map) * keyframe_from_alive * map.keyframe(alive)?.cam_from_world)
    }

    /// The same pose relative to the living keyframe that carries it in `map`.
    pub fn on_living(&self, map: &Map) -> Self {
        let cam_from_keyframe = self.scaled(map);
        match map.resolve_keyframe(self.keyframe) {
            Some((alive, keyframe_from_alive)) if alive != self.keyframe => {
                Self::new(map, alive, cam_from_keyframe * keyframe_from_alive)
            }
            _ => Self::new(map, self.keyframe, cam_from_keyframe),
        }
    }

    fn scaled(&self, map: &Map) -> SE3 {
        let mut cam_from_keyframe = self.cam_from_keyframe;
        cam_from_keyframe.translation *= map.scale_of(self.keyframe) / self.scale;
        cam_from_keyframe
    }
}
