//! A pose without prediction: descriptors matched against keyframes around the last pose, P3P with weighted RANSAC.

use features::{Descriptor, Frame, consistent_rotations, match_brute_force};
use geometry::{PnpEstimator, RansacOptions, SE3, Vec3, mix_seed, ransac};
use map::{KeyframeId, Map, PointId};

use super::last_frame::LastFrame;
use super::pose::{RefinedPose, refine};
use crate::lost::Lost;
use crate::params::Params;

/// Largest descriptor distance of a match that is not guided by a pose.
const MAX_DISTANCE_STRICT: u32 = 50;
/// Largest ratio of the best to the second-best distance.
const MAX_RATIO: f32 = 0.75;
/// Keyframes tried: the reference, its best covisible ones, the newest.
const MAX_CANDIDATES: usize = 5;
/// Purpose of the random numbers, so that no two uses share a stream.
const SEED_PURPOSE: u64 = 1;
/// Reprojection error squared that RANSAC accepts, in units of the feature's variance (2 degrees of freedom, 95 %).
const CHI2: f64 = 5.991;

/// Tries keyframes in turn; the first good pose is returned, else the best reason.
pub(super) fn recover(
    frame: &Frame,
    map: &Map,
    last: &LastFrame,
    params: &Params,
) -> Result<RefinedPose, Lost> {
    let tracking = &params.tracking;
    let mut most_matches = 0;
    let mut most_inliers = None;
    for keyframe in candidates(map, last.reference) {
        let matches = match_keyframe(frame, map, keyframe);
        most_matches = most_matches.max(matches.len());
        if matches.len() < tracking.min_reference_matches {
            continue;
        }
        let seed = mix_seed(params.seed, u64::from(frame.index), SEED_PURPOSE + (u64::from(keyframe.0) << 8));
        let Some(initial) = pose_by_ransac(frame, map, &matches, seed) else { continue };
        let pose = refine(frame, map, initial, &matches, params.feature_sigma_px);
        if pose.inliers.len() >= tracking.min_predicted_inliers {
            return Ok(pose);
        }
        most_inliers = most_inliers.max(Some(pose.inliers.len()));
    }
    Err(match most_inliers {
        Some(found) => Lost::TooFewPredictedInliers { found, needed: tracking.min_predicted_inliers },
        None => Lost::TooFewMatches { found: most_matches, needed: tracking.min_reference_matches },
    })
}

/// The reference keyframe, its best covisible ones and the newest keyframe, each once.
fn candidates(map: &Map, reference: KeyframeId) -> Vec<KeyframeId> {
    let mut list = Vec::new();
    if let Some(keyframe) = map.keyframe(reference) {
        list.push(reference);
        list.extend(keyframe.best_covisible(MAX_CANDIDATES - 2).iter().map(|&(id, _)| id));
    }
    if let Some(newest) = map.newest_keyframe()
        && !list.contains(&newest)
    {
        list.push(newest);
    }
    list
}

/// Mutual best matches of the frame with a keyframe's points, consistent in rotation.
fn match_keyframe(frame: &Frame, map: &Map, keyframe: KeyframeId) -> Vec<(u32, PointId)> {
    let Some(keyframe) = map.keyframe(keyframe) else { return Vec::new() };
    let with_point: Vec<(u32, PointId)> =
        keyframe.points().iter().enumerate().filter_map(|(i, p)| p.map(|p| (i as u32, p))).collect();
    let descriptors: Vec<Descriptor> =
        with_point.iter().map(|&(i, _)| keyframe.frame.descriptors[i as usize]).collect();
    let pairs = match_brute_force(&descriptors, &frame.descriptors, MAX_DISTANCE_STRICT, MAX_RATIO);
    let turns: Vec<f32> = pairs
        .iter()
        .map(|&(a, b)| {
            keyframe.frame.keypoints[with_point[a as usize].0 as usize].angle_deg
                - frame.keypoints[b as usize].angle_deg
        })
        .collect();
    let consistent = consistent_rotations(&turns);
    let mut matches: Vec<(u32, PointId)> = pairs
        .iter()
        .zip(consistent)
        .filter(|(_, consistent)| *consistent)
        .map(|(&(a, b), _)| (b, with_point[a as usize].1))
        .collect();
    matches.sort_unstable();
    matches
}

/// Pose by P3P and RANSAC, samples and scores weighted by the features' activation.
fn pose_by_ransac(frame: &Frame, map: &Map, matches: &[(u32, PointId)], seed: u64) -> Option<SE3> {
    let mut pixels = Vec::with_capacity(matches.len());
    let mut points: Vec<Vec3> = Vec::with_capacity(matches.len());
    let mut thresholds_sq = Vec::with_capacity(matches.len());
    let mut weights = Vec::with_capacity(matches.len());
    for &(feature, id) in matches {
        let Some(point) = map.point(id) else { continue };
        let i = feature as usize;
        pixels.push(frame.pixel(i));
        points.push(point.position);
        thresholds_sq.push(CHI2 / frame.inv_sigma_sq(i));
        weights.push(f64::from(frame.activation[i]));
    }
    let estimator = PnpEstimator::new(frame.rig.stereo.camera, &pixels, &points, &thresholds_sq);
    let options = RansacOptions { max_iterations: 300, confidence: 0.99, seed, ..RansacOptions::default() };
    ransac(&estimator, Some(&weights), &options).map(|found| found.model)
}
