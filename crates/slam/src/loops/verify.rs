//! Geometry of a loop candidate: matches by vocabulary node, weighted RANSAC, guided search, refinement, enough inliers.

use geometry::{RansacOptions, SE3, SightedPoints, Sim3, SimilarityEstimator, Vec2, Vec3, median, ransac};
use map::{Keyframe, KeyframeId, Map, PointId};

use super::outcome::NoLoop;
use crate::match_keyframe::{match_by_words, with_point};
use crate::params::Params;
use crate::pose::refine;
use crate::search::{Window, points_around, search_points};
use crate::seed::SeedPurpose;
use crate::world::World;

/// Error squared that RANSAC accepts, in variances (2 degrees of freedom, 99 %).
const CHI2: f64 = 9.21;
/// Keyframes around the candidate whose points are looked for.
const NEIGHBORS: usize = 15;
/// Windows of the guided searches, one after the other.
const WINDOWS: [Window; 2] =
    [Window { radius_px: 10.0, max_distance: 60 }, Window { radius_px: 5.0, max_distance: 75 }];

/// A candidate whose geometry holds.
#[derive(Clone, Debug)]
pub(super) struct Verified {
    pub(super) matched: KeyframeId,
    /// Pose of the current keyframe in the world (and the scale) of the earlier visit.
    pub(super) cam_from_world: SE3,
    /// Length around the current keyframe over the same length at the earlier visit.
    pub(super) scale: f64,
    /// Features of the current keyframe with the points of the earlier visit that they show.
    pub(super) matches: Vec<(u32, PointId)>,
    /// All points around the candidate.
    pub(super) earlier_points: Vec<PointId>,
}

/// Verifies that `candidate` shows the place of `keyframe`.
///
/// # Errors
/// The first test that fails, with its numbers.
pub(super) fn verify(
    candidate: KeyframeId,
    keyframe: KeyframeId,
    world: &World,
    params: &Params,
) -> Result<Verified, NoLoop> {
    let map = &world.map;
    let (Some(here), Some(there)) = (map.keyframe(keyframe), map.keyframe(candidate)) else {
        return Err(NoLoop::NoPlaces);
    };
    let pairs = match_places(here, there, world);
    let (found, needed) = (pairs.len(), params.loops.min_matches);
    if found < needed {
        return Err(NoLoop::TooFewMatches { found, needed });
    }
    let seed = SeedPurpose::LoopVerification.seed(params.seed, keyframe.0, candidate.0);
    let here_from_there = similarity(here, there, map, &pairs, params, seed)?;
    let rigid = SE3::new(here_from_there.rotation, here_from_there.translation / here_from_there.scale);
    let mut verified = Verified {
        matched: candidate,
        cam_from_world: rigid * there.cam_from_world,
        scale: here_from_there.scale,
        matches: Vec::new(),
        earlier_points: points_around(map, candidate, NEIGHBORS),
    };
    guided_refinement(&mut verified, here, map, params)?;
    if params.camera.sensor.is_scale_free() {
        verified.scale = scale_between(&verified, here, map);
    }
    Ok(verified)
}

/// Matches `(feature here, feature there)` of features that show points on both sides.
fn match_places(here: &Keyframe, there: &Keyframe, world: &World) -> Vec<(u32, u32)> {
    let Some((_, direct)) = world.places.of(here.id) else { return Vec::new() };
    match_by_words(&here.frame, direct, Some(&with_point(here)), there, &world.places)
}

/// What one camera knows of the matched points: places in its frame, pixels, squared thresholds.
fn sights(
    keyframe: &Keyframe,
    map: &Map,
    features: impl Iterator<Item = u32>,
) -> (Vec<Vec3>, Vec<Vec2>, Vec<f64>) {
    let shown = features.filter_map(|i| Some((i as usize, map.point(keyframe.point_at(i)?)?)));
    let (places, seen): (Vec<Vec3>, Vec<(Vec2, f64)>) = shown
        .map(|(i, point)| {
            let threshold_sq = CHI2 / keyframe.frame.inv_sigma_sq(i);
            (keyframe.cam_from_world * point.position, (keyframe.frame.pixel(i), threshold_sq))
        })
        .unzip();
    let (pixels, thresholds_sq) = seen.into_iter().unzip();
    (places, pixels, thresholds_sq)
}

/// `here_from_there` by RANSAC, matches weighted by the activation of both features.
fn similarity(
    here: &Keyframe,
    there: &Keyframe,
    map: &Map,
    pairs: &[(u32, u32)],
    params: &Params,
    seed: u64,
) -> Result<Sim3, NoLoop> {
    let [a, b] =
        [sights(here, map, pairs.iter().map(|p| p.0)), sights(there, map, pairs.iter().map(|p| p.1))];
    let [a, b] = [(here, &a), (there, &b)].map(|(keyframe, (points_cam, pixels, thresholds_sq))| {
        SightedPoints { camera: keyframe.frame.rig.stereo.camera, points_cam, pixels, thresholds_sq }
    });
    let weights: Vec<f64> = pairs
        .iter()
        .map(|&(i, j)| {
            let (i, j) = (i as usize, j as usize);
            params.weights.of_sample(&here.frame, i) * params.weights.of_sample(&there.frame, j)
        })
        .collect();
    let estimator = SimilarityEstimator::new(a, b, params.camera.sensor.is_scale_free());
    let options = RansacOptions {
        sample_size: SimilarityEstimator::SAMPLE_SIZE,
        max_iterations: 300,
        confidence: 0.99,
        seed,
    };
    let model = ransac(&estimator, Some(&weights), &options);
    let (found, needed) = (model.as_ref().map_or(0, |m| m.inliers.len()), params.loops.min_ransac_inliers);
    model.filter(|_| found >= needed).map(|m| m.model).ok_or(NoLoop::NoGeometry { found, needed })
}

/// Searches all points around the candidate with the pose known so far and refines it, in windows that narrow.
fn guided_refinement(
    verified: &mut Verified,
    here: &Keyframe,
    map: &Map,
    params: &Params,
) -> Result<(), NoLoop> {
    let (mut found, mut visible) = (0, 0);
    for window in WINDOWS {
        let searched = search_points(
            &here.frame,
            map,
            &verified.cam_from_world,
            &verified.earlier_points,
            &verified.matches,
            window,
        );
        let refined = refine(&here.frame, map, verified.cam_from_world, &searched.matches, params.noise());
        (found, visible) = (refined.inliers.len(), searched.visible.len() + verified.matches.len());
        if found < params.loops.min_ransac_inliers {
            break;
        }
        verified.cam_from_world = refined.cam_from_world;
        verified.matches = refined.inliers;
    }
    let share = (params.loops.min_inlier_share * visible as f64).ceil() as usize;
    let needed = params.loops.min_inliers.max(share);
    if found < needed { Err(NoLoop::TooFewInliers { found, needed, visible }) } else { Ok(()) }
}

/// The median ratio of a point's distance here to the same point's distance in the scale of the earlier visit.
fn scale_between(verified: &Verified, here: &Keyframe, map: &Map) -> f64 {
    let mut ratios: Vec<f64> = verified
        .matches
        .iter()
        .filter_map(|&(feature, earlier)| {
            let own = map.point(here.point_at(feature)?)?.position;
            let earlier = map.point(earlier)?.position;
            let ratio = (here.cam_from_world * own).norm() / (verified.cam_from_world * earlier).norm();
            (ratio.is_finite() && ratio > 0.0).then_some(ratio)
        })
        .collect();
    median(&mut ratios).unwrap_or(verified.scale)
}

#[cfg(test)]
#[path = "../../tests/steps/verify.rs"]
mod tests;
