//! Keyframes whose close points are nearly all seen by at least three others say nothing new.

use map::{KeyframeId, Map};

use super::Mapper;
use crate::params::Params;

/// Observers, at the same or a finer scale, that make an observation redundant.
const MIN_OBSERVERS: usize = 3;

impl Mapper {
    /// Removes redundant keyframes among the covisible ones of `keyframe`; never the first, never the newest.
    pub(super) fn cull_keyframes(&mut self, keyframe: KeyframeId) -> usize {
        let Some(center) = self.world.map.keyframe(keyframe) else { return 0 };
        let candidates = center.covisible_at_least(self.params.mapping.min_covisible_weight).to_vec();
        let mut removed = 0;
        for (id, _) in candidates {
            // The map itself keeps its roots.
            if is_redundant(&self.world.map, id, &self.params) && self.world.map.remove_keyframe(id).is_ok() {
                self.world.places.remove(id);
                removed += 1;
            }
        }
        removed
    }
}

fn is_redundant(map: &Map, id: KeyframeId, params: &Params) -> bool {
    let (ratio, close_depth_m) = (params.mapping.keyframe_cull_ratio, params.camera.close_depth_m);
    let Some(keyframe) = map.keyframe(id) else { return false };
    let mut n_points = 0;
    let mut n_redundant = 0;
    for (feature, point) in keyframe.points().iter().enumerate() {
        let Some(point) = point.and_then(|id| map.point(id)) else { continue };
        let depth = f64::from(keyframe.frame.depth[feature]);
        if !params.camera.sensor.is_scale_free() && (depth.is_nan() || depth > close_depth_m) {
            continue;
        }
        n_points += 1;
        let octave = keyframe.frame.keypoints[feature].octave;
        let others = point
            .observations()
            .iter()
            .filter(|o| o.keyframe != id)
            .filter_map(|o| map.keyframe(o.keyframe).map(|kf| kf.frame.keypoints[o.feature as usize].octave))
            .filter(|&other| other <= octave + 1)
            .take(MIN_OBSERVERS)
            .count();
        n_redundant += usize::from(others >= MIN_OBSERVERS);
    }
    n_points > 0 && n_redundant as f64 > ratio * n_points as f64
}

#[cfg(test)]
#[path = "../../tests/steps/cull_keyframes.rs"]
mod tests;
