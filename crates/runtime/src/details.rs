//! Everything about a tracked frame, for observers that show it.

use std::sync::Arc;

use features::{ActivationMap, Frame};
use geometry::{GrayImage, SE3};
use map::{PointId, RelativePose};
use slam::{TrackStats, Tracked};

use crate::feed::FrameInfo;
use crate::record::FrameStatus;
use crate::view::View;

/// What the features of a frame were found in.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The left image.
    pub image: Arc<GrayImage>,
    /// Its activation map, if a network selects features.
    pub activation: Option<Arc<ActivationMap>>,
}

/// A frame after tracking; shares what the run has.
#[derive(Clone, Debug)]
pub struct FrameDetails {
    /// Number and time.
    pub info: FrameInfo,
    /// What became of it.
    pub status: FrameStatus,
    /// Its features.
    pub frame: Arc<Frame>,
    /// What they were found in.
    pub seen: Option<Seen>,
    /// The pose relative to a keyframe of the map as it was then, of a lost frame the last one known; `None` for a frame that
    /// starts a map.
    pub pose: Option<RelativePose>,
    /// Scale of the keyframe in that map.
    pub scale: f64,
    /// Pose in that map; the identity for a frame that starts it.
    pub world_from_cam: SE3,
    /// All matches of features with map points, sorted by feature.
    pub matched: Vec<(u32, PointId)>,
    /// Those of them that agree with the pose.
    pub inliers: Vec<(u32, PointId)>,
    /// Counts of tracking.
    pub stats: TrackStats,
    /// Keyframes and points in the map that it saw.
    pub map_size: (usize, usize),
    /// `(stage, ms)` in the order in which the stages ended.
    pub stages: Vec<(&'static str, f64)>,
}

impl FrameDetails {
    /// Details of a frame that was just tracked; `tracked` loses its matches.
    pub(crate) fn new(
        info: FrameInfo,
        status: FrameStatus,
        (frame, seen): (Arc<Frame>, Option<Seen>),
        tracked: &mut Tracked,
        view: &View,
        stages: Vec<(&'static str, f64)>,
    ) -> Self {
        let map = &view.world.map;
        let pose = tracked.pose.map(|pose| pose.on_living(map));
        let cam_from_world = pose.and_then(|pose| pose.cam_from_world(map)).unwrap_or(SE3::identity());
        FrameDetails {
            info,
            status,
            frame,
            seen,
            pose,
            scale: pose.map_or(1.0, |pose| map.scale_of(pose.keyframe)),
            world_from_cam: cam_from_world.normalized().inverse(),
            matched: std::mem::take(&mut tracked.matched),
            inliers: std::mem::take(&mut tracked.inliers),
            stats: tracked.stats,
            map_size: (map.n_keyframes(), map.n_points()),
            stages,
        }
    }
}
