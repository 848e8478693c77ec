//! A pose from the place index: keyframes that look alike, P3P with weighted RANSAC, guided search (orbslam2.md section 6).

use bow::{MatchOptions, MatchSide, Transformed, match_by_node};
use features::Frame;
use geometry::mix_seed;
use map::{Keyframe, PointId};

use crate::guided::{Window, points_around, pose_by_ransac, search_points};
use crate::loops::strongest_groups;
use crate::lost::Lost;
use crate::params::Params;
use crate::pose::{RefinedPose, refine};
use crate::world::World;

/// Candidates tried, best first.
const MAX_CANDIDATES: usize = 8;
/// Inliers that make a relocalisation certain.
const MIN_INLIERS: usize = 50;
/// Keyframes around a candidate whose points are looked for.
const NEIGHBOURS: usize = 5;
/// Windows of the guided searches, one after the other, until there are enough inliers.
const WINDOWS: [Window; 2] =
    [Window { radius_px: 10.0, max_distance: 100 }, Window { radius_px: 3.0, max_distance: 64 }];
/// Purpose of the random numbers, so that no two uses share a stream.
const SEED_PURPOSE: u64 = 2;

/// Tries the places that look like the frame in turn; the first good pose is returned, else the best reason.
pub(super) fn relocalise(frame: &Frame, world: &World, params: &Params) -> Result<RefinedPose, Lost> {
    let needed = params.tracking.min_reference_matches;
    let mut best = Lost::TooFewMatches { found: 0, needed };
    let Some(seen) = world.places.describe(frame) else { return Err(best) };
    let alike = world.places.index().query(&seen.bow, |_| false);
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
    let matches = match_keyframe(frame, seen, keyframe, world);
    let (found, needed) = (matches.len(), params.tracking.min_reference_matches);
    if found < needed {
        return Err(Lost::TooFewMatches { found, needed });
    }
    let purpose = SEED_PURPOSE + (u64::from(keyframe.id.0) << 8);
    let seed = mix_seed(params.seed, u64::from(frame.index), purpose);
    let few = |found| Lost::TooFewPredictedInliers { found, needed: MIN_INLIERS };
    let initial = pose_by_ransac(frame, map, &matches, params.weights, seed).ok_or(few(0))?;
    let mut pose = refine(frame, map, initial, &matches, params.noise());
    let points = points_around(map, keyframe.id, NEIGHBOURS);
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

/// Features of the frame that look like points of the keyframe, under common nodes of the vocabulary.
fn match_keyframe(
    frame: &Frame,
    seen: &Transformed,
    keyframe: &Keyframe,
    world: &World,
) -> Vec<(u32, PointId)> {
    let Some((_, direct)) = world.places.of(keyframe.id) else { return Vec::new() };
    let with_point: Vec<bool> = keyframe.points().iter().map(Option::is_some).collect();
    let here = MatchSide {
        descriptors: &frame.descriptors,
        direct: &seen.direct,
        keypoints: Some(&frame.keypoints),
        eligible: None,
    };
    let there = MatchSide {
        descriptors: &keyframe.frame.descriptors,
        direct,
        keypoints: Some(&keyframe.frame.keypoints),
        eligible: Some(&with_point),
    };
    match_by_node(&here, &there, &MatchOptions::default())
        .into_iter()
        .filter_map(|m| Some((m.a, keyframe.point_at(m.b)?)))
        .collect()
}
