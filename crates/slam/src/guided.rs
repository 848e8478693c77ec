//! Points searched by projection with a pose that is roughly known, and a pose from matches alone.

use features::{Frame, ProjectionQuery, search_windows};
use geometry::{PnpEstimator, RansacOptions, SE3, Vec3, ransac};
use map::{KeyframeId, Map, PointId};
use optim::CHI2_MONO;

use crate::assign::one_to_one;
use crate::params::Weights;
use crate::visibility::project_visible;

/// How far from the projection and how different in appearance a match may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    /// Half width, pixels at octave 0.
    pub(crate) radius_px: f32,
    /// Largest descriptor distance, bits.
    pub(crate) max_distance: u32,
}

/// Matches found, and how many points could have been.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    /// Sorted by feature, one to one.
    pub(crate) matches: Vec<(u32, PointId)>,
    /// Points that should be visible, those that `given` already matched included.
    pub(crate) visible: usize,
}

/// Adds to the `given` matches of a frame those of other `points` that its pose makes visible.
pub(crate) fn search_points(
    frame: &Frame,
    map: &Map,
    cam_from_world: &SE3,
    points: &[PointId],
    given: &[(u32, PointId)],
    window: Window,
) -> Found {
    let mut free = vec![true; frame.len()];
    let mut taken: Vec<PointId> = Vec::with_capacity(given.len());
    for &(feature, id) in given {
        free[feature as usize] = false;
        taken.push(id);
    }
    taken.sort_unstable();
    let center = cam_from_world.center();
    let (mut ids, mut queries) = (Vec::new(), Vec::new());
    for &id in points.iter().filter(|id| taken.binary_search(id).is_err()) {
        let Some(point) = map.point(id) else { continue };
        let Some(seen) = project_visible(frame, cam_from_world, &center, point) else { continue };
        ids.push(id);
        queries.push(ProjectionQuery {
            x: seen.u as f32,
            y: seen.v as f32,
            right_u: seen.right_u as f32,
            radius_px: window.radius_px * frame.scales.scales[usize::from(seen.octave)],
            min_octave: seen.octave.saturating_sub(1),
            max_octave: seen.octave,
            descriptor: point.descriptor,
        });
    }
    let finds = search_windows(frame, &queries, &free);
    let new = one_to_one(&finds, frame.len(), |_, find| find.best.distance <= window.max_distance);
    let mut matches = given.to_vec();
    matches.extend(new.into_iter().map(|(feature, query)| (feature, ids[query])));
    matches.sort_unstable();
    Found { matches, visible: given.len() + ids.len() }
}

/// Points of a keyframe and of its `n` best covisible ones, sorted, each once.
pub(crate) fn points_around(map: &Map, keyframe: KeyframeId, n: usize) -> Vec<PointId> {
    let Some(center) = map.keyframe(keyframe) else { return Vec::new() };
    let around = center.best_covisible(n).iter().filter_map(|&(id, _)| map.keyframe(id));
    let mut points: Vec<PointId> =
        std::iter::once(center).chain(around).flat_map(|kf| kf.points().iter().flatten().copied()).collect();
    points.sort_unstable();
    points.dedup();
    points
}

/// Pose by P3P and RANSAC, samples and scores weighted by the features' activation if that counts.
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
        trust.push(weights.of_sample(frame, i));
    }
    let estimator = PnpEstimator::new(frame.rig.stereo.camera, &pixels, &points, &thresholds_sq);
    let options = RansacOptions { max_iterations: 300, confidence: 0.99, seed, ..RansacOptions::default() };
    ransac(&estimator, Some(&trust), &options).map(|found| found.model)
}
