//! From matches to a pose: the bridge to motion-only optimisation.

use features::Frame;
use geometry::SE3;
use map::{Map, PointId};
use optim::{PoseObservation, PoseOptions, refine_pose};

/// A refined pose and the matches that agree with it.
#[derive(Clone, Debug)]
pub(crate) struct RefinedPose {
    pub(crate) cam_from_world: SE3,
    /// The inlier matches, in the order given.
    pub(crate) inliers: Vec<(u32, PointId)>,
}

/// Optimises the pose of `frame` with `matches` of its features and points of `map`; removed points are passed over.
pub(crate) fn refine(frame: &Frame, map: &Map, initial: SE3, matches: &[(u32, PointId)]) -> RefinedPose {
    let mut kept = Vec::with_capacity(matches.len());
    let mut observations = Vec::with_capacity(matches.len());
    for &(feature, id) in matches {
        let Some(point) = map.point(id) else { continue };
        let i = feature as usize;
        kept.push((feature, id));
        observations.push(PoseObservation {
            point_world: point.position,
            pixel: frame.pixel(i),
            right_u: f64::from(frame.right_u[i]),
            inv_sigma_sq: frame.inv_sigma_sq(i),
        });
    }
    let solution = refine_pose(&frame.rig.stereo, initial, &observations, &PoseOptions::default());
    let inliers =
        kept.iter().zip(&solution.inliers).filter(|(_, inlier)| **inlier).map(|(m, _)| *m).collect();
    RefinedPose { cam_from_world: solution.cam_from_world, inliers }
}
