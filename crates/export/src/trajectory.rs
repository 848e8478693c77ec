//! The keyframes as a trajectory.

use io::{StampedPose, Trajectory};

use crate::scene::Scene;

/// Poses of the left camera at the keyframes, by time; of keyframes with the same time (of several sequences) the first is kept.
pub fn trajectory(scene: &Scene) -> Trajectory {
    let pose = |view: &crate::View| StampedPose {
        timestamp_s: view.timestamp_s,
        world_from_cam: view.cam_from_world.inverse(),
    };
    let mut poses: Vec<StampedPose> = scene.views.iter().map(pose).collect();
    poses.sort_by(|a, b| a.timestamp_s.total_cmp(&b.timestamp_s));
    poses.dedup_by_key(|pose| pose.timestamp_s);
    Trajectory { poses }
}
