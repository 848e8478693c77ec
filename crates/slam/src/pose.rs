//! From matches to a pose: the bridge to motion-only optimisation.

use features::Frame;
use geometry::{SE3, Vec3};
use map::{Map, PointId};
use optim::{PoseObservation, PoseOptions, refine_pose};

use crate::noise::{Noise, information};

/// A refined pose and the matches that agree with it.
#[derive(Clone, Debug)]
pub(crate) struct RefinedPose {
    pub(crate) cam_from_world: SE3,
    /// The inlier matches, in the order given.
    pub(crate) inliers: Vec<(u32, PointId)>,
}

/// Optimises the pose of `frame` with matches of its features and world positions; also says which matches agree.
pub(crate) fn refine_with_positions(
    frame: &Frame,
    initial: SE3,
    matches: &[(u32, Vec3)],
    noise: Noise,
) -> (SE3, Vec<bool>) {
    let observations: Vec<PoseObservation> = matches
        .iter()
        .map(|&(feature, point_world)| {
            let i = feature as usize;
            PoseObservation {
                point_world,
                pixel: frame.pixel(i),
                right_u: f64::from(frame.right_u[i]),
                inv_sigma_sq: information(frame, i, noise),
            }
        })
        .collect();
    let solution = refine_pose(&frame.rig.stereo, initial, &observations, &PoseOptions::default());
    (solution.cam_from_world, solution.inliers)
}

/// Optimises the pose of `frame` with `matches` of its features and points of `map`; removed points are passed over.
pub(crate) fn refine(
    frame: &Frame,
    map: &Map,
    initial: SE3,
    matches: &[(u32, PointId)],
    noise: Noise,
) -> RefinedPose {
    let living: Vec<(u32, PointId, Vec3)> = matches
        .iter()
        .filter_map(|&(feature, id)| map.point(id).map(|point| (feature, id, point.position)))
        .collect();
    let positions: Vec<(u32, Vec3)> =
        living.iter().map(|&(feature, _, position)| (feature, position)).collect();
    let (cam_from_world, agrees) = refine_with_positions(frame, initial, &positions, noise);
    let inliers = living.iter().zip(agrees).filter(|(_, agrees)| *agrees).map(|(m, _)| (m.0, m.1)).collect();
    RefinedPose { cam_from_world, inliers }
}
