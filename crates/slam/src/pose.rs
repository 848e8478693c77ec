//! From matches to a pose: by RANSAC where none is known, by motion-only optimization where one is.

use features::Frame;
use geometry::{PnpEstimator, RansacOptions, SE3, Vec3, ransac};
use map::{Map, PointId};
use optim::{CHI2_MONO, PoseObservation, PoseOptions, refine_pose};

use crate::noise::{Noise, information};
use crate::params::Weights;

/// A refined pose and the matches that agree with it.
#[derive(Clone, Debug)]
pub(crate) struct RefinedPose {
    pub(crate) cam_from_world: SE3,
    /// The inlier matches, in the order given.
    pub(crate) inliers: Vec<(u32, PointId)>,
}

/// Optimizes the pose of `frame` with matches of its features and world positions; also says which matches agree.
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

/// Optimizes the pose of `frame` with `matches` of its features and points of `map`; removed points are passed over.
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

/// Pose by P3P and RANSAC, samples and scores weighted by the features' activation and the belief in their points if that counts.
pub(crate) fn pose_by_ransac(
    frame: &Frame,
    map: &Map,
    matches: &[(u32, PointId)],
    weights: Weights,
    seed: u64,
) -> Option<SE3> {
    let mut pixels = Vec::with_capacity(matches.len());
    let mut points: Vec<Vec3> = Vec::with_capacity(matches.len());
    let mut thresholds_sq = Vec::with_capacity(matches.len());
    let mut trust = Vec::with_capacity(matches.len());
    for &(feature, id) in matches {
        let Some(point) = map.point(id) else { continue };
        let i = feature as usize;
        pixels.push(frame.pixel(i));
        points.push(point.position);
        thresholds_sq.push(CHI2_MONO / frame.inv_sigma_sq(i));
        trust.push(weights.of_sample(frame, i) * weights.of_point(point));
    }
    let estimator = PnpEstimator::new(frame.rig.stereo.camera, &pixels, &points, &thresholds_sq);
    let options = RansacOptions { max_iterations: 300, confidence: 0.99, seed, ..RansacOptions::default() };
    ransac(&estimator, Some(&trust), &options).map(|found| found.model)
}

#[cfg(test)]
#[path = "../tests/steps/pose.rs"]
mod tests;
