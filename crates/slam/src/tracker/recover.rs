//! A pose without prediction: descriptors matched against keyframes around the last pose, P3P with weighted RANSAC.

use features::{Descriptor, Frame, consistent_rotations, match_brute_force};
use geometry::mix_seed;
use map::{KeyframeId, Map, PointId};

use super::last_frame::LastFrame;
use crate::guided::pose_by_ransac;
use crate::lost::Lost;
use crate::params::Params;
use crate::pose::{RefinedPose, refine};

/// Largest descriptor distance of a match that is not guided by a pose.
const MAX_DISTANCE_STRICT: u32 = 50;
/// Largest ratio of the best to the second-best distance.
const MAX_RATIO: f32 = 0.75;
/// Keyframes tried: the reference, its best covisible ones, the newest.
const MAX_CANDIDATES: usize = 5;
/// Purpose of the random numbers, so that no two uses share a stream.
const SEED_PURPOSE: u64 = 1;

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
    for keyframe in candidates(map, last.pose.keyframe) {
        let matches = match_keyframe(frame, map, keyframe);
        most_matches = most_matches.max(matches.len());
        if matches.len() < tracking.min_reference_matches {
            continue;
        }
        let seed = mix_seed(params.seed, u64::from(frame.index), SEED_PURPOSE + (u64::from(keyframe.0) << 8));
        let Some(initial) = pose_by_ransac(frame, map, &matches, params.weights, seed) else { continue };
        let pose = refine(frame, map, initial, &matches, params.noise());
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
