//! What each tracked frame is worth: remembers the last frames, so that the covariance can be that of the motion since then.
//! Tracking itself asks nothing of it.

use std::collections::VecDeque;

use features::Frame;
use geometry::{PoseCovariance, SE3, Vec6};
use map::{KeyframeId, Map, MapPoint, PointId};

use super::last_frame::LastFrame;
use super::local_map::LocallyTracked;
use super::residuals::Residuals;
use crate::assess::{Assessment, COVARIANCE_FRAMES};
use crate::covariance::{MAX_KEYFRAMES, Sight, Window};
use crate::noise::information;
use crate::params::Params;
use crate::quality::{Signs, quality};

/// Points that a covariance is made from, evenly taken from all.
const MAX_POINTS: usize = 200;
/// Points that a keyframe must see to be of use.
const MIN_VOTES: usize = 10;
/// Lengths of the map are off by this part of them (standard deviation): what all disparities have in common. No factor for what
/// remains is applied: rendered towns ask for 0.8 to 1.1 (docs/evaluation.md).
const SCALE_SIGMA: f64 = 0.001;

/// The memory of the last frames.
#[derive(Clone, Debug, Default)]
pub(super) struct Assessor {
    /// The last tracked frames, oldest first, none with a loss behind it.
    past: VecDeque<LastFrame>,
    /// How well points fitted in these frames and the present one.
    residuals: VecDeque<Residuals>,
    /// Frames since a lost camera found its place again.
    since_relocalized: Option<u32>,
}

/// Mean variances over the last frames, in units of the expected one.
#[derive(Clone, Copy)]
struct Measured {
    pixel_sq: f64,
    disparity_sq: f64,
    in_common: f64,
}

/// A point of the map that is seen by the frame, by the earlier view, or by both.
struct Shared<'a> {
    point: &'a MapPoint,
    /// Feature of the frame.
    now: Option<u32>,
    /// Feature of the earlier view.
    then: Option<u32>,
}

impl Assessor {
    /// Nothing before a loss is looked back to.
    pub(super) fn forget(&mut self) {
        *self = Assessor::default();
    }

    /// The last frames without a loss behind them, oldest first.
    pub(super) fn past(&self) -> impl Iterator<Item = &LastFrame> {
        self.past.iter()
    }

    /// Remembers a tracked frame.
    pub(super) fn remember(&mut self, last: LastFrame) {
        if self.past.len() == COVARIANCE_FRAMES {
            self.past.pop_front();
        }
        self.past.push_back(last);
    }

    /// Judges a tracked frame, before it is remembered.
    pub(super) fn assess(
        &mut self,
        frame: &Frame,
        map: &Map,
        local: &LocallyTracked,
        params: &Params,
    ) -> Assessment {
        if local.stats.relocalized {
            self.forget();
            self.since_relocalized = Some(0);
        }
        let since_relocalized = self.since_relocalized;
        self.since_relocalized = since_relocalized.map(|n| n.saturating_add(1));
        let camera = &params.camera;
        let noise = params.noise();
        let Some(found) = Residuals::of(frame, map, local, noise, camera.close_depth_m) else {
            return Assessment::default();
        };
        if self.residuals.len() == COVARIANCE_FRAMES {
            self.residuals.pop_front();
        }
        self.residuals.push_back(found);
        let covariance = self.covariance(frame, map, local, params);
        let (quality, reasons) = quality(&Signs {
            inliers: local.matches.len(),
            needed: params.tracking.min_inliers,
            cells: found.cells,
            sigma: covariance.map(|c| [c.sigma_m().max() / found.median_depth_m, c.sigma_deg().max()]),
            near: (!camera.sensor.is_scale_free()).then_some(found.near),
            residual: found.pixel_sq.sqrt(),
            since_relocalized,
            without_motion_model: local.stats.without_motion_model,
        });
        let residual_px = Some(noise.sigma_px * found.pixel_sq.sqrt());
        Assessment { covariance, residual_px, quality, reasons }
    }

    /// Of the motion since the oldest frame that is remembered, without any since the reference keyframe.
    fn covariance(
        &self,
        frame: &Frame,
        map: &Map,
        local: &LocallyTracked,
        params: &Params,
    ) -> Option<PoseCovariance> {
        let past = match self.past.front() {
            Some(past) => past.clone().refreshed(map),
            None => LastFrame::of_keyframe(map, local.reference)?,
        };
        let measured = self.measured();
        let motion = local.cam_from_world * past.cam_from_world(map).inverse();
        let random = window_covariance(frame, map, local, &past, params, measured)? * measured.in_common;
        let along = Vec6::from_fn(|i, _| if i < 3 { SCALE_SIGMA * motion.translation[i] } else { 0.0 });
        PoseCovariance::new(random + along * along.transpose())
    }

    fn measured(&self) -> Measured {
        let n = self.residuals.len().max(1) as f64;
        let mean = |of: fn(&Residuals) -> f64| self.residuals.iter().map(of).sum::<f64>() / n;
        Measured {
            pixel_sq: mean(|r| r.pixel_sq),
            disparity_sq: mean(|r| r.disparity_sq),
            in_common: mean(|r| r.in_common),
        }
    }
}

/// By the noise as measured, as if each point had its own error.
fn window_covariance(
    frame: &Frame,
    map: &Map,
    local: &LocallyTracked,
    past: &LastFrame,
    params: &Params,
    measured: Measured,
) -> Option<geometry::Mat6> {
    let all = in_either(&local.matches, &past.matches);
    let stride = all.len().div_ceil(MAX_POINTS).max(1);
    let sampled = all.iter().step_by(stride);
    let shared: Vec<Shared<'_>> =
        sampled.filter_map(|&(id, now, then)| Some(Shared { point: map.point(id)?, now, then })).collect();
    let same = map.keyframe(past.pose.keyframe).filter(|keyframe| keyframe.frame.is_same(&past.frame));
    let keyframes = most_voted(&shared, same.map(|keyframe| keyframe.id));
    let living: Vec<_> = keyframes.iter().filter_map(|&id| map.keyframe(id)).collect();
    let mut views: Vec<SE3> = vec![past.cam_from_world(map)];
    views.extend(living.iter().map(|keyframe| keyframe.cam_from_world));
    views.push(local.cam_from_world);
    let (last, noise) = (views.len() - 1, params.noise());
    let mut window = Window::new(frame.rig.stereo, views);
    let sight = |view: usize, frame: &Frame, feature: u32, times: f64| {
        let i = feature as usize;
        let information = times * information(frame, i, noise);
        let disparity = if frame.has_depth(i) { information / measured.disparity_sq } else { 0.0 };
        Sight { view, pixel: information / measured.pixel_sq, disparity }
    };
    let mut sights = Vec::with_capacity(MAX_KEYFRAMES + 2);
    for Shared { point, now, then } in &shared {
        sights.clear();
        sights.extend(then.map(|feature| sight(0, &past.frame, feature, 1.0)));
        let seen = living.iter().zip(1..).filter_map(|(keyframe, view)| {
            point.feature_in(keyframe.id).map(|feature| (*keyframe, view, feature))
        });
        // Keyframes that are not among the views count through those that are.
        let times = (point.n_observations() as f64 / seen.clone().count().max(1) as f64).max(1.0);
        sights.extend(seen.map(|(keyframe, view, feature)| sight(view, &keyframe.frame, feature, times)));
        sights.extend(now.map(|feature| sight(last, frame, feature, 1.0)));
        window.add(&point.position, &sights);
    }
    if params.camera.sensor.is_scale_free() && living.len() >= 2 {
        window.hold_distance(1, 2);
    }
    let share = shared.len() as f64 / all.len() as f64;
    window.marginal_of_last().map(|covariance| covariance * share)
}

/// Points of the matches of two frames, with their features there: those of the first in its order, then the others of the second.
fn in_either(now: &[(u32, PointId)], then: &[(u32, PointId)]) -> Vec<(PointId, Option<u32>, Option<u32>)> {
    let by_point = |matches: &[(u32, PointId)]| {
        let mut sorted: Vec<(PointId, u32)> = matches.iter().map(|&(feature, id)| (id, feature)).collect();
        sorted.sort_unstable();
        sorted
    };
    let (sorted_now, sorted_then) = (by_point(now), by_point(then));
    let find = |sorted: &[(PointId, u32)], id: PointId| {
        sorted.binary_search_by_key(&id, |&(id, _)| id).ok().map(|at| sorted[at].1)
    };
    let first = now.iter().map(|&(feature, id)| (id, Some(feature), find(&sorted_then, id)));
    let others = then.iter().filter(|&&(_, id)| find(&sorted_now, id).is_none());
    first.chain(others.map(|&(feature, id)| (id, None, Some(feature)))).collect()
}

/// The keyframes that see most of the points, ties by id.
fn most_voted(shared: &[Shared<'_>], but: Option<KeyframeId>) -> Vec<KeyframeId> {
    let observations = shared.iter().flat_map(|shared| shared.point.observations());
    let mut seen: Vec<KeyframeId> = observations.map(|o| o.keyframe).filter(|&id| Some(id) != but).collect();
    seen.sort_unstable();
    let mut votes: Vec<(usize, KeyframeId)> =
        seen.chunk_by(|a, b| a == b).map(|same| (same.len(), same[0])).collect();
    votes.retain(|&(votes, _)| votes >= MIN_VOTES);
    votes.sort_by_key(|&(votes, id)| (std::cmp::Reverse(votes), id));
    votes.iter().take(MAX_KEYFRAMES).map(|&(_, id)| id).collect()
}

#[cfg(test)]
#[path = "../../tests/steps/assessor.rs"]
mod tests;
