//! Everything about a tracked frame, for observers that show it.

use std::sync::Arc;

use features::Frame;
use geometry::{GrayImage, SE3};
use map::{PointId, RelativePose};
use slam::{TrackStats, Tracked};

use crate::feed::FrameInfo;
use crate::record::FrameStatus;
use crate::view::View;

/// A frame after tracking; shares what the run has.
#[derive(Clone, Debug)]
pub struct FrameDetails {
    /// Number and time.
    pub info: FrameInfo,
    /// What became of it.
    pub status: FrameStatus,
    /// Its features.
    pub frame: Arc<Frame>,
    /// Its left image, as the features were found in it.
    pub image: Option<Arc<GrayImage>>,
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
        (frame, image): (Arc<Frame>, Option<Arc<GrayImage>>),
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
            image,
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
