//! A pose from the keyframe database: keyframes that look alike, P3P with weighted RANSAC, guided search (ORB-SLAM,
//! Mur-Artal et al. 2015, section V-C).

use bow::Transformed;
use features::Frame;
use map::{Keyframe, PointId};

use crate::loops::strongest_groups;
use crate::lost::Lost;
use crate::match_keyframe::match_by_words;
use crate::params::Params;
use crate::pose::{RefinedPose, pose_by_ransac, refine};
use crate::search::{Window, points_around, search_points};
use crate::seed::SeedPurpose;
use crate::world::World;

/// Candidates tried, best first.
const MAX_CANDIDATES: usize = 8;
/// Inliers that make a relocalization certain.
const MIN_INLIERS: usize = 50;
/// Keyframes around a candidate whose points are looked for.
const NEIGHBORS: usize = 5;
/// Windows of the guided searches, one after the other, until there are enough inliers.
const WINDOWS: [Window; 2] =
    [Window { radius_px: 10.0, max_distance: 100 }, Window { radius_px: 3.0, max_distance: 64 }];

/// Tries the places that look like the frame in turn; the first good pose is returned, else the best reason.
pub(super) fn relocalize(frame: &Frame, world: &World, params: &Params) -> Result<RefinedPose, Lost> {
    let needed = params.tracking.min_reference_matches;
    let mut best = Lost::TooFewMatches { found: 0, needed };
    let Some(seen) = world.places.describe(frame) else { return Err(best) };
    let alike = world.places.alike(&seen.bow, |_| true);
    for candidate in strongest_groups(&world.map, &alike, 0.0).into_iter().take(MAX_CANDIDATES) {
        let Some(keyframe) = world.map.keyframe(candidate) else { continue };
        match from_keyframe(frame, &seen, keyframe, world, params) {
            Ok(pose) => return Ok(pose),
            Err(reason) => best = best.further(reason),
        }
    }
    Err(best)
}

fn from_keyframe(
    frame: &Frame,
    seen: &Transformed,
    keyframe: &Keyframe,
    world: &World,
    params: &Params,
) -> Result<RefinedPose, Lost> {
    let map = &world.map;
    let pairs = match_by_words(frame, &seen.direct, None, keyframe, &world.places);
    let shown = pairs.into_iter().filter_map(|(feature, there)| Some((feature, keyframe.point_at(there)?)));
    let matches: Vec<(u32, PointId)> = shown.collect();
    let (found, needed) = (matches.len(), params.tracking.min_reference_matches);
    if found < needed {
        return Err(Lost::TooFewMatches { found, needed });
    }
    let seed = SeedPurpose::Relocalization.seed(params.seed, frame.index, keyframe.id.0);
    let few = |found| Lost::TooFewPredictedInliers { found, needed: MIN_INLIERS };
    let initial = pose_by_ransac(frame, map, &matches, params.weights, seed).ok_or(few(0))?;
    let mut pose = refine(frame, map, initial, &matches, params.noise());
    let points = points_around(map, keyframe.id, NEIGHBORS);
    for window in WINDOWS {
        let found = pose.inliers.len();
        if found < params.tracking.min_predicted_inliers {
            return Err(few(found));
        }
        if found >= MIN_INLIERS {
            break;
        }
        let searched = search_points(frame, map, &pose.cam_from_world, &points, &pose.inliers, window);
        pose = refine(frame, map, pose.cam_from_world, &searched.matches, params.noise());
    }
    if pose.inliers.len() >= MIN_INLIERS { Ok(pose) } else { Err(few(pose.inliers.len())) }
}

#[cfg(test)]
#[path = "../../tests/steps/relocalize.rs"]
mod tests;
