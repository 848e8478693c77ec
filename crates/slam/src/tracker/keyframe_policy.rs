//! When a frame becomes a keyframe (ORB-SLAM2, Mur-Artal and Tardos 2017, section III-E), from counts and frame numbers, never from the clock.

use std::fmt;

use features::Frame;
use map::Map;

use super::Tracker;
use super::local_map::LocallyTracked;

/// Ratio below which tracking is weak, whatever the mapper does.
const WEAK_RATIO: f64 = 0.25;
/// Ratio of a map with a single keyframe.
const YOUNG_RATIO: f64 = 0.4;
/// With fewer inliers a keyframe would not be worth inserting.
const MIN_INLIERS: usize = 15;
/// Features of a frame for which the numbers of close points are made; with fewer they shrink in proportion.
const MANY_FEATURES: f64 = 2000.0;
/// With fewer inliers a keyframe is due while it still can be made.
const NEARLY_LOST: usize = 50;
/// Points of the reference count from this many observations on.
const MIN_OBSERVATIONS: usize = 3;

/// Why a frame became a keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyframeReason {
    /// The first of the map.
    First,
    /// Close points are running out while untracked ones are at hand.
    FewClose,
    /// Less than the wanted share of the reference keyframe's points is tracked.
    FewShared,
}

impl fmt::Display for KeyframeReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            KeyframeReason::First => "first",
            KeyframeReason::FewClose => "few close points",
            KeyframeReason::FewShared => "few shared points",
        })
    }
}

/// The counts that the decision is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Counts {
    pub(crate) frames_since_keyframe: u32,
    pub(crate) max_gap: u32,
    pub(crate) mapper_idle: bool,
    pub(crate) monocular: bool,
    pub(crate) n_keyframes: usize,
    pub(crate) reference_points: usize,
    pub(crate) inliers: usize,
    pub(crate) close_tracked: usize,
    pub(crate) close_untracked: usize,
    pub(crate) ratio: f64,
    pub(crate) close_tracked_min: usize,
    pub(crate) close_untracked_max: usize,
}

/// Conditions A (gap), B (idle mapper), C (weak) and D (worth it); a keyframe is due when (A or B or C) and D.
pub(crate) fn decide(counts: &Counts) -> Option<KeyframeReason> {
    let few_close = (counts.close_tracked < counts.close_tracked_min || counts.inliers < NEARLY_LOST)
        && counts.close_untracked > counts.close_untracked_max;
    let ratio = if counts.n_keyframes < 2 { YOUNG_RATIO } else { counts.ratio };
    let reference = counts.reference_points as f64;
    let few_shared = (counts.inliers as f64) < ratio * reference;
    let gap = counts.frames_since_keyframe >= counts.max_gap;
    // Without depth a keyframe in a hurry has no points of its own to give.
    let weak = !counts.monocular && ((counts.inliers as f64) < WEAK_RATIO * reference || few_close);
    let worth = (few_shared || few_close) && counts.inliers > MIN_INLIERS;
    if !((gap || counts.mapper_idle || weak) && worth) {
        return None;
    }
    Some(if few_close { KeyframeReason::FewClose } else { KeyframeReason::FewShared })
}

impl Tracker {
    /// Gathers the counts and decides.
    pub(super) fn decide_keyframe(
        &self,
        frame: &Frame,
        map: &Map,
        local: &LocallyTracked,
        mapper_idle: bool,
    ) -> Option<KeyframeReason> {
        if self.params.tracking.localize_only {
            return None;
        }
        let n_keyframes = map.n_keyframes();
        let min_observations = if n_keyframes <= 2 { MIN_OBSERVATIONS - 1 } else { MIN_OBSERVATIONS };
        let reference_points = map.keyframe(local.reference).map_or(0, |kf| {
            kf.points()
                .iter()
                .flatten()
                .filter(|&&id| map.point(id).is_some_and(|p| stereo_observations(map, p) >= min_observations))
                .count()
        });
        let close_depth = self.params.camera.close_depth_m as f32;
        let mut tracked = vec![false; frame.len()];
        for &(feature, _) in &local.matches {
            tracked[feature as usize] = true;
        }
        let close = |wanted: bool| {
            (0..frame.len()).filter(|&i| frame.depth[i] < close_depth && tracked[i] == wanted).count()
        };
        let scale = (frame.len() as f64 / MANY_FEATURES).min(1.0);
        decide(&Counts {
            frames_since_keyframe: frame.index.saturating_sub(self.last_keyframe_index),
            max_gap: self.params.camera.max_keyframe_gap,
            mapper_idle,
            monocular: self.params.camera.sensor.is_scale_free(),
            n_keyframes,
            reference_points,
            inliers: local.matches.len(),
            close_tracked: close(true),
            close_untracked: close(false),
            ratio: self.params.keyframe_ratio(),
            close_tracked_min: (scale * self.params.tracking.close_tracked_min as f64) as usize,
            close_untracked_max: (scale * self.params.tracking.close_untracked_max as f64) as usize,
        })
    }
}

/// Observations of a point, a stereo observation counting twice.
pub(crate) fn stereo_observations(map: &Map, point: &map::MapPoint) -> usize {
    point
        .observations()
        .iter()
        .filter_map(|o| {
            map.keyframe(o.keyframe).map(|kf| 1 + usize::from(kf.frame.has_depth(o.feature as usize)))
        })
        .sum()
}

#[cfg(test)]
#[path = "../../tests/steps/keyframe_policy.rs"]
mod tests;
