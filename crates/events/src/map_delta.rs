//! What changed in the map since the last record of this kind.

use serde::{Deserialize, Serialize};

use crate::Pose;

/// Changes of the map; lists are in order of the ids.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapDelta {
    /// Number of the newest frame that was known when the changes were found.
    pub frame: u32,
    /// Revision of the map.
    pub revision: u64,
    /// Points that are new or other than they were.
    pub points: Vec<PointUpdate>,
    /// Points that are gone.
    pub gone_points: Vec<u32>,
    /// Keyframes that are new or other than they were.
    pub keyframes: Vec<KeyframeUpdate>,
    /// Keyframes that are gone.
    pub gone_keyframes: Vec<GoneKeyframe>,
}

impl MapDelta {
    /// Whether there is nothing to tell.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
            && self.gone_points.is_empty()
            && self.keyframes.is_empty()
            && self.gone_keyframes.is_empty()
    }
}

/// A point as it is shown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointUpdate {
    /// Its id.
    pub id: u32,
    /// Position, meters, in the coordinates of its sub-map.
    pub position: [f32; 3],
    /// Number of the frame that was the newest keyframe when the point was made: its age.
    pub born: u32,
    /// Probability that it stands still, of all that is known, 0 to 255 for 0 to 1.
    pub activation: u8,
}

/// A keyframe as it is shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeyframeUpdate {
    /// Its id.
    pub id: u32,
    /// Number of the frame that it was.
    pub frame: u32,
    /// Pose.
    pub cam_from_world: Pose,
    /// Product of the scales of all corrections since its insertion.
    pub scale: f64,
    /// Root of its sub-map.
    pub submap: u32,
    /// Parent in the spanning tree.
    pub parent: Option<u32>,
    /// Keyframes with smaller ids that share many points with it, strongest first.
    pub covisible: Vec<u32>,
    /// Keyframes with smaller ids that a closed loop joins to it.
    pub loops: Vec<u32>,
}

/// A keyframe that was removed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoneKeyframe {
    /// Its id.
    pub id: u32,
    /// The keyframe that carries its pose from now on.
    pub heir: u32,
    /// Its pose relative to that one.
    pub gone_from_heir: Pose,
    /// Its own scale and the heir's at that time, see [`KeyframeUpdate::scale`].
    pub scales: [f64; 2],
}
