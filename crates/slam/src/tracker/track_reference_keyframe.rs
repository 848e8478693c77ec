//! A pose without prediction, from the reference keyframe and those around it (ORB-SLAM2's TrackReferenceKeyFrame):
//! descriptors matched, then P3P with weighted RANSAC.

use features::Frame;
use map::{KeyframeId, Map};

use super::last_frame::LastFrame;
use crate::lost::Lost;
use crate::match_keyframe::match_all;
use crate::params::Params;
use crate::pose::{RefinedPose, pose_by_ransac, refine};
use crate::seed::SeedPurpose;

/// Keyframes tried: the reference, its best covisible ones, the newest.
const MAX_CANDIDATES: usize = 5;

/// Tries keyframes in turn; the first good pose is returned, else the best reason.
pub(super) fn track_reference_keyframe(
    frame: &Frame,
    map: &Map,
    last: &LastFrame,
    params: &Params,
) -> Result<RefinedPose, Lost> {
    let tracking = &params.tracking;
    let mut most_matches = 0;
    let mut most_inliers = None;
    for keyframe in candidates(map, last.pose.keyframe).into_iter().filter_map(|id| map.keyframe(id)) {
        let matches = match_all(frame, keyframe);
        most_matches = most_matches.max(matches.len());
        if matches.len() < tracking.min_reference_matches {
            continue;
        }
        let seed = SeedPurpose::ReferenceKeyframe.seed(params.seed, frame.index, keyframe.id.0);
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

#[cfg(test)]
#[path = "../../tests/steps/track_reference_keyframe.rs"]
mod tests;
