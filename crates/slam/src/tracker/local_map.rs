//! The local map: keyframes that share points with the frame, their points searched by projection, the final pose.

use std::collections::BTreeMap;
use std::sync::Arc;

use features::{Frame, WindowMatch};
use geometry::SE3;
use map::{KeyframeId, Map, PointCount, PointId};

use super::TrackStats;
use super::align::alignments;
use super::predict::{Attempt, Prediction};
use crate::params::{Params, TrackingParams};
use crate::pose::{RefinedPose, refine};
use crate::search::{Found, MAX_DISTANCE_WIDE, points_of, search_points_with};
use crate::visibility::Projection;

/// Best over second-best distance, asked for when both are on the same octave.
const MAX_RATIO: f32 = 0.8;
/// Search windows for points seen head-on and at an angle, pixels at octave 0.
const RADIUS_HEAD_ON_PX: f32 = 2.5;
const RADIUS_OBLIQUE_PX: f32 = 4.0;
/// Cosine of the viewing angle that counts as head-on.
const HEAD_ON_COS: f64 = 0.998;
/// Windows after a prediction without motion model are this much wider.
const WIDENING_WITHOUT_MOTION: f32 = 5.0;
/// Covisible keyframes that each voter may add one of.
const COVISIBLE_TRIED: usize = 10;

/// The part of the map around a frame.
#[derive(Clone, Debug)]
pub(crate) struct LocalMap {
    /// The keyframe that shares most points with the frame.
    reference: KeyframeId,
    /// Points of the local keyframes, sorted, each once.
    points: Vec<PointId>,
}

/// A frame tracked in the local map.
#[derive(Clone, Debug)]
pub(crate) struct LocallyTracked {
    pub(crate) cam_from_world: SE3,
    pub(crate) reference: KeyframeId,
    pub(crate) cam_from_reference: SE3,
    /// Inlier matches, sorted by feature.
    pub(crate) matches: Vec<(u32, PointId)>,
    /// All matches, inliers or not, sorted by feature.
    pub(crate) matched: Vec<(u32, PointId)>,
    pub(crate) counts: Vec<PointCount>,
    pub(crate) stats: TrackStats,
    /// The frame with its features where their points look the same, and by how much they were moved.
    pub(crate) aligned: Option<Arc<Frame>>,
    pub(crate) shifts: Vec<(u32, f32, f32)>,
}

impl LocalMap {
    /// Every match votes for the keyframes that see its point; voters and some of their neighbors give the points.
    pub(crate) fn gather(
        map: &Map,
        matches: &[(u32, PointId)],
        fallback: KeyframeId,
        params: &TrackingParams,
    ) -> Self {
        let mut votes: BTreeMap<KeyframeId, u32> = BTreeMap::new();
        for point in matches.iter().filter_map(|&(_, id)| map.point(id)) {
            for observation in point.observations() {
                *votes.entry(observation.keyframe).or_insert(0) += 1;
            }
        }
        // Most votes; ties go to the older keyframe.
        let reference = votes
            .iter()
            .max_by_key(|&(&id, &count)| (count, std::cmp::Reverse(id)))
            .map_or(fallback, |(&id, _)| id);
        let mut voters: Vec<(KeyframeId, u32)> = votes.into_iter().collect();
        voters.sort_by_key(|&(id, count)| (std::cmp::Reverse(count), id));
        let mut keyframes: Vec<KeyframeId> = voters.iter().map(|&(id, _)| id).collect();
        keyframes.truncate(params.max_local_keyframes);
        extend_with_neighbors(map, &mut keyframes, params.max_local_keyframes);
        LocalMap { reference, points: points_of(map, keyframes) }
    }

    /// Searches the points that the frame does not have yet and optimizes the pose with all matches.
    pub(crate) fn track(
        &self,
        frame: &Frame,
        map: &Map,
        predicted: &Prediction,
        params: &Params,
    ) -> LocallyTracked {
        let factor = params.camera.local_radius_factor;
        let mut start = predicted.clone();
        if predicted.is_rough() {
            // A rough pose: a first search in wide windows makes it a good one.
            let factor = factor.max(WIDENING_WITHOUT_MOTION);
            let (_, wide) = self.search_and_refine(frame, map, &start, factor, params);
            (start.cam_from_world, start.matches) = (wide.cam_from_world, wide.inliers);
        }
        let (found, mut refined) = self.search_and_refine(frame, map, &start, factor, params);
        let shifts = alignments(frame, map, &refined.cam_from_world, &refined.inliers);
        let aligned = (!shifts.is_empty()).then(|| Arc::new(frame.moved(&shifts)));
        if let Some(aligned) = &aligned {
            refined = refine(aligned, map, refined.cam_from_world, &found.matches, params.noise());
        }
        let counts = count(&found.visible, &start.matches, &refined.inliers);
        let stats = TrackStats {
            predicted: predicted.matches.len(),
            local_points: self.points.len(),
            visible: counts.len(),
            matches: found.matches.len(),
            inliers: refined.inliers.len(),
            without_motion_model: predicted.attempt != Attempt::Motion,
            relocalized: predicted.attempt == Attempt::Relocalization,
        };
        let reference_from_world =
            map.keyframe(self.reference).map_or(SE3::identity(), |kf| kf.cam_from_world);
        LocallyTracked {
            cam_from_world: refined.cam_from_world,
            reference: self.reference,
            cam_from_reference: (refined.cam_from_world * reference_from_world.inverse()).normalized(),
            matched: found.matches,
            matches: refined.inliers,
            counts,
            stats,
            aligned,
            shifts,
        }
    }

    /// Adds matches in windows of `factor` times the usual size and optimizes the pose with all.
    fn search_and_refine(
        &self,
        frame: &Frame,
        map: &Map,
        start: &Prediction,
        factor: f32,
        params: &Params,
    ) -> (Found, RefinedPose) {
        let radius_px = |seen: &Projection| {
            let radius = if seen.view_cos > HEAD_ON_COS { RADIUS_HEAD_ON_PX } else { RADIUS_OBLIQUE_PX };
            radius * factor
        };
        let Prediction { cam_from_world, matches, .. } = start;
        let found =
            search_points_with(frame, map, cam_from_world, &self.points, matches, radius_px, is_clear);
        let refined = refine(frame, map, *cam_from_world, &found.matches, params.noise());
        (found, refined)
    }
}

/// Similar enough, and clearly more so than another feature of the same octave.
fn is_clear(find: &WindowMatch) -> bool {
    let ambiguous = find.second.is_some_and(|second| {
        second.octave == find.best.octave && find.best.distance as f32 > MAX_RATIO * second.distance as f32
    });
    find.best.distance <= MAX_DISTANCE_WIDE && !ambiguous
}

/// For each voter the first unused among its best covisible keyframes, one child, and its parent.
fn extend_with_neighbors(map: &Map, keyframes: &mut Vec<KeyframeId>, max: usize) {
    let mut used = keyframes.clone();
    used.sort_unstable();
    let voters = keyframes.clone();
    let mut add = |keyframes: &mut Vec<KeyframeId>, id: KeyframeId| match used.binary_search(&id) {
        Ok(_) => false,
        Err(at) => {
            used.insert(at, id);
            keyframes.push(id);
            true
        }
    };
    for keyframe in voters.iter().filter_map(|&id| map.keyframe(id)) {
        if keyframes.len() >= max {
            return;
        }
        for &(id, _) in keyframe.best_covisible(COVISIBLE_TRIED) {
            if add(keyframes, id) {
                break;
            }
        }
        for &child in keyframe.children() {
            if add(keyframes, child) {
                break;
            }
        }
        if let Some(parent) = keyframe.parent() {
            add(keyframes, parent);
        }
    }
}

/// Statistics of the frame: matched and visible points were to be seen, inliers were found.
fn count(visible: &[PointId], matched: &[(u32, PointId)], inliers: &[(u32, PointId)]) -> Vec<PointCount> {
    let mut counts: BTreeMap<PointId, u32> = visible.iter().map(|&id| (id, 0)).collect();
    counts.extend(matched.iter().map(|&(_, id)| (id, 0)));
    for &(_, id) in inliers {
        counts.insert(id, 1);
    }
    counts.into_iter().map(|(point, found)| PointCount { point, seen: 1, found, evidence: 0 }).collect()
}

#[cfg(test)]
#[path = "../../tests/steps/local_map.rs"]
mod tests;
